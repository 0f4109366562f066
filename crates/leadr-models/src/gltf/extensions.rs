//! Versions and extensions: what is read, and what a model may not ask for.

use super::json::{Item, Read};
use crate::fault::{ModelFault, shown};

/// Vertices in small integers.
pub(super) const QUANTIZATION: &str = "KHR_mesh_quantization";
/// Offset, rotation and scale of texture coordinates.
pub(super) const TEXTURE_TRANSFORM: &str = "KHR_texture_transform";
/// Emission above 1.
pub(super) const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";
/// Index of refraction.
pub(super) const IOR: &str = "KHR_materials_ior";
/// Strength and colour of what dielectrics reflect.
pub(super) const SPECULAR: &str = "KHR_materials_specular";
/// Roughness with a direction.
pub(super) const ANISOTROPY: &str = "KHR_materials_anisotropy";
/// Surfaces without shading.
pub(super) const UNLIT: &str = "KHR_materials_unlit";
/// Suns, lamps and spots.
pub(super) const LIGHTS: &str = "KHR_lights_punctual";

/// All extensions that are read.
pub const READ: [&str; 8] =
    [QUANTIZATION, TEXTURE_TRANSFORM, EMISSIVE_STRENGTH, IOR, SPECULAR, ANISOTROPY, UNLIT, LIGHTS];

/// Most extensions that one message names.
const MAX_NAMES: usize = 12;

/// Refuses other versions of glTF and required extensions that are not read. Returns the used ones that are not.
pub(super) fn check(root: &Item<'_>) -> Read<Vec<String>> {
    let asset = root.required("asset", root.item("asset")?)?;
    let version = asset.required("version", asset.string("version")?)?;
    let least = asset.string("minVersion")?;
    let numbers = |text: &str| -> Read<(u32, u32)> {
        let parsed = text.split_once('.').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        parsed
            .ok_or_else(|| asset.fault(format!("`{}` is no version; it must be two numbers with a point", shown(text))))
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
        let what = format!("it cannot be read without {}", required.join(", "));
        let remedy = format!("export it without; extensions that are read: {}", READ.join(", "));
        return Err(ModelFault::unsupported(what, remedy));
    }
    unread("extensionsUsed")
}
