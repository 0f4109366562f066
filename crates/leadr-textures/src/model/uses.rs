//! How materials use textures.

use leadr_maps::mips::Alpha;
use serde_json::{Value, json};

use super::{FilterError, invalid};

/// How an image is filtered.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Treatment {
    Color {
        alpha: Alpha,
    },
    Data,
    /// `scale` is the factor on x and y.
    Normals {
        scale: f32,
    },
    /// `normals` is the texture of the normals whose spread the roughness contains, and their scale.
    Roughness {
        channel: usize,
        factor: f32,
        normals: Option<(usize, f32)>,
    },
}

impl Treatment {
    pub(super) fn role(&self) -> &'static str {
        match self {
            Self::Color { .. } => "colour",
            Self::Data => "data",
            Self::Normals { .. } => "normals",
            Self::Roughness { .. } => "roughness",
        }
    }
}

/// A property of a material that names a texture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Use {
    /// The JSON pointer of the `textureInfo`.
    pub(super) pointer: String,
    /// The texture, or `None` for a property that does not exist yet.
    pub(super) texture: Option<usize>,
    /// The texture whose sampler a new texture gets.
    pub(super) like: Option<usize>,
    pub(super) treatment: Treatment,
}

/// Textures that hold colours.
const COLORS: [&str; 8] = [
    "baseColorTexture",
    "emissiveTexture",
    "diffuseTexture",
    "specularGlossinessTexture",
    "sheenColorTexture",
    "specularColorTexture",
    "diffuseTransmissionColorTexture",
    "multiscatterColorTexture",
];
/// Textures of linear data.
const DATA: [&str; 12] = [
    "occlusionTexture",
    "clearcoatTexture",
    "sheenRoughnessTexture",
    "specularTexture",
    "transmissionTexture",
    "thicknessTexture",
    "iridescenceTexture",
    "iridescenceThicknessTexture",
    "anisotropyTexture",
    "diffuseTransmissionTexture",
    "metallicRoughnessTexture",
    "clearcoatRoughnessTexture",
];

/// A pair of a normal map and a roughness that share a place on the surface.
struct Pair {
    /// The pointer, inside the material, of the object with the roughness.
    of_roughness: &'static str,
    roughness: &'static str,
    factor: &'static str,
    /// The factor of a material without the property.
    missing_factor: f64,
    normal: &'static str,
    channel: usize,
}

const METALLIC_ROUGHNESS: &str = "/pbrMetallicRoughness";

const PAIRS: [Pair; 2] = [
    Pair {
        of_roughness: METALLIC_ROUGHNESS,
        roughness: "metallicRoughnessTexture",
        factor: "roughnessFactor",
        missing_factor: 1.0,
        normal: "/normalTexture",
        channel: 1,
    },
    Pair {
        of_roughness: "/extensions/KHR_materials_clearcoat",
        roughness: "clearcoatRoughnessTexture",
        factor: "clearcoatRoughnessFactor",
        missing_factor: 0.0,
        normal: "/extensions/KHR_materials_clearcoat/clearcoatNormalTexture",
        channel: 1,
    },
];

/// Returns all uses of textures that are known. Adds a property to materials that need a new roughness texture, and moves factors of
/// roughness into textures.
pub(super) fn uses(json: &mut Value, remarks: &mut Vec<String>) -> Result<Vec<Use>, FilterError> {
    let count = json["textures"].as_array().map_or(0, Vec::len);
    let mut all = Vec::new();
    let Some(materials) = json.get_mut("materials") else { return Ok(all) };
    let materials = materials.as_array_mut().ok_or_else(|| invalid("`materials` must be an array"))?;
    for (number, material) in materials.iter_mut().enumerate() {
        let before = all.len();
        let name = material["name"].as_str().map_or_else(|| number.to_string(), |name| format!("{name:?}"));
        let alpha = alpha_of(material);
        let mut of_material = Material { number, name, count, alpha, remarks, all: &mut all };
        for pair in &PAIRS {
            of_material.pair(material, pair);
        }
        of_material.others(material, "");
        // A texture with occlusion and roughness is one image.
        let of =
            |all: &[Use], key: &str| all[before..].iter().position(|of| of.pointer.ends_with(key)).map(|i| before + i);
        if let (Some(occlusion), Some(roughness)) =
            (of(&all, "/occlusionTexture"), of(&all, "/metallicRoughnessTexture"))
            && all[occlusion].texture.is_some()
            && all[occlusion].texture == all[roughness].texture
        {
            all[occlusion].treatment = all[roughness].treatment.clone();
        }
    }
    Ok(all)
}

