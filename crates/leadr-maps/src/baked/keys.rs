//! The metadata keys of a baked file.

use super::map::{BakedLevel, BakedMap, HeightUnit, REMEDY};
use crate::bake::blocks::{BlockPlan, Slot, of_rest_name, stored_names};
use crate::bake::{CLASS_CHANNELS, HEIGHT_REST, Kind, Precision};
use crate::derive::Openness;
use crate::{ClassFrame, MapFault, Wrap};

pub(super) struct Keys {
    /// The map, still without levels. The channels are in the order of the file.
    pub map: BakedMap,
    /// The factor by which the file multiplies each channel.
    pub factors: Vec<f64>,
    /// The block layout, if the file is block-compressed. The channels of `map` are then the channels before compression.
    pub blocks: Option<BlockPlan>,
}

impl Keys {
    /// Parses and checks the keys of a file with `count` channels. `find` returns the text of a key.
    pub fn new<'a>(
        find: impl Fn(&str) -> Option<&'a str>,
        count: usize,
        precision: Precision,
    ) -> Result<Self, MapFault> {
        let missing = |key: &str| MapFault::unsupported(format!("its key {key} is missing, or not text"), REMEDY);
        let value = |key: &str| find(key).ok_or_else(|| missing(key));
        let wrong = |key: &str| MapFault::damaged(format!("its key {key} is invalid"));
        let name = value("leadr.kind")?;
        let kind = Kind::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| wrong("leadr.kind"))?;
        let mut channels: Vec<String> = value("leadr.channels")?.split(' ').map(str::to_owned).collect();
        if channels.len() != count {
            return Err(wrong("leadr.channels"));
        }
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        let numbers = |key: &str| -> Result<Vec<f64>, MapFault> {
            let all: Option<Vec<f64>> = value(key)?.split(' ').map(number).collect();
            all.filter(|all| all.len() == count).ok_or_else(|| wrong(key))
        };
        let factors = numbers("leadr.factors")?;
        if factors.iter().any(|factor| *factor <= 0.0) {
            return Err(wrong("leadr.factors"));
        }
        let mut blocks = None;
        if precision == Precision::Bc {
            let (own, slots) = channels_of_blocks(kind, &channels).ok_or_else(|| wrong("leadr.channels"))?;
            blocks = Some(BlockPlan::of_slots(kind, &own, slots, &factors, &numbers("leadr.offsets")?));
            channels = own;
        }
        let named = channels.iter().zip(kind.channels()).all(|(a, b)| a == b);
        if !named || channels.len() < kind.channels().len() {
            return Err(wrong("leadr.channels"));
        }
        let wrap = match value("leadr.wrap")? {
            "repeat" => Wrap::Repeat,
            "clamp" => Wrap::Clamp,
            _ => return Err(wrong("leadr.wrap")),
        };
        let heights = match value("leadr.heights")? {
            "none" => HeightUnit::None,
            "map" => HeightUnit::Map,
            "width" => HeightUnit::Width,
            _ => return Err(wrong("leadr.heights")),
        };
        let of_normals = match value("leadr.slopes")? {
            "heights" => false,
            "normals" => true,
            _ => return Err(wrong("leadr.slopes")),
        };
        let single = |key: &str| {
            let number = number(value(key)?).map(|v| v as f32).filter(|v| v.is_finite());
            number.ok_or_else(|| wrong(key))
        };
        // Files of earlier versions contain all levels.
        let dropped_levels = match find("leadr.dropped_levels") {
            Some(text) => text.parse().map_err(|_| wrong("leadr.dropped_levels"))?,
            None => 0,
        };
        let (height_scale, middle) = (single("leadr.height_scale")?, single("leadr.middle")?);
        let classes = match classes_in(&channels) {
            0 => None,
            count => {
                let several = |key: &str, length: usize| {
                    let all = value(key)?.split(' ').map(|text| number(text).map(|v| v as f32));
                    let all: Option<Vec<f32>> = all.map(|v| v.filter(|v| v.is_finite())).collect();
                    all.filter(|all| all.len() == length).ok_or_else(|| wrong(key))
                };
                let has_all =
                    CLASS_CHANNELS[..count].as_flattened().iter().all(|name| channels.iter().any(|c| c == name));
                if kind != Kind::Leadr || count < 2 || !has_all {
                    return Err(wrong("leadr.channels"));
                }
                let centers = several("leadr.class_centers", 3 * count)?.as_chunks().0.to_vec();
                let units: [f32; 3] = several("leadr.class_units", 3)?.try_into().expect("three numbers");
                if units.iter().any(|unit| *unit <= 0.0) {
                    return Err(wrong("leadr.class_units"));
                }
                Some(ClassFrame { centers, units })
            }
        };
        let openness = match find("leadr.class_openness").filter(|_| classes.is_some()) {
            Some(text) => Openness::of_text(text).ok_or_else(|| wrong("leadr.class_openness"))?,
            None => None,
        };
        let map = BakedMap {
            kind,
            precision,
            channels,
            wrap,
            height_scale,
            heights,
            middle,
            of_normals,
            dropped_levels,
            classes,
            openness,
            levels: Vec::new(),
        };
        Ok(Self { map, factors, blocks })
    }

    /// Returns the complete map with the given levels.
    pub fn map(self, mut levels: Vec<BakedLevel>) -> BakedMap {
        let mut channels = self.map.channels;
        let index_of = |name: &str| channels.iter().position(|channel| channel == name);
        if let (Some(height), Some(rest)) = (index_of("height"), index_of(HEIGHT_REST)) {
            for level in &mut levels {
                for i in 0..level.layers[0].len() {
                    let left = std::mem::take(&mut level.layers[rest / 4][i][rest % 4]);
                    level.layers[height / 4][i][height % 4] += left;
                }
            }
            channels[rest] = "-".to_owned();
        }
        // Each layer of a level in memory has four channels.
        channels.resize(channels.len().next_multiple_of(4), "-".to_owned());
        BakedMap { channels, levels, ..self.map }
    }
}

