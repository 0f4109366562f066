//! Restores the heights between the codes of coarse height maps, for all maps of a scene.

use std::collections::HashMap;

use leadr_maps::checksum::checksum;
use leadr_maps::derive::quantisation::restore;
use leadr_maps::material::{Material, Relief};
use leadr_maps::{HeightMap, Wrap};

/// The share of the slope variance from steps between codes above which the log warns.
const REMARKED: f64 = 0.01;

/// Restores the heights of a map. Logs the share of its slope variance that comes from its codes, under `name`.
pub fn restore_map(map: &mut HeightMap, name: &str) {
    match restore(map, Wrap::Repeat) {
        Some(found) if found.before >= REMARKED => {
            tracing::warn!("{name}: {found}; to draw the codes, add --heights-as-read");
        }
        Some(found) => tracing::info!("{name}: {found}"),
        None => {}
    }
}

/// Restores the heights of a relief. If the middle of the relief is the mean of its map, it remains the mean.
fn restore_relief(relief: &mut Relief, name: &str) {
    let follows_mean = relief.middle == relief.map.mean();
    restore_map(&mut relief.map, name);
    if follows_mean {
        relief.middle = relief.map.mean();
    }
}

/// Restores the heights of a material and of its detail. `name` is the name of the material in the log.
pub fn restore_material(material: &mut Material, name: &str) {
    if let Some(relief) = &mut material.relief {
        restore_relief(relief, name);
    }
    if let Some(detail) = &mut material.detail {
        restore_material(&mut detail.material, &format!("{name}, detail"));
    }
}

/// Restores the heights of the materials of a model. Materials with the same heights share the work.
pub fn restore_materials(materials: &mut [Material], model: &str) {
    let sum = |material: &Material| {
        let map = &material.relief.as_ref()?.map;
        Some((map.width, checksum(bytemuck::cast_slice(&map.texels)), material.relief.as_ref()?.middle.to_bits()))
    };
    let mut restored: HashMap<_, usize> = HashMap::new();
    for i in 0..materials.len() {
        let Some(sum) = sum(&materials[i]) else { continue };
        if let Some(&earlier) = restored.get(&sum) {
            let same = materials[earlier].relief.as_ref().map(|relief| (relief.map.clone(), relief.middle));
            if let (Some(relief), Some((map, middle))) = (&mut materials[i].relief, same) {
                (relief.map, relief.middle) = (map, middle);
            }
        } else {
            restored.insert(sum, i);
            let name = format!("{model}, material {}", materials[i].name);
            restore_material(&mut materials[i], &name);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn relief() -> Relief {
        let codes = (0..64 * 64).map(|i| ((i % 64) as f32 / 10.0).sin() * 3.0 + 100.0);
        let map = HeightMap::new(64, 64, codes.map(|code| code.round() / 255.0).collect()).unwrap();
        let middle = map.mean();
        Relief { map, scale: Some(0.1), in_widths: false, middle }
    }

    #[test]
    fn materials_of_a_model_are_restored_alike() {
        let with = |relief: Relief| Material { relief: Some(relief), ..Material::new("skin") };
        let fixed = Relief { middle: 0.5, ..relief() };
        let mut materials = [with(relief()), Material::new("flat"), with(relief()), with(fixed)];
        restore_materials(&mut materials, "model");
        let [first, _, third, last] = materials.map(|material| material.relief);
        let (first, last) = (first.unwrap(), last.unwrap());
        assert!(first.map != relief().map && Some(&first) == third.as_ref() && first.map == last.map);
        assert_eq!((first.middle, last.middle), (first.map.mean(), 0.5));
    }
}
