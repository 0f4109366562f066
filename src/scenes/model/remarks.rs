//! What of a model is not drawn, in words.

use super::parts::{Parts, coordinate_set};
use crate::maps::material::{Opacity, TextureWrap};
use crate::models::Model;

/// A sentence for each thing that the picture leaves out or changes.
pub fn of(model: &Model, parts: &Parts) -> Vec<String> {
    let mut remarks = model.remarks.clone();
    for material in parts.objects.iter().map(|object| &model.materials[object.material]) {
        let name = &material.name;
        let mut say = |what: &str| remarks.push(format!("material {name}: {what}"));
        match material.opacity {
            Opacity::Opaque => {}
            Opacity::Mask { .. } => say("its mask is not drawn: it is opaque everywhere"),
            Opacity::Blend { .. } => say("it is drawn opaque"),
        }
        if material.relief.is_some() {
            say("its displacement is not drawn yet");
        }
        if material.unlit {
            say("it is lit like the others");
        }
        if material.emission.texture.is_some() || material.emission.factor != [0.0; 3] {
            say("its emission is not drawn");
        }
        if material.anisotropy.is_some() {
            say("its roughness is drawn the same in all directions");
        }
        let set = coordinate_set(material) as u32;
        let textures = [&material.base_color.texture, &material.roughness.texture, &material.metalness.texture];
        let normal = material.normal_map.as_ref().map(|map| &map.texture);
        let textures: Vec<_> = textures.into_iter().flatten().chain(normal).collect();
        if textures.iter().any(|texture| texture.coordinates != set) {
            say("textures with other texture coordinates than its colours follow theirs");
        }
        if textures.iter().any(|texture| texture.wrap != [TextureWrap::Repeat; 2]) {
            say("its textures repeat beyond their edges");
        }
    }
    if !model.lights.is_empty() {
        remarks.push("its lights are not lit: the sky lights it".into());
    }
    if !model.cameras.is_empty() {
        remarks.push("its cameras are not used".into());
    }
    remarks
}