/// Returns the number of classes in a file with these channels.
fn classes_in(channels: &[String]) -> usize {
    CLASS_CHANNELS.iter().take_while(|class| channels.iter().any(|name| name == class[0])).count()
}

/// Parses the channel names of block layers. Returns the map channels, and the content of each slot.
fn channels_of_blocks(kind: Kind, names: &[String]) -> Option<(Vec<String>, Vec<Option<Slot>>)> {
    let mut channels: Vec<String> = kind.channels().iter().map(|&name| name.to_owned()).collect();
    for more in [&["alpha2", "alpha4"][..], &["red", "green", "blue"]] {
        if names.iter().any(|name| name == more[0]) {
            channels.extend(more.iter().map(|&name| name.to_owned()));
        }
    }
    channels.extend(CLASS_CHANNELS[..classes_in(names)].as_flattened().iter().map(|&name| name.to_owned()));
    let stored = stored_names(kind, &channels);
    let slot = |name: &String| -> Option<Option<Slot>> {
        if name == "-" {
            return Some(None);
        }
        let (name, rest) = of_rest_name(name)?;
        Some(Some((stored.iter().position(|stored| stored == name)?, rest)))
    };
    let slots = names.iter().map(slot).collect::<Option<Vec<_>>>()?;
    // Every channel must have its value, and its residuals must be numbered without gaps.
    let whole = |channel: usize| {
        let mut rests: Vec<usize> = slots.iter().flatten().filter(|s| s.0 == channel).map(|s| s.1).collect();
        rests.sort_unstable();
        !rests.is_empty() && rests.iter().copied().eq(0..rests.len())
    };
    (0..channels.len()).all(whole).then_some((channels, slots))
}

pub(super) fn names(channels: &[String], slots: &[Option<usize>]) -> Vec<String> {
    slots.iter().map(|slot| slot.map_or("-".to_owned(), |i| channels[i].clone())).collect()
}
