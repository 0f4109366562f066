//! Checks the glTF version, and lists the supported extensions.

use super::json::{Item, Read};
use super::log::Log;
use super::value::Value;
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
pub(super) const CLEAR_COAT: &str = "KHR_materials_clearcoat";
pub(super) const TRANSMISSION: &str = "KHR_materials_transmission";
pub(super) const VOLUME: &str = "KHR_materials_volume";
pub(super) const UNLIT: &str = "KHR_materials_unlit";
/// The extension for directional, point and spot lights.
pub(super) const LIGHTS: &str = "KHR_lights_punctual";

/// The extension for materials of which the user selects a set.
pub(super) const VARIANTS: &str = "KHR_materials_variants";

pub(super) const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";
/// The extensions for images of other formats. The image of `source` may be another format of the same picture.
pub(super) const WEBP: &str = "EXT_texture_webp";
pub(super) const TEXTURES: [&str; 3] = ["KHR_texture_basisu", "EXT_texture_avif", "MSFT_texture_dds"];
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
pub(super) const MESHOPT: &str = "EXT_meshopt_compression";
pub(super) const MESHOPT_KHR: &str = "KHR_meshopt_compression";
/// The extension for copies of a mesh.
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";
/// The extension for animations of other properties than those of nodes.
pub(super) const POINTER: &str = "KHR_animation_pointer";
pub(super) const VISIBILITY: &str = "KHR_node_visibility";
/// The extension for coarser copies of a node.
pub(super) const LEVELS: &str = "MSFT_lod";

/// All supported extensions. Those from the last line on have no effect on the picture.
pub const READ: [&str; 27] = [
    QUANTIZATION,
    TEXTURE_TRANSFORM,
    EMISSIVE_STRENGTH,
    IOR,
    SPECULAR,
    ANISOTROPY,
    CLEAR_COAT,
    TRANSMISSION,
    VOLUME,
    UNLIT,
    LIGHTS,
    VARIANTS,
    SPECULAR_GLOSSINESS,
    WEBP,
    TEXTURES[0],
    TEXTURES[1],
    TEXTURES[2],
    DRACO,
    MESHOPT,
    MESHOPT_KHR,
    INSTANCING,
    POINTER,
    VISIBILITY,
    LEVELS,
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "FB_ngon_encoding",
];

/// The maximum number of extensions in one message.
const MAX_NAMES: usize = 12;

const REMEDY: &str = "export it as glTF 2.0";

/// Refuses other versions of glTF.
pub(super) fn check_version(root: &Item<'_>, log: &Log) -> Read<()> {
    let other = |version: &str| Err(ModelFault::unsupported(format!("it is glTF {}", shown(version)), REMEDY));
    // Lists are objects in glTF 1.0, which may lack its version.
    let named_parts = ["accessors", "bufferViews", "meshes", "nodes"]
        .iter()
        .any(|key| root.value(key).is_some_and(|list| list.as_object().is_some()));
    let asset = root.required("asset", Item::item);
    let version = asset.as_ref().ok().and_then(|asset| asset.value("version"));
    let text = match version {
        Some(Value::Text(text)) => Some(text.to_string()),
        Some(number) => number.as_number().map(|number| format!("{number:?}")),
        None => None,
    };
    let major = |text: &str| text.split('.').next()?.trim().parse::<u32>().ok();
    if named_parts {
        return other(text.as_deref().filter(|text| major(text) == Some(1)).unwrap_or("1.0"));
    }
    const REPAIR: &str = "it is read as glTF 2.0";
    let asset = match asset {
        Ok(asset) => asset,
        Err(fault) => return log.repair(fault, REPAIR),
    };
    match text.as_deref().map(|text| (text, major(text))) {
        Some((text, Some(1))) => return other(text),
        Some((_, Some(2))) if matches!(version, Some(Value::Text(text)) if numbers(text).is_some()) => {}
        Some((text, Some(found))) if found != 2 => return other(text),
        Some((text, _)) => {
            let what = match version {
                Some(Value::Text(_)) => {
                    format!("`{}` is not a version; it must be two numbers separated by a point", shown(text))
                }
                _ => "`version` must be a string".to_owned(),
            };
            log.repair(asset.fault(what), REPAIR)?;
        }
        None => log.repair(asset.fault("`version` is missing"), REPAIR)?,
    }
    match asset.string("minVersion")? {
        Some(least) if numbers(least).is_some_and(|least| least > (2, 0)) => other(least),
        _ => Ok(()),
    }
}

/// Returns the two numbers of a version.
fn numbers(text: &str) -> Option<(u32, u32)> {
    let (major, minor) = text.split_once('.')?;
    Some((major.parse().ok()?, minor.parse().ok()?))
}

/// Returns the unsupported extensions that the model requires, and reports those that it uses.
pub(super) fn unread(root: &Item<'_>, log: &Log) -> Read<Vec<String>> {
    let unread = |key| -> Read<Vec<String>> {
        let all = root.strings(key)?.into_iter().filter(|name| !READ.contains(name));
        Ok(all.take(MAX_NAMES).map(shown).collect())
    };
    let required = unread("extensionsRequired")?;
    if !required.is_empty() {
        let what = format!("it requires {}", required.join(", "));
        log.refuse(ModelFault::unsupported(what, "export it without, or load it without --strict"))?;
        log.remark(format!("requires unsupported extensions, and is drawn without them: {}", required.join(", ")));
    }
    let used: Vec<String> = unread("extensionsUsed")?.into_iter().filter(|name| !required.contains(name)).collect();
    if !used.is_empty() {
        log.remark(format!("uses unsupported extensions: {}", used.join(", ")));
    }
    Ok(required)
}

/// Returns the index of the variant of this name.
pub(super) fn variant(root: &Item<'_>, name: &str) -> Read<usize> {
    let mut names = Vec::new();
    if let Some(extension) = root.extension(VARIANTS)? {
        for variant in extension.items("variants", "variant")? {
            names.push(variant.name()?);
        }
    }
    names.iter().position(|known| known == name).ok_or_else(|| {
        let all: Vec<String> = names.iter().take(MAX_NAMES).map(|name| shown(name)).collect();
        let there = if all.is_empty() { "none".to_owned() } else { all.join(", ") };
        ModelFault::unsupported(format!("it has no variant named {}", shown(name)), format!("available: {there}"))
    })
}
