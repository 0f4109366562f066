//! Checks the glTF version, and lists the supported extensions.

use super::json::{Item, Read};
use crate::fault::{ModelFault, shown};

pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";
/// The extension for offset, rotation and scale of texture coordinates.
pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";
/// The extension for emission above 1.
pub(super) const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";
pub(super) const IOR: &str = "KHR_materials_ior";
/// The extension for the strength and colour of the specular reflection of dielectrics.
pub(super) const SPECULAR: &str = "KHR_materials_specular";
pub(super) const ANISOTROPY: &str = "KHR_materials_anisotropy";
pub(super) const UNLIT: &str = "KHR_materials_unlit";
/// The extension for directional, point and spot lights.
pub(super) const LIGHTS: &str = "KHR_lights_punctual";

/// All supported extensions.
pub const READ: [&str; 8] =
    [QUANTIZATION, TEXTURE_TRANSFORM, EMISSIVE_STRENGTH, IOR, SPECULAR, ANISOTROPY, UNLIT, LIGHTS];

/// The maximum number of extensions in one message.
const MAX_NAMES: usize = 12;

/// Refuses unsupported glTF versions and required extensions. Returns the unsupported extensions that the model uses.
pub(super) fn check(root: &Item<'_>) -> Read<Vec<String>> {
    let asset = root.required("asset", root.item("asset")?)?;
    let version = asset.required("version", asset.string("version")?)?;
    let least = asset.string("minVersion")?;
    let numbers = |text: &str| -> Read<(u32, u32)> {
        let parsed = text.split_once('.').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        parsed.ok_or_else(|| {
            asset.fault(format!("`{}` is not a version; it must be two numbers separated by a point", shown(text)))
        })
    };
    let too_new = numbers(least.unwrap_or(version))? > (2, 0) && (least.is_some() || numbers(version)?.0 != 2);
    if numbers(version)?.0 != 2 || too_new {
        let what = format!("it is glTF {}", shown(least.unwrap_or(version)));
        return Err(ModelFault::unsupported(what, "export it as glTF 2.0"));
    }
    let unread = |key| -> Read<Vec<String>> {
        let all = root.strings(key)?.into_iter().filter(|name| !READ.contains(name));
        Ok(all.take(MAX_NAMES).map(shown).collect())
    };
    let required = unread("extensionsRequired")?;
    if !required.is_empty() {
        let what = format!("it requires {}", required.join(", "));
        let remedy = format!("export it without; supported extensions are {}", READ.join(", "));
        return Err(ModelFault::unsupported(what, remedy));
    }
    unread("extensionsUsed")
}
