//! Merges materials that draw alike, and materials that differ only in a constant colour, which makes their relief continuous.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use leadr_maps::material::{Input, Material, Opacity, Texture};
use leadr_models::{Mesh, Model};

/// Merges materials that differ only in their names, and displaced materials that differ only in a constant base colour. The colours move to
/// the vertices.
pub fn join_plain(model: &mut Model) {
    let materials = &mut model.materials;
    let plain: Vec<bool> = materials.iter().map(is_plain).collect();
    // Without names and joined colours, materials that draw alike are equal.
    let own: Vec<(String, Input<[f32; 3]>)> = materials
        .iter_mut()
        .zip(&plain)
        .map(|(material, plain)| {
            let color = material.base_color.clone();
            if *plain {
                material.base_color = Input::constant([1.0; 3]);
            }
            (std::mem::take(&mut material.name), color)
        })
        .collect();
    let firsts = firsts(materials);
    for (material, (name, color)) in materials.iter_mut().zip(own) {
        (material.name, material.base_color) = (name, color);
    }
    let mut users = vec![0; firsts.len()];
    firsts.iter().for_each(|first| users[*first] += 1);
    let recolored: Vec<bool> = firsts.iter().zip(&plain).map(|(first, plain)| *plain && users[*first] > 1).collect();
    for primitive in model.meshes.iter_mut().flat_map(|Mesh { primitives, .. }| primitives) {
        let Some(material) = model.materials.get(primitive.material) else { continue };
        if recolored[primitive.material] {
            let [r, g, b] = material.base_color.factor;
            let white = || vec![[1.0; 4]; primitive.positions.len()];
            let colors = primitive.colors.get_or_insert_with(white);
            colors.iter_mut().for_each(|c| *c = [c[0] * r, c[1] * g, c[2] * b, c[3]]);
        }
        primitive.material = firsts[primitive.material];
    }
    for (number, material) in model.materials.iter_mut().enumerate().filter(|(number, _)| recolored[*number]) {
        if firsts[number] == number {
            material.base_color = Input::constant([1.0; 3]);
        }
    }
}

/// Whether the colour of a material can move to its vertices, where relief is worth joining.
fn is_plain(material: &Material) -> bool {
    material.relief.is_some() && material.base_color.texture.is_none() && material.metalness == Input::constant(0.0)
}

/// Returns for each material the first equal one, or itself. Textured reliefs stay separate, because their scale follows their own mesh.
fn firsts(materials: &[Material]) -> Vec<usize> {
    let mut known: HashMap<u64, Vec<usize>> = HashMap::new();
    let first = |(number, material): (usize, &Material)| {
        if material.relief.is_some() && !is_plain(material) {
            return number;
        }
        let alike = known.entry(digest(material)).or_default();
        let found = alike.iter().copied().find(|&earlier| materials[earlier] == *material);
        found.unwrap_or_else(|| {
            alike.push(number);
            number
        })
    };
    materials.iter().enumerate().map(first).collect()
}

/// Returns a number that is equal for equal materials with the same images, and nearly always differs otherwise.
fn digest(material: &Material) -> u64 {
    fn input<T: Copy + Into<Numbers>>(hasher: &mut DefaultHasher, input: &Input<T>) {
        let Numbers(factor) = input.factor.into();
        (factor.map(f32::to_bits), input.channel).hash(hasher);
        texture(hasher, input.texture.as_ref());
    }
    fn texture(hasher: &mut DefaultHasher, texture: Option<&Texture>) {
        let parts =
            texture.map(|t| (Arc::as_ptr(&t.raster), t.coordinates, t.transform.to_cols_array().map(f32::to_bits)));
        parts.hash(hasher);
    }
    let hasher = &mut DefaultHasher::new();
    [&material.base_color, &material.f0, &material.emission].into_iter().for_each(|color| input(hasher, color));
    let numbers = [&material.metalness, &material.roughness, &material.specular, &material.occlusion];
    numbers.into_iter().for_each(|number| input(hasher, number));
    match &material.opacity {
        Opacity::Opaque => {}
        Opacity::Mask { mask, cutoff } => {
            cutoff.to_bits().hash(hasher);
            input(hasher, mask);
        }
        Opacity::Blend { share } => input(hasher, share),
    }
    if let Some(map) = &material.normal_map {
        map.scale.to_bits().hash(hasher);
        texture(hasher, Some(&map.texture));
    }
    texture(hasher, material.cones.as_ref());
    if let Some(anisotropy) = &material.anisotropy {
        anisotropy.rotation.to_bits().hash(hasher);
        input(hasher, &anisotropy.strength);
    }
    if let Some(coat) = &material.coat {
        coat.follows_relief.hash(hasher);
        input(hasher, &coat.weight);
        input(hasher, &coat.roughness);
        texture(hasher, coat.normal_map.as_ref().map(|map| &map.texture));
    }
    if let Some(passed) = material.transmission {
        let numbers = [passed.weight, passed.ior, passed.thickness, passed.attenuation_distance];
        (numbers.map(f32::to_bits), passed.attenuation_color.map(f32::to_bits)).hash(hasher);
    }
    let relief =
        material.relief.as_ref().map(|r| (r.map.width, r.map.height, r.middle.to_bits(), r.scale.map(f32::to_bits)));
    (relief, material.occlusion_strength.to_bits(), material.double_sided, material.unlit).hash(hasher);
    hasher.finish()
}

