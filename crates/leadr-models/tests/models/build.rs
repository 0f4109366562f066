//! Builds small models in code.

use leadr_models::{LoadOptions, Model, ModelFault};
use serde_json::{Value, json};

pub const I8: u32 = 5120;
pub const U8: u32 = 5121;
pub const I16: u32 = 5122;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// A model whose data are in the binary chunk.
#[derive(Clone)]
pub struct Builder {
    pub json: Value,
    pub binary: Vec<u8>,
}

impl Builder {
    pub fn new() -> Self {
        Self { json: json!({ "asset": { "version": "2.0" } }), binary: Vec::new() }
    }

    /// Appends a value to a list and returns its index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json.as_object_mut().unwrap().entry(list).or_insert_with(|| json!([])).as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    pub fn accessor(&mut self, shape: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({ "bufferView": view, "type": shape, "componentType": component, "count": count }))
    }

    pub fn floats(&mut self, shape: &str, numbers: &[f32]) -> usize {
        let size = match shape {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            other => panic!("{other}"),
        };
        let bytes: Vec<u8> = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(shape, F32, numbers.len() / size, &bytes)
    }

    pub fn shorts(&mut self, numbers: &[u16]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor("SCALAR", U16, numbers.len(), &bytes)
    }

    pub fn finished(&self) -> Value {
        let mut json = self.json.clone();
        if !self.binary.is_empty() && json.get("buffers").is_none() {
            json["buffers"] = json!([{ "byteLength": self.binary.len() }]);
        }
        json
    }

    pub fn glb(&self) -> Vec<u8> {
        glb(self.finished().to_string().as_bytes(), &self.binary)
    }

    pub fn load(&self) -> Result<Model, ModelFault> {
        decode(&self.glb())
    }

    /// Returns the model, which must load without an error.
    pub fn model(&self) -> Model {
        self.load().unwrap_or_else(|fault| panic!("{fault}: {}", self.finished()))
    }

    /// Returns the fault of a model that must not load.
    pub fn fault(&self) -> String {
        match self.load() {
            Ok(model) => panic!("was accepted: {} {:?}", self.finished(), model.remarks),
            Err(fault) => fault.to_string(),
        }
    }

    /// Returns the repaired model and its only remark, and checks that strict loading refuses the model for the same reason.
    pub fn repaired(&self) -> (Model, String) {
        let model = self.model();
        assert_eq!(model.remarks.len(), 1, "{:?}: {}", model.remarks, self.finished());
        let remark = model.remarks[0].clone();
        let fault = decode_strictly(&self.glb()).expect_err(&remark).to_string();
        let what = |text: &str| text.split("; ").next().unwrap().to_owned();
        assert!(what(&remark).contains(&what(&fault)), "{remark} / {fault}");
        (model, remark)
    }
}

pub fn decode(bytes: &[u8]) -> Result<Model, ModelFault> {
    Model::decode(bytes, "made", None, LoadOptions::default())
}

pub fn decode_strictly(bytes: &[u8]) -> Result<Model, ModelFault> {
    Model::decode(bytes, "made", None, LoadOptions { strict: true, ..LoadOptions::default() })
}

/// Returns a GLB container around JSON and binary data.
pub fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut chunks = Vec::new();
    for (kind, body, fill) in [(*b"JSON", json, b' '), (*b"BIN\0", binary, 0)] {
        if kind == *b"JSON" || !body.is_empty() {
            let length = body.len().next_multiple_of(4);
            chunks.extend((length as u32).to_le_bytes());
            chunks.extend(kind);
            chunks.extend(body);
            chunks.resize(chunks.len() + length - body.len(), fill);
        }
    }
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend((chunks.len() as u32 + 12).to_le_bytes());
    file.extend(chunks);
    file
}

/// Builds one triangle on one node, in the plane z = 0 and facing +z.
pub fn triangle() -> Builder {
    let mut made = Builder::new();
    let positions = made.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    made.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions } }] }));
    made.push("nodes", json!({ "mesh": 0 }));
    made
}

pub fn png(width: u32, height: u32, texels: &[u8]) -> Vec<u8> {
    use image::ImageEncoder;
    let mut bytes = Vec::new();
    let color = image::ExtendedColorType::Rgba8;
    image::codecs::png::PngEncoder::new(&mut bytes).write_image(texels, width, height, color).unwrap();
    bytes
}

pub fn jpeg(width: u32, height: u32, texels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let color = image::ExtendedColorType::Rgb8;
    let mut encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 95);
    encoder.encode(texels, width, height, color).unwrap();
    bytes
}

