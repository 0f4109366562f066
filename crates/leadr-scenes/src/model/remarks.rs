//! What of a model is not drawn, in words.

use super::charts::Charts;
use super::parts::Parts;
use leadr_maps::material::{Material, Opacity};
use leadr_models::{Model, Projection};
use leadr_render::scene::MAX_POINT_LIGHTS;

/// A sentence for each thing that the picture leaves out or changes. `camera`: the node that it is seen from, if it is one of the file's.
pub fn of(model: &Model, parts: &Parts, charts: &[(Charts, Material)], camera: Option<usize>) -> Vec<String> {
    let mut remarks = model.remarks.clone();
    for (object, (charts, _)) in parts.objects.iter().zip(charts) {
        let material = &model.materials[object.material];
        let name = &material.name;
        let mut say = |what: &str| remarks.push(format!("material {name}: {what}"));
        if matches!(material.opacity, Opacity::Blend { .. }) {
            say(
                "nothing here is transparent: as large a share of the samples sees it as it is opaque, so give it many samples",
            );
        }
        if material.anisotropy.is_some() && material.relief.is_some() && material.normal_map.is_none() {
            say("its roughness is drawn the same in all directions, as its slopes are those of its heights");
        }
        if charts.compromise {
            say("some of its textures with other texture coordinates than its colours, or its heights, follow theirs");
        }
    }
    let lamps = model.shown_nodes().into_iter().filter(|&node| model.nodes[node].light.is_some()).count();
    if lamps > MAX_POINT_LIGHTS {
        remarks.push(format!("only the first {MAX_POINT_LIGHTS} of its {lamps} lights are lit"));
    }
    let seen_by = camera.and_then(|node| model.nodes[node].camera).map(|number| model.cameras[number].projection);
    if matches!(seen_by, Some(Projection::Orthographic { .. })) {
        remarks
            .push("its camera has no vanishing points: it is drawn from far away through a long lens instead".into());
    }
    remarks
}
