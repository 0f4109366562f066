//! Lists the features of a model that are not drawn.

use std::collections::HashSet;

use super::charts::Charts;
use super::parts::Parts;
use leadr_maps::material::{Material, Opacity};
use leadr_models::{Model, Projection};

/// Returns one sentence for each feature that is omitted or changed in the picture. `camera` is the node of the file's camera, if this
/// camera is used.
pub fn of(model: &Model, parts: &Parts, charts: &[(Charts, Material)], camera: Option<usize>) -> Vec<String> {
    let mut remarks = model.remarks.clone();
    let mut seen = HashSet::new();
    let objects = parts.objects.iter().zip(charts).filter(|(object, _)| seen.insert(object.material));
    for (object, (charts, _)) in objects {
        let material = &model.materials[object.material];
        let name = &material.name;
        let mut say = |what: &str| remarks.push(format!("material {name}: {what}"));
        if matches!(material.opacity, Opacity::Blend { .. }) {
            say(
                "transparency is stochastic: a sample hits it with a probability equal to its opacity, so use many samples",
            );
        }
        if material.anisotropy.is_some() && material.relief.is_some() && material.normal_map.is_none() {
            say("its roughness is drawn without anisotropy, because its slopes are those of its heights");
        }
        if charts.compromise {
            say("some of its textures use the texture coordinates of its colours or heights instead of their own");
        }
    }
    let seen_by = camera.and_then(|node| model.nodes[node].camera).map(|number| model.cameras[number].projection);
    if matches!(seen_by, Some(Projection::Orthographic { .. })) {
        remarks.push(
            "its camera is orthographic: it is approximated from a large distance with a narrow field of view".into(),
        );
    }
    remarks
}