struct Material<'a> {
    number: usize,
    name: String,
    /// The number of textures of the model.
    count: usize,
    /// What the alpha of the colour means.
    alpha: Alpha,
    remarks: &'a mut Vec<String>,
    all: &'a mut Vec<Use>,
}

impl Material<'_> {
    fn texture(&self, info: &Value) -> Option<usize> {
        info["index"].as_u64().map(|index| index as usize).filter(|&index| index < self.count)
    }

    fn remark(&mut self, text: &str) {
        self.remarks.push(format!("material {}: {text}", self.name));
    }

    /// Adds the uses of a roughness that is paired with normals.
    fn pair(&mut self, material: &mut Value, pair: &Pair) {
        let info = material.pointer(pair.normal).cloned().unwrap_or_default();
        let Some(normals) = self.texture(&info) else { return };
        let mut normals = Some((normals, scale_of(&info)));
        if pair.of_roughness == METALLIC_ROUGHNESS && material.get("pbrMetallicRoughness").is_none() {
            if material.pointer("/extensions/KHR_materials_pbrSpecularGlossiness").is_some() {
                self.remark("its glossiness does not get the spread of the normals");
                return;
            }
            material["pbrMetallicRoughness"] = json!({});
        }
        let Some(object) = material.pointer_mut(pair.of_roughness).filter(|object| object.is_object()) else { return };
        let factor = object[pair.factor].as_f64().unwrap_or(pair.missing_factor).clamp(0.0, 1.0) as f32;
        let texture = match object.get(pair.roughness) {
            Some(roughness) => {
                let Some(texture) = self.texture(roughness) else { return };
                if coordinates(roughness) != coordinates(&info) {
                    self.remark(
                        "its roughness has other texture coordinates than its normals, and does not get their spread",
                    );
                    normals = None;
                }
                Some(texture)
            }
            // A surface of full roughness does not get rougher.
            None if factor >= 1.0 => return,
            None => {
                let mut roughness = info.clone();
                roughness.as_object_mut().map(|info| info.remove("scale"));
                object[pair.roughness] = roughness;
                None
            }
        };
        // The texture contains the factor, because a rougher level can need more than the factor.
        let factor = if normals.is_some() { factor } else { 1.0 };
        if normals.is_some() {
            object[pair.factor] = json!(1.0);
        }
        let pointer = format!("/materials/{}{}/{}", self.number, pair.of_roughness, pair.roughness);
        let treatment = Treatment::Roughness { channel: pair.channel, factor, normals };
        self.all.push(Use { pointer, texture, like: self.texture(&info), treatment });
    }

    /// Adds all other uses in an object of the material.
    fn others(&mut self, object: &Value, path: &str) {
        for (key, value) in object.as_object().into_iter().flatten() {
            let path = format!("{path}/{}", key.replace('~', "~0").replace('/', "~1"));
            let pointer = format!("/materials/{}{path}", self.number);
            let texture = self.texture(value).filter(|_| key.ends_with("Texture"));
            let Some(texture) = texture else {
                if key != "extras" {
                    self.others(value, &path);
                }
                continue;
            };
            if self.all.iter().any(|of| of.pointer == pointer) {
                continue;
            }
            let treatment = match &**key {
                "normalTexture" | "clearcoatNormalTexture" => Treatment::Normals { scale: scale_of(value) },
                "baseColorTexture" | "diffuseTexture" => Treatment::Color { alpha: self.alpha },
                key if COLORS.contains(&key) => Treatment::Color { alpha: Alpha::Ignored },
                key if DATA.contains(&key) => Treatment::Data,
                // Nothing is known about what the texels mean.
                key => {
                    self.remark(&format!("{key} is of an unknown kind, and stays as it is"));
                    continue;
                }
            };
            self.all.push(Use { pointer, texture: Some(texture), like: Some(texture), treatment });
        }
    }
}

fn scale_of(info: &Value) -> f32 {
    info["scale"].as_f64().unwrap_or(1.0) as f32
}

