//! Replaces materials of a model by measured materials.

use std::str::FromStr;

use serde::Serialize;

use super::named::{NamedFile, materials_named};
use crate::error::SceneError;
use crate::fitted::apply_fit;
use leadr_measured::fit_file::FitFile;
use leadr_models::Model;

/// A material, and its file from `leadr fit`, written as `MATERIAL=FIT.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuredMaterial(pub NamedFile);

impl FromStr for MeasuredMaterial {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = "write MATERIAL=FIT.json, as in body=paint.json";
        NamedFile::read(text, form, |file| (file, ())).map(|(named, ())| Self(named))
    }
}

/// Replaces the facets and the diffuse term of materials of the model by measured ones. Relief, occlusion, emission and cutouts are kept.
///
/// # Errors
/// If no material has the name (the message lists the existing names), or a file is not a fit.
pub fn measure(model: &mut Model, requested: &[MeasuredMaterial]) -> Result<(), SceneError> {
    for MeasuredMaterial(NamedFile { material, file }) in requested {
        let indices = materials_named(model, material.as_deref())?;
        let fit = FitFile::load(file)?;
        for index in indices {
            apply_fit(&fit, &mut model.materials[index]);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::material::Material;

    #[test]
    fn measured_materials_are_read_as_they_are_written() {
        for text in ["body=paint.json", "*=a/b=c.json"] {
            let read: MeasuredMaterial = text.parse().unwrap();
            assert_eq!(serde_json::to_value(&read).unwrap(), text);
        }
        for text in ["paint.json", "=paint.json", "body="] {
            assert!(text.parse::<MeasuredMaterial>().unwrap_err().contains("MATERIAL=FIT.json"), "{text}");
        }
    }

    #[test]
    fn unknown_names_are_refused_before_any_file_is_read() {
        let mut model = Model { materials: vec![Material::new("rust"), Material::new("bone")], ..Model::default() };
        let error = measure(&mut model, &["skin=none.json".parse().unwrap()]).unwrap_err().to_string();
        assert!(error.contains("no material is named skin; available: rust, bone"), "{error}");
    }
}