/// The numbers of a factor.
struct Numbers([f32; 3]);

impl From<f32> for Numbers {
    fn from(number: f32) -> Self {
        Self([number; 3])
    }
}

impl From<[f32; 3]> for Numbers {
    fn from(numbers: [f32; 3]) -> Self {
        Self(numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::parts::Parts;
    use leadr_maps::HeightMap;
    use leadr_maps::material::{Encoding, Raster, Relief, Samples};
    use leadr_models::Primitive;

    #[test]
    fn materials_of_one_relief_become_one() {
        let plain = |name: &str, color: [f32; 3]| {
            let mut material = Material::new(name);
            material.base_color = Input::constant(color);
            let map = HeightMap { width: 1, height: 1, texels: vec![0.0] };
            material.relief = Some(Relief { map, scale: None, in_widths: false, middle: 0.0 });
            material
        };
        let mut rough = plain("rough", [0.1; 3]);
        rough.roughness = Input::constant(1.0);
        let primitive = |material| Primitive { material, positions: vec![[0.0; 3]], ..Primitive::default() };
        let mut model = Model {
            materials: vec![rough, plain("red", [0.8, 0.1, 0.1]), plain("blue", [0.1, 0.1, 0.8])],
            meshes: vec![Mesh { primitives: vec![primitive(0), primitive(1), primitive(2)], ..Mesh::default() }],
            ..Model::default()
        };
        join_plain(&mut model);
        let [first, second, third] = &model.meshes[0].primitives[..] else { panic!() };
        assert_eq!((first.material, second.material, third.material), (0, 1, 1));
        assert_eq!(first.colors, None);
        assert_eq!(third.colors, Some(vec![[0.1, 0.1, 0.8, 1.0]]));
        assert_eq!(model.materials[1].base_color.factor, [1.0; 3]);
        assert_eq!(model.materials[0].base_color.factor, [0.1; 3]);
    }

    #[test]
    fn materials_that_draw_alike_become_one() {
        let raster = Raster::new(1, 1, 1, Samples::U8(vec![0])).unwrap();
        let mut textured = Material::new("a");
        textured.base_color = Input::colors(Texture::new(raster.clone(), "t", Encoding::Srgb));
        let same = Material { name: "b".into(), ..textured.clone() };
        let mut other_image = textured.clone();
        other_image.base_color = Input::colors(Texture::new(raster, "t", Encoding::Srgb));
        let mut shiny = textured.clone();
        shiny.roughness = Input::constant(0.1);
        assert_eq!(firsts(&[Material::new(""), textured.clone(), shiny, other_image, textured]), [0, 1, 2, 3, 1]);
        let mut model = Model {
            materials: vec![
                Material::new("a"),
                same.clone(),
                Material::new("b"),
                Material { name: "c".into(), ..same },
            ],
            meshes: vec![Mesh {
                primitives: (0..4).map(|material| Primitive { material, ..Primitive::default() }).collect(),
                ..Mesh::default()
            }],
            ..Model::default()
        };
        join_plain(&mut model);
        let used: Vec<usize> = model.meshes[0].primitives.iter().map(|primitive| primitive.material).collect();
        assert_eq!(used, [0, 1, 0, 1]);
        assert!(model.meshes[0].primitives.iter().all(|primitive| primitive.colors.is_none()));
        assert_eq!(model.materials[3].name, "c");
    }

    #[test]
    fn time_grows_with_the_number_of_materials() {
        let seconds = |count: usize| {
            let material = |i: usize| {
                let mut material = Material::new(format!("m{i}"));
                material.roughness = Input::constant(i as f32 / count as f32);
                material
            };
            let primitive = |material| Primitive { material, triangles: vec![[0; 3]], ..Primitive::default() };
            let node = leadr_models::Node { mesh: Some(0), ..crate::model::parts::tests::node() };
            let mut model = Model {
                materials: (0..count).map(material).collect(),
                meshes: vec![Mesh { primitives: (0..count).map(primitive).collect(), ..Mesh::default() }],
                nodes: vec![node],
                order: vec![0],
                ..Model::default()
            };
            let start = std::time::Instant::now();
            join_plain(&mut model);
            assert_eq!(Parts::of(&model).objects.len(), count);
            start.elapsed().as_secs_f64()
        };
        // A comparison of all pairs would take 64 times as long.
        let fastest = |count| (0..5).map(|_| seconds(count)).fold(f64::INFINITY, f64::min);
        let (few, many) = (fastest(10_000), fastest(80_000));
        assert!(many < 30.0 * few, "{few} s for 10000 materials, {many} s for 80000");
    }
}
