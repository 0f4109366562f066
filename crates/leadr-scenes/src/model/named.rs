//! Materials of a model by the name that its user gives, and the files that are for them.

use std::fmt;
use std::path::PathBuf;

use crate::error::SceneError;
use leadr_models::Model;

/// A file for a material, written `MATERIAL=FILE`.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedFile {
    /// Name of the material; `None`, written `*`, for all of them.
    pub material: Option<String>,
    /// The file.
    pub file: PathBuf,
}

impl NamedFile {
    /// Reads it. `split`: the file and what else the text after `=` holds; `form`: what faults say is to be written.
    ///
    /// # Errors
    /// If one of the two is missing.
    pub fn read<'a, T>(
        text: &'a str,
        form: &str,
        split: impl FnOnce(&'a str) -> (&'a str, T),
    ) -> Result<(Self, T), String> {
        let (material, rest) = text.split_once('=').ok_or_else(|| format!("no material is named; {form}"))?;
        let (file, more) = split(rest);
        if material.is_empty() || file.is_empty() {
            return Err(format!("the {} is missing; {form}", if file.is_empty() { "file" } else { "material" }));
        }
        Ok((Self { material: (material != "*").then(|| material.to_owned()), file: PathBuf::from(file) }, more))
    }
}

impl fmt::Display for NamedFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.material.as_deref().unwrap_or("*"), self.file.display())
    }
}

/// Which materials have this name; all of them without one.
///
/// # Errors
/// If there is none; those that exist are listed.
pub fn worn_by(model: &Model, name: Option<&str>) -> Result<Vec<usize>, SceneError> {
    let all = model.materials.iter().enumerate();
    let worn: Vec<usize> =
        all.filter(|(_, material)| name.is_none_or(|name| name == material.name)).map(|(index, _)| index).collect();
    if worn.is_empty() {
        let names: Vec<&str> = model.materials.iter().map(|material| material.name.as_str()).collect();
        let fault = format!("no material is called {}; there are: {}", name.unwrap_or("*"), names.join(", "));
        return Err(SceneError::Model(fault));
    }
    Ok(worn)
}
