//! Selects materials of a model by name, and parses their file arguments.

use std::fmt;
use std::path::PathBuf;

use serde::{Serialize, Serializer};

use crate::error::SceneError;
use leadr_models::Model;

/// A file for a material, written as `MATERIAL=FILE`.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedFile {
    /// The name of the material; `None`, written as `*`, selects all materials.
    pub material: Option<String>,
    /// The file.
    pub file: PathBuf,
}

impl NamedFile {
    /// Parses the argument. `split` separates the file from the text that follows. `form` is the description of the syntax for error
    /// messages.
    ///
    /// # Errors
    /// If the material or the file is missing.
    pub fn read<'a, T>(
        text: &'a str,
        form: &str,
        split: impl FnOnce(&'a str) -> (&'a str, T),
    ) -> Result<(Self, T), String> {
        let (material, rest) = text.split_once('=').ok_or_else(|| format!("`=` is missing; {form}"))?;
        let (file, more) = split(rest);
        if material.is_empty() || file.is_empty() {
            return Err(format!("the {} is missing; {form}", if file.is_empty() { "file" } else { "material" }));
        }
        Ok((Self { material: (material != "*").then(|| material.to_owned()), file: PathBuf::from(file) }, more))
    }
}

impl fmt::Display for NamedFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.material.as_deref().unwrap_or("*"), self.file.to_string_lossy())
    }
}

impl Serialize for NamedFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Maximum number of materials in an error.
const MOST_NAMES: usize = 40;

/// Returns the indices of the materials with this name; all for `None`.
///
/// # Errors
/// If no material has the name; the first existing names are listed.
pub fn materials_named(model: &Model, name: Option<&str>) -> Result<Vec<usize>, SceneError> {
    let all = model.materials.iter().enumerate();
    let indices: Vec<usize> =
        all.filter(|(_, material)| name.is_none_or(|name| name == material.name)).map(|(index, _)| index).collect();
    if indices.is_empty() {
        let mut names: Vec<&str> =
            model.materials.iter().map(|material| material.name.as_str()).take(MOST_NAMES).collect();
        let more = format!("and {} more", model.materials.len() - names.len());
        if model.materials.len() > names.len() {
            names.push(&more);
        }
        let fault = format!("no material is named {}; available: {}", name.unwrap_or("*"), names.join(", "));
        return Err(SceneError::Model(fault));
    }
    Ok(indices)
}
