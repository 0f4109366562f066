//! The metadata of a baked file as pairs of key and text, which are identical in KTX2 and EXR.

use super::blocks::{Slot, rest_name, stored_names};
use super::classes::ClassPlan;
use super::{CLASS_CHANNELS, Kind, Plan, Report};
use crate::Wrap;

/// Returns the keys and their texts in no particular order. `slots` gives the plan's channel for each channel of the file.
/// The length of a text does not depend on `report`.
pub(super) fn keys(plan: &Plan, slots: &[Option<usize>], report: Option<&Report>) -> Vec<(&'static str, String)> {
    let per_slot = |of: &dyn Fn(usize) -> String, none: &str| {
        slots.iter().map(|slot| slot.map_or(none.into(), of)).collect::<Vec<String>>().join(" ")
    };
    let number = |v: f64| format!("{v:>+13.6e}");
    let levels = plan.level_sizes().len();
    let errors: Vec<String> =
        (0..levels).map(|i| format!("{:>10.3e}", report.map_or(0.0, |r| r.errors[i].channels))).collect();
    let range = |c: usize| report.map_or([0.0; 2], |r| r.channel_ranges[c]).map(number).join(" ");
    let ranges = match plan.blocks {
        // The ranges are listed by map channel, not by slot.
        Some(_) => (0..plan.channels.len()).map(range).collect::<Vec<_>>().join(" "),
        None => per_slot(&range, &[0.0, 0.0].map(number).join(" ")),
    };
    let frame = match plan.kind {
        Kind::Leadr => "slopes per unit of texture coordinate, s right, t down",
        _ => "rise over run in the tangent frame, y up, square texels",
    };
    let heights = match (plan.has_heights, plan.in_widths) {
        (false, _) => "none",
        (true, false) => "map",
        (true, true) => "width",
    };
    let (channels, factors, offsets) = match &plan.blocks {
        None => {
            let channels = per_slot(&|c| plan.channels[c].to_owned(), "-");
            (channels, per_slot(&|c| format!("{:e}", plan.factors[c]), "1e0"), None)
        }
        Some(blocks) => {
            let own: Vec<String> = plan.channels.iter().map(|&name| name.to_owned()).collect();
            let names = stored_names(plan.kind, &own);
            let name = |(channel, rest): Slot| rest_name(&names[channel], rest);
            let named: Vec<String> = blocks.slots.iter().map(|slot| slot.map_or("-".to_owned(), name)).collect();
            let numbers =
                |i: usize| blocks.scales.iter().map(|scale| format!("{:e}", scale[i])).collect::<Vec<_>>().join(" ");
            (named.join(" "), numbers(0), Some(numbers(1)))
        }
    };
    let mut keys = vec![
        ("leadr.channels", channels),
        ("leadr.dropped_levels", plan.dropped_levels.to_string()),
        ("leadr.error", errors.join(" ")),
        ("leadr.factors", factors),
        // The `{:e}` format gives the shortest text that reproduces the number.
        ("leadr.height_scale", format!("{:e}", plan.height_scale)),
        ("leadr.heights", heights.to_owned()),
        ("leadr.middle", format!("{:e}", plan.middle)),
        ("leadr.kind", plan.kind.name().to_owned()),
        ("leadr.ranges", ranges),
        ("leadr.slopes", if plan.has_normals { "normals" } else { "heights" }.to_owned()),
        ("leadr.units", frame.to_owned()),
        ("leadr.wrap", if plan.wrap == Wrap::Repeat { "repeat" } else { "clamp" }.to_owned()),
    ];
    keys.extend(offsets.map(|offsets| ("leadr.offsets", offsets)));
    if let Some(ClassPlan { frame, open, .. }) = &plan.classes {
        let numbers = |values: &[f32]| values.iter().map(|v| format!("{v:e}")).collect::<Vec<_>>().join(" ");
        keys.push(("leadr.class_openness", open.text()));
        keys.push(("leadr.class_centers", numbers(frame.centers.as_flattened())));
        keys.push(("leadr.class_units", numbers(&frame.units)));
    }
    keys
}

/// Returns the map channel in each slot of the layers. A layer has four slots. Colour and each class start a new layer.
pub(crate) fn packed(channels: &[impl AsRef<str>]) -> Vec<Option<usize>> {
    let mut slots: Vec<Option<usize>> = Vec::new();
    for (i, name) in channels.iter().enumerate() {
        if name.as_ref() == "red" || CLASS_CHANNELS.iter().any(|class| class[0] == name.as_ref()) {
            slots.resize(slots.len().next_multiple_of(4), None);
        }
        slots.push(Some(i));
    }
    slots.resize(slots.len().next_multiple_of(4), None);
    slots
}
