//! Merges materials that differ only in a constant colour, which makes their relief continuous.

use leadr_maps::material::{Input, Material};
use leadr_models::{Mesh, Model};

/// Merges displaced materials that differ only in a constant base colour into one. The colours move to the vertices.
pub fn join_plain(model: &mut Model) {
    let firsts: Vec<usize> = (0..model.materials.len())
        .map(|number| {
            (0..number).find(|&first| joined(&model.materials[first], &model.materials[number])).unwrap_or(number)
        })
        .collect();
    let shared: Vec<bool> =
        firsts.iter().map(|first| firsts.iter().filter(|other| *other == first).count() > 1).collect();
    for primitive in model.meshes.iter_mut().flat_map(|Mesh { primitives, .. }| primitives) {
        let Some(material) = model.materials.get(primitive.material).filter(|_| shared[primitive.material]) else {
            continue;
        };
        let [r, g, b] = material.base_color.factor;
        let white = || vec![[1.0; 4]; primitive.positions.len()];
        primitive.colors.get_or_insert_with(white).iter_mut().for_each(|c| *c = [c[0] * r, c[1] * g, c[2] * b, c[3]]);
        primitive.material = firsts[primitive.material];
    }
    for (number, material) in model.materials.iter_mut().enumerate().filter(|(number, _)| shared[*number]) {
        if firsts[number] == number {
            material.base_color = Input::constant([1.0; 3]);
        }
    }
}

fn joined(a: &Material, b: &Material) -> bool {
    let colorless = |material: &Material| Material {
        name: String::new(),
        base_color: Input::constant([1.0; 3]),
        ..material.clone()
    };
    let plain = |material: &Material| {
        material.relief.is_some() && material.base_color.texture.is_none() && material.metalness == Input::constant(0.0)
    };
    plain(a) && plain(b) && colorless(a) == colorless(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::HeightMap;
    use leadr_maps::material::Relief;
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
}
