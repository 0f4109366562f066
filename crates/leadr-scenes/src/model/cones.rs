//! Gives materials of a model maps of occlusion cones.

use std::str::FromStr;

use serde::Serialize;

use super::named::{NamedFile, materials_named};
use super::relief::is_projected;
use crate::error::SceneError;
use leadr_maps::material::{Material, Texture};
use leadr_models::{Mesh, Model};

/// A material, and its map of occlusion cones from `leadr bake --kind cones`, written as `MATERIAL=FILE`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialCones(pub NamedFile);

impl FromStr for MaterialCones {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = "write MATERIAL=FILE, as in skin=skin_Cones.png";
        NamedFile::read(text, form, |file| (file, ())).map(|(named, ())| Self(named))
    }
}

/// Gives materials of the model cones, which replace their occlusion. The cones lie over the material like its normal map, or else like its
/// colours. A material whose mesh has no coordinates for them keeps its occlusion, with a warning.
///
/// # Errors
/// If no material has the name (the message lists the existing names), or a file does not hold cones.
pub fn give_cones(model: &mut Model, requested: &[MaterialCones]) -> Result<(), SceneError> {
    for MaterialCones(NamedFile { material, file }) in requested {
        let indices = materials_named(model, material.as_deref())?;
        let mut holder = Material::new("cones");
        holder.set_cones(file)?;
        let Some(cones) = holder.cones else { continue };
        indices.into_iter().for_each(|index| lay_cones(model, index, &cones));
    }
    Ok(())
}

/// Gives a material cones, if its mesh has coordinates for them.
fn lay_cones(model: &mut Model, index: usize, cones: &Texture) {
    let cones = like_its_normals(&model.materials[index], cones);
    if is_charted(model, index, &cones) {
        model.materials[index].cones = Some(cones);
        return;
    }
    let name = &model.materials[index].name;
    tracing::warn!(
        "{}: material {name}: its mesh has no texture coordinates for --cones, so its occlusion has no direction; add texture \
         coordinates, or heights without other textures",
        model.name
    );
}

/// Returns the cones with the layout of the material's normal map, or else of its colours.
fn like_its_normals(material: &Material, cones: &Texture) -> Texture {
    let normals = material.normal_map.as_ref().map(|map| &map.texture);
    match normals.or(material.base_color.texture.as_ref()) {
        None => cones.clone(),
        Some(&Texture { coordinates, transform, wrap, .. }) => {
            Texture { coordinates, transform, wrap, ..cones.clone() }
        }
    }
}

/// Whether all triangles of a material have coordinates for its cones.
fn is_charted(model: &Model, index: usize, cones: &Texture) -> bool {
    let primitives = model.meshes.iter().flat_map(|Mesh { primitives, .. }| primitives);
    let mut own = primitives.filter(|primitive| primitive.material == index);
    is_projected(&model.materials[index]) || own.all(|mesh| mesh.texcoords.len() > cones.coordinates as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Affine2, Vec2};
    use leadr_maps::HeightMap;
    use leadr_maps::material::{Encoding, Input, NormalMap, Raster, Relief, Samples, TextureWrap};
    use leadr_models::Primitive;

    fn texture() -> Texture {
        let raster = Raster::new(1, 1, 4, Samples::U8(vec![128, 128, 255, 255])).unwrap();
        Texture::new(raster, "texture", Encoding::Linear)
    }

    fn model(materials: Vec<Material>, sets: usize) -> Model {
        let primitive = |material| Primitive {
            material,
            triangles: vec![[0; 3]],
            positions: vec![[0.0; 3]],
            texcoords: vec![vec![[0.0; 2]]; sets],
            ..Primitive::default()
        };
        let primitives = (0..materials.len()).map(primitive).collect();
        Model { materials, meshes: vec![Mesh { primitives, ..Mesh::default() }], ..Model::default() }
    }

    #[test]
    fn cones_are_read_as_they_are_written() {
        for text in ["skin=a_Cones.png", "*=a/b=c.png"] {
            let read: MaterialCones = text.parse().unwrap();
            assert_eq!(serde_json::to_value(&read).unwrap(), text);
        }
        for text in ["a_Cones.png", "=a_Cones.png", "skin="] {
            assert!(text.parse::<MaterialCones>().unwrap_err().contains("MATERIAL=FILE"), "{text}");
        }
    }

    #[test]
    fn cones_lie_like_the_normals_of_the_material() {
        let mut bumpy = Material::new("bumpy");
        bumpy.base_color = Input::colors(texture());
        let placed = Texture {
            coordinates: 1,
            transform: Affine2::from_scale(Vec2::splat(3.0)),
            wrap: [TextureWrap::Mirror; 2],
            ..texture()
        };
        bumpy.normal_map = Some(NormalMap { texture: placed.clone(), green: Default::default(), scale: 1.0 });
        let mut model = model(vec![bumpy, Material::new("plain")], 2);
        lay_cones(&mut model, 0, &texture());
        let cones = model.materials[0].cones.as_ref().unwrap();
        assert_eq!((cones.coordinates, cones.transform, cones.wrap), (1, placed.transform, placed.wrap));
        assert_eq!(model.materials[1].cones, None);
    }

    #[test]
    fn materials_without_coordinates_keep_their_occlusion() {
        let map = HeightMap { width: 1, height: 1, texels: vec![0.0] };
        let relief = Some(Relief { map, scale: None, in_widths: false, middle: 0.0 });
        // Heights alone are projected onto a mesh without coordinates, and so are the cones.
        let high = Material { relief: relief.clone(), ..Material::new("high") };
        let colored = Material { relief, base_color: Input::colors(texture()), ..Material::new("colored") };
        let given = |sets| {
            let mut model = model(vec![Material::new("bare"), high.clone(), colored.clone()], sets);
            (0..3).for_each(|index| lay_cones(&mut model, index, &texture()));
            model.materials.iter().map(|material| material.cones.is_some()).collect::<Vec<_>>()
        };
        assert_eq!(given(1), [true, true, true]);
        assert_eq!(given(0), [false, true, false]);
    }

    #[test]
    fn wrong_names_and_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut model = model(vec![Material::new("rust")], 1);
        let mut refused = |text: &str| give_cones(&mut model, &[text.parse().unwrap()]).unwrap_err().to_string();
        let error = refused("skin=none.png");
        assert!(error.contains("no material is named skin; available: rust"), "{error}");
        let grey = folder.path().join("grey.png");
        leadr_maps::save::save_png_grey16(&grey, &HeightMap::new(1, 1, vec![0.5]).unwrap(), 0.0, 1.0).unwrap();
        let error = refused(&format!("rust={}", grey.to_string_lossy()));
        assert!(error.contains("grey.png") && error.contains("four channels"), "{error}");
    }
}