/// Builds a model with every supported feature: images of both formats, all material extensions, a skin of two joints,
/// sparse morph targets, all interpolations, cameras and lights.
pub fn everything() -> Builder {
    let mut made = Builder::new();
    let image = png(2, 2, &[255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 255, 64, 10, 20, 30, 0]);
    let view = made.view(&image);
    made.push("images", json!({ "bufferView": view, "mimeType": "image/png", "name": "paint" }));
    let view = made.view(&jpeg(8, 8, &[90; 192]));
    made.push("images", json!({ "bufferView": view, "mimeType": "image/jpeg" }));
    made.push("samplers", json!({ "wrapS": 33071, "wrapT": 33648, "magFilter": 9728 }));
    made.push("textures", json!({ "source": 0, "sampler": 0 }));
    made.push("textures", json!({ "source": 1 }));
    let moved = json!({ "KHR_texture_transform": { "offset": [0.1, 0.2], "rotation": 0.5, "scale": [2.0, 3.0], "texCoord": 1 } });
    made.push(
        "materials",
        json!({
            "name": "all",
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.6, 0.7, 0.8], "metallicFactor": 0.25, "roughnessFactor": 0.75,
                "baseColorTexture": { "index": 0, "extensions": moved },
                "metallicRoughnessTexture": { "index": 1, "texCoord": 1 },
            },
            "normalTexture": { "index": 1, "scale": 0.5 },
            "occlusionTexture": { "index": 1, "strength": 0.3 },
            "emissiveTexture": { "index": 0 },
            "emissiveFactor": [0.1, 0.2, 0.3],
            "alphaMode": "MASK", "alphaCutoff": 0.4, "doubleSided": true,
            "extensions": {
                "KHR_materials_emissive_strength": { "emissiveStrength": 10.0 },
                "KHR_materials_ior": { "ior": 1.33 },
                "KHR_materials_specular": {
                    "specularFactor": 0.9, "specularTexture": { "index": 0 },
                    "specularColorFactor": [1.0, 2.0, 0.5], "specularColorTexture": { "index": 1 },
                },
                "KHR_materials_anisotropy": {
                    "anisotropyStrength": 0.6, "anisotropyRotation": 1.5, "anisotropyTexture": { "index": 1 },
                },
                "KHR_materials_unlit": {},
            },
        }),
    );
    made.json["extensionsUsed"] = json!(["KHR_texture_transform", "KHR_lights_punctual"]);
    let positions = made.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    let normals = made.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let tangents = made.floats("VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(4));
    let first = made.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0]);
    let second = made.accessor("VEC2", U8, 4, &[0, 0, 255, 0, 255, 255, 0, 255]);
    made.json["accessors"][second]["normalized"] = json!(true);
    let colors = made.accessor("VEC3", U8, 4, &[255, 0, 51, 0, 255, 0, 0, 0, 255, 102, 0, 0]);
    made.json["accessors"][colors]["normalized"] = json!(true);
    let joints = made.accessor("VEC4", U8, 4, &[0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0]);
    let weights = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.25, 0.75, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    let weights = made.floats("VEC4", &weights);
    let indices = made.shorts(&[0, 1, 2, 0, 2, 3]);
    let sparse_indices = made.view(&[2, 0, 3, 0]);
    let sparse_values: Vec<u8> = [0.0f32, 0.0, 2.0, 0.0, 0.0, 4.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let sparse_values = made.view(&sparse_values);
    let target = made.push(
        "accessors",
        json!({
            "type": "VEC3", "componentType": F32, "count": 4,
            "sparse": {
                "count": 2,
                "indices": { "bufferView": sparse_indices, "componentType": U16 },
                "values": { "bufferView": sparse_values },
            },
        }),
    );
    made.push(
        "meshes",
        json!({
            "name": "sheet", "weights": [0.5],
            "extras": { "targetNames": ["lift"] },
            "primitives": [{
                "attributes": {
                    "POSITION": positions, "NORMAL": normals, "TANGENT": tangents, "TEXCOORD_0": first, "TEXCOORD_1": second,
                    "COLOR_0": colors, "JOINTS_0": joints, "WEIGHTS_0": weights,
                },
                "indices": indices, "material": 0, "targets": [{ "POSITION": target }],
            }],
        }),
    );
    let bind = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0].repeat(2);
    let bind = made.floats("MAT4", &bind);
    made.push("skins", json!({ "joints": [1, 2], "inverseBindMatrices": bind, "skeleton": 1 }));
    made.push(
        "cameras",
        json!({ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1, "aspectRatio": 1.5 } }),
    );
    let box_ = json!({ "xmag": 2.0, "ymag": 1.0, "znear": 0.0, "zfar": 10.0 });
    made.push("cameras", json!({ "type": "orthographic", "orthographic": box_ }));
    made.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional", "color": [1.0, 0.9, 0.8], "intensity": 3.0 },
        { "type": "spot", "range": 5.0, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.4 } },
        { "type": "point" },
    ] } });
    made.push("nodes", json!({ "name": "sheet", "mesh": 0, "skin": 0, "translation": [9.0, 9.0, 9.0] }));
    made.push("nodes", json!({ "name": "root", "children": [2, 3], "translation": [0.0, 0.0, 1.0] }));
    made.push("nodes", json!({ "name": "tip", "scale": [2.0, 2.0, 2.0] }));
    let matrix = [0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 5.0, 6.0, 7.0, 1.0];
    let light = json!({ "KHR_lights_punctual": { "light": 1 } });
    made.push("nodes", json!({ "matrix": matrix, "camera": 0, "extensions": light }));
    made.push("scenes", json!({ "name": "all", "nodes": [0, 1] }));
    made.json["scene"] = json!(0);
    let times = made.floats("SCALAR", &[0.0, 1.0, 2.0]);
    let slides = made.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 0.0, 0.0, 0.0]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let rotations = made.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half, 0.0, 0.0, 1.0, 0.0]);
    let lifts = made.floats("SCALAR", &[0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0]);
    made.push(
        "animations",
        json!({
            "name": "wave",
            "samplers": [
                { "input": times, "output": slides, "interpolation": "STEP" },
                { "input": times, "output": rotations },
                { "input": times, "output": lifts, "interpolation": "CUBICSPLINE" },
            ],
            "channels": [
                { "sampler": 0, "target": { "node": 1, "path": "translation" } },
                { "sampler": 1, "target": { "node": 2, "path": "rotation" } },
                { "sampler": 0, "target": { "node": 2, "path": "scale" } },
                { "sampler": 2, "target": { "node": 0, "path": "weights" } },
            ],
        }),
    );
    made
}
