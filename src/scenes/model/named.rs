//! Materials of a model by the name that its user gives.

use crate::models::Model;
use crate::scenes::error::SceneError;

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