/// Returns the set of texture coordinates and their transform.
fn coordinates(info: &Value) -> (u64, Value) {
    let transform = info["extensions"]["KHR_texture_transform"].clone();
    let set = transform["texCoord"].as_u64().or(info["texCoord"].as_u64()).unwrap_or(0);
    (set, transform)
}

/// Returns what the alpha of a material's colour means.
fn alpha_of(material: &Value) -> Alpha {
    match material["alphaMode"].as_str() {
        Some("BLEND") => Alpha::Blended,
        Some("MASK") => {
            let factor = &material["pbrMetallicRoughness"]["baseColorFactor"][3];
            let cutoff = material["alphaCutoff"].as_f64().unwrap_or(0.5) / factor.as_f64().unwrap_or(1.0).max(1e-3);
            Alpha::Masked { cutoff: (cutoff as f32).clamp(1.0 / 255.0, 1.0) }
        }
        _ => Alpha::Ignored,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(material: Value) -> (Value, Vec<Use>, Vec<String>) {
        let mut json = json!({ "textures": [{}, {}, {}, {}], "materials": [material] });
        let mut remarks = Vec::new();
        let uses = uses(&mut json, &mut remarks).unwrap();
        (json["materials"][0].clone(), uses, remarks)
    }

    #[test]
    fn roughness_gets_the_spread_of_its_normals() {
        let (material, uses, remarks) = of(json!({
            "normalTexture": { "index": 1, "scale": 0.5 },
            "occlusionTexture": { "index": 2 },
            "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 2 }, "roughnessFactor": 0.25, "baseColorTexture": { "index": 0 } },
            "emissiveTexture": { "index": 9 },
        }));
        let roughness = Treatment::Roughness { channel: 1, factor: 0.25, normals: Some((1, 0.5)) };
        let find =
            |end: &str| uses.iter().find(|of| of.pointer.ends_with(end)).map(|of| (of.texture, of.treatment.clone()));
        assert_eq!(find("/metallicRoughnessTexture"), Some((Some(2), roughness.clone())));
        assert_eq!(find("/occlusionTexture"), Some((Some(2), roughness)));
        assert_eq!(find("/normalTexture"), Some((Some(1), Treatment::Normals { scale: 0.5 })));
        assert_eq!(find("/baseColorTexture"), Some((Some(0), Treatment::Color { alpha: Alpha::Ignored })));
        assert_eq!((uses.len(), remarks.len()), (4, 0));
        assert_eq!(material["pbrMetallicRoughness"]["roughnessFactor"], 1.0);
    }

    #[test]
    fn smooth_materials_get_a_texture() {
        let transform = json!({ "KHR_texture_transform": { "scale": [2, 2] } });
        let (material, uses, _) = of(json!({
            "normalTexture": { "index": 1, "texCoord": 1, "scale": 2.0, "extensions": transform },
            "pbrMetallicRoughness": { "roughnessFactor": 0.3 },
        }));
        assert_eq!(uses[0].texture, None);
        assert_eq!(
            material["pbrMetallicRoughness"]["metallicRoughnessTexture"],
            json!({ "index": 1, "texCoord": 1, "extensions": transform })
        );
        let (rough, uses, _) = of(json!({ "normalTexture": { "index": 1 } }));
        assert_eq!(uses.len(), 1);
        assert!(rough["pbrMetallicRoughness"].get("metallicRoughnessTexture").is_none());
    }

    #[test]
    fn different_places_and_unknown_textures_stay() {
        let (material, uses, remarks) = of(json!({
            "normalTexture": { "index": 1, "texCoord": 1 },
            "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 2 }, "roughnessFactor": 0.25 },
            "extensions": { "X": { "oddTexture": { "index": 0 } } },
            "extras": { "baseColorTexture": { "index": 0 } },
        }));
        assert_eq!(uses[0].treatment, Treatment::Roughness { channel: 1, factor: 1.0, normals: None });
        assert_eq!((uses.len(), remarks.len()), (2, 2));
        assert_eq!(material["pbrMetallicRoughness"]["roughnessFactor"], 0.25);
    }

    #[test]
    fn masks_know_their_cutoff() {
        let (_, uses, _) = of(json!({
            "alphaMode": "MASK",
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "baseColorFactor": [1, 1, 1, 0.5] },
        }));
        assert_eq!(uses[0].treatment, Treatment::Color { alpha: Alpha::Masked { cutoff: 1.0 } });
    }
}
