//! Tests of extensions: compressed data, other materials, copies of meshes, and what is left out.

use serde_json::json;

use crate::build::{Builder, F32, U8, decode, decode_strictly, png, triangle};
use leadr_maps::material::{Encoding, Gloss, RoughnessMeaning};
use leadr_models::{LoadOptions, Model, Property};
use leadr_testing::memory::unmeasured;

/// A grid of 3 × 3 vertices with normals, texture coordinates and colours, from the reference encoder.
const DRACO: &str = "RFJBQ08CAgEBAAAACQgDCAEAA+/TGv8BEf8CiED/AohA/wKIQAQAAAABAAACAAD/AAABAgIEAQABAQMJAgEBAAEBCQMAAgABAAkDAAMCAQEBAQOhARk3kQP/N8kBl8kBn8kBBiRiGNEvmAAAAAD/AAAAAAAAPwAAAD8AAAAAAACAPwAAAAAAAAA/AAAAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAACAPwAAAD8AAAA/AACAPwAAgD8AAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AQEBAA8DHQcnVRU5DlkVBZrP+UuA////DwD9//7//wMA9P8AAAAEwP8DAADg/wEAAACAAAAA/w8AAAAABAAAAAD/PwAAAAAAAAAAAAAAAAAAAAAAQA4=";

/// Fifty-three triangles of 36 vertices, from meshoptimizer's own encoder. The first fifty are a grid.
const TRIANGLES: &str = "e1fe1e100e100e100e100efe1e190e180e170e160eff1e160e160e160e160eff1e160e160e160e160eff1e160e160e160e160eff2fff0f0c9f025f090c5f090c5f090c1f451813f10203007687566778a9866589689801690000";

fn base64(text: &str) -> Vec<u8> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let text = text.trim_end_matches('=').as_bytes();
    let sums = text.chunks(4).map(|four| (four, four.iter().fold(0u32, |sum, &c| sum << 6 | u32::from(digit(c)))));
    sums.flat_map(|(four, sum)| {
        let bytes = (sum << (6 * (4 - four.len()))).to_be_bytes();
        bytes[1..four.len()].to_vec()
    })
    .collect()
}

#[test]
fn draco_gives_the_grid_of_its_encoder() {
    let _unmeasured = unmeasured();
    let mut made = Builder::new();
    let view = made.view(&base64(DRACO));
    for (shape, component, count) in
        [("VEC3", F32, 9), ("VEC3", F32, 9), ("VEC2", F32, 9), ("VEC4", U8, 9), ("SCALAR", crate::build::U32, 24)]
    {
        made.push("accessors", json!({ "type": shape, "componentType": component, "count": count }));
    }
    made.json["accessors"][3]["normalized"] = json!(true);
    let ids = json!({ "POSITION": 3, "NORMAL": 2, "TEXCOORD_0": 1, "COLOR_0": 0 });
    made.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    made.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
    made.push(
        "meshes",
        json!({ "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2, "COLOR_0": 3 }, "indices": 4,
            "extensions": { "KHR_draco_mesh_compression": { "bufferView": view, "attributes": ids } },
        }] }),
    );
    made.push("nodes", json!({ "mesh": 0 }));
    let model = decode_strictly(&made.glb()).unwrap();
    assert!(model.remarks.is_empty(), "{:?}", model.remarks);
    let primitive = &model.meshes[0].primitives[0];
    assert_eq!((primitive.positions.len(), primitive.triangles.len()), (9, 8));
    let mut area = 0.0;
    for triangle in &primitive.triangles {
        let [a, b, c] = triangle.map(|v| glam::Vec3::from(primitive.positions[v as usize]));
        area += (b - a).cross(c - a).z / 2.0;
    }
    assert!((area - 4.0).abs() < 1e-3, "{area}");
    for vertex in 0..9 {
        let [x, y, z] = primitive.positions[vertex];
        let number = (3.0 * y + x).round();
        assert!((z - 0.25 * x * y).abs() < 1e-3, "{x} {y} {z}");
        let [s, t] = primitive.texcoords[0][vertex];
        assert!((s - x / 2.0).abs() < 1e-3 && (t - y / 2.0).abs() < 1e-3, "{s} {t}");
        assert!((primitive.normals[vertex][2] - 1.0).abs() < 1e-3);
        let color = primitive.colors.as_ref().unwrap()[vertex];
        assert!((color[0] - number * 20.0 / 255.0).abs() < 1e-4 && color[1] == 1.0, "{color:?}");
    }
    // Damaged data are a fault of the primitive.
    let start = made.json["bufferViews"][view]["byteOffset"].as_u64().unwrap_or(0) as usize;
    for at in 0..40 {
        let mut damaged = made.clone();
        damaged.binary[start + 7 * at] ^= 0x5a;
        let _ = decode(&damaged.glb());
    }
    made.binary[start..start + 5].fill(0);
    assert!(made.fault().contains("has damaged data of the compression Draco"), "{}", made.fault());
}

#[test]
fn meshopt_views_are_read_like_others() {
    const COUNT: usize = 3 * 53;
    let _unmeasured = unmeasured();
    let mut made = Builder::new();
    let floats: Vec<u8> = (0..36).flat_map(|i| [i as f32, (i * i) as f32, 0.5]).flat_map(f32::to_le_bytes).collect();
    let positions = made.view(&floats);
    made.push("accessors", json!({ "type": "VEC3", "componentType": F32, "count": 36, "bufferView": positions }));
    let bytes: Vec<u8> =
        (0..TRIANGLES.len()).step_by(2).map(|i| u8::from_str_radix(&TRIANGLES[i..i + 2], 16).unwrap()).collect();
    let offset = made.binary.len().next_multiple_of(4);
    made.view(&bytes);
    made.json["bufferViews"].as_array_mut().unwrap().pop();
    let extension = json!({
        "buffer": 0, "byteOffset": offset, "byteLength": bytes.len(), "byteStride": 2, "count": COUNT, "mode": "TRIANGLES",
    });
    let compression = json!({ "EXT_meshopt_compression": extension });
    let view = made.push("bufferViews", json!({ "buffer": 1, "byteLength": 2 * COUNT, "extensions": compression }));
    let indices = json!({ "type": "SCALAR", "componentType": 5123, "count": COUNT, "bufferView": view });
    made.push("accessors", indices);
    made.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }));
    made.push("nodes", json!({ "mesh": 0 }));
    made.json["extensionsRequired"] = json!(["EXT_meshopt_compression"]);
    let fallback = json!({ "EXT_meshopt_compression": { "fallback": true } });
    let length = made.binary.len();
    made.json["buffers"] = json!([{ "byteLength": length }, { "byteLength": 2 * COUNT, "extensions": fallback }]);
    let model = decode_strictly(&made.glb()).unwrap();
    let sorted = |mut corners: [u32; 3]| {
        corners.sort_unstable();
        corners
    };
    let number = |corner: [f32; 3]| corner[0] as u32;
    let found = model.meshes[0].primitives[0].positions.as_chunks::<3>().0.iter().map(|t| sorted(t.map(number)));
    let grid = (0..5u32).flat_map(|y| (0..5).map(move |x| 6 * y + x));
    let wanted = grid.flat_map(|a| [[a, a + 1, a + 6], [a + 1, a + 6, a + 7]]);
    let last = [[0, 12, 35], [0, 2, 35], [1, 2, 3]];
    assert_eq!(found.collect::<Vec<_>>(), wanted.chain(last).collect::<Vec<_>>());
    made.binary[offset] = 0;
    assert!(made.fault().contains("has damaged data of the compression"), "{}", made.fault());
}

#[test]
fn specular_and_gloss_become_f0_and_roughness() {
    let _unmeasured = unmeasured();
    let material = |extension: serde_json::Value| {
        let mut made = triangle();
        for texels in [[255, 255, 255, 255], [188, 0, 0, 64]] {
            let view = made.view(&png(1, 1, &texels));
            let image = made.push("images", json!({ "bufferView": view }));
            made.push("textures", json!({ "source": image }));
        }
        let coordinates = made.floats("VEC2", &[0.0; 6]);
        let primitive = &mut made.json["meshes"][0]["primitives"][0];
        (primitive["attributes"]["TEXCOORD_0"], primitive["material"]) = (json!(coordinates), json!(0));
        made.push("materials", json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": extension } }));
        made.json["extensionsUsed"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
        let model = made.model();
        assert!(model.remarks.is_empty(), "{:?}", model.remarks);
        model.materials[0].clone()
    };
    let plain = material(json!({
        "diffuseFactor": [0.5, 0.25, 0.125, 0.75], "specularFactor": [0.5, 0.25, 0.0], "glossinessFactor": 0.75,
    }));
    assert_eq!(plain.base_color.factor, [0.25, 0.125, 0.0625]);
    assert_eq!((plain.f0.factor, plain.metalness.factor), ([0.5, 0.25, 0.0], 0.0));
    assert_eq!(plain.roughness_meaning, RoughnessMeaning::Gloss(Gloss::Perceptual));
    assert_eq!(plain.roughness_meaning.alpha(plain.roughness.factor), 0.0625);
    let textured = material(json!({
        "diffuseTexture": { "index": 0 }, "specularGlossinessTexture": { "index": 1 }, "glossinessFactor": 0.5,
    }));
    let color = textured.base_color.texture.as_ref().unwrap().raster.color(0, 0, Encoding::Srgb);
    // The code 188 is a linear 0.5.
    assert!(color.iter().all(|c| (c - 0.5).abs() < 0.01), "{color:?}");
    let f0 = textured.f0.texture.as_ref().unwrap().raster.color(0, 0, Encoding::Srgb);
    assert!((f0[0] - 0.5).abs() < 0.01 && f0[1] == 0.0, "{f0:?}");
    let gloss = &textured.roughness;
    let texel = gloss.texture.as_ref().unwrap().raster.value(0, 0, gloss.channel);
    assert!((texel - 64.0 / 255.0).abs() < 1e-6 && gloss.factor == 0.5);
}

#[test]
fn variants_are_selected_by_name() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    for name in ["day", "night"] {
        made.push("materials", json!({ "name": name }));
    }
    let mappings = json!([{ "material": 1, "variants": [1] }]);
    let primitive = &mut made.json["meshes"][0]["primitives"][0];
    primitive["material"] = json!(0);
    primitive["extensions"] = json!({ "KHR_materials_variants": { "mappings": mappings } });
    let variants = json!([{ "name": "Day" }, { "name": "Night" }]);
    made.json["extensions"] = json!({ "KHR_materials_variants": { "variants": variants } });
    let material = |variant: Option<&str>| {
        let options = LoadOptions { variant: variant.map(str::to_owned), ..LoadOptions::default() };
        let model = Model::decode(&made.glb(), "made", None, options);
        model.map(|model| model.meshes[0].primitives[0].material).map_err(|fault| fault.to_string())
    };
    assert_eq!([None, Some("Day"), Some("Night")].map(material), [Ok(0), Ok(0), Ok(1)]);
    let fault = material(Some("Dusk")).unwrap_err();
    assert!(fault.contains("it has no variant named Dusk; available: Day, Night"), "{fault}");
}

#[test]
fn instances_are_placed_under_their_node() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    let translations = made.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 2.0, 3.0]);
    let scales = made.floats("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    let attributes = json!({ "TRANSLATION": translations, "SCALE": scales });
    made.json["nodes"][0]["translation"] = json!([10.0, 0.0, 0.0]);
    made.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    made.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let model = decode_strictly(&made.glb()).unwrap();
    let pose = model.pose(None, 0.0);
    let drawn: Vec<usize> = model.shown_nodes().into_iter().filter(|&node| model.nodes[node].mesh.is_some()).collect();
    assert_eq!(drawn, [1, 2]);
    let corner = model.posed_vertices(&pose, 2, 0).positions[1];
    assert_eq!(corner, [10.0 + 1.0 + 2.0, 2.0, 3.0]);
    // A count that no data back is refused before memory is reserved.
    made.json["accessors"][translations] = json!({ "type": "VEC3", "componentType": F32, "count": 1u64 << 40 });
    made.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] =
        json!({ "TRANSLATION": translations });
    assert!(made.fault().contains("is too large"), "{}", made.fault());
}

#[test]
fn hidden_nodes_and_coarser_levels_are_not_shown() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    made.push("nodes", json!({ "children": [2], "extensions": { "KHR_node_visibility": { "visible": false } } }));
    made.push("nodes", json!({ "mesh": 0 }));
    made.push("nodes", json!({ "mesh": 0 }));
    made.json["nodes"][0]["extensions"] = json!({ "MSFT_lod": { "ids": [3] } });
    assert_eq!(decode_strictly(&made.glb()).unwrap().shown_nodes(), [0]);
}

#[test]
fn pointers_to_nodes_move_them() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    let (input, output) = (made.floats("SCALAR", &[0.0, 1.0]), made.floats("VEC3", &[0.0; 6]));
    let channel = |pointer: &str| {
        let extension = json!({ "KHR_animation_pointer": { "pointer": pointer } });
        json!({ "sampler": 0, "target": { "path": "pointer", "extensions": extension } })
    };
    let channels = [channel("/nodes/0/translation"), channel("/materials/0/emissiveFactor"), channel("/nodes/7/scale")];
    made.push("animations", json!({ "samplers": [{ "input": input, "output": output }], "channels": channels }));
    let model = made.model();
    assert_eq!(model.animations[0].channels.len(), 1);
    assert_eq!(
        (model.animations[0].channels[0].node, model.animations[0].channels[0].property),
        (0, Property::Translation)
    );
    assert!(
        model.remarks[0].contains("animates `/materials/0/emissiveFactor`, which is not supported"),
        "{:?}",
        model.remarks
    );
}

/// A coat is smooth without a normal texture, follows the relief with that of the material, and has its own relief otherwise.
#[test]
fn clear_coats_have_textures_and_a_relief() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    let view = made.view(&png(1, 1, &[51, 102, 255, 255]));
    made.push("images", json!({ "bufferView": view }));
    made.push("textures", json!({ "source": 0 }));
    let coordinates = made.floats("VEC2", &[0.0; 6]);
    let primitive = &mut made.json["meshes"][0]["primitives"][0];
    (primitive["attributes"]["TEXCOORD_0"], primitive["material"]) = (json!(coordinates), json!(0));
    made.json["extensionsUsed"] = json!(["KHR_materials_clearcoat"]);
    let mut coat = |factors: serde_json::Value| {
        let extensions = json!({ "KHR_materials_clearcoat": factors });
        let normals = json!({ "index": 0, "scale": 0.5 });
        made.json["materials"] = json!([{ "normalTexture": normals, "extensions": extensions }]);
        decode_strictly(&made.glb()).map(|model| model.materials[0].coat.clone().unwrap())
    };
    let plain = coat(json!({ "clearcoatFactor": 0.8, "clearcoatRoughnessFactor": 0.3 })).unwrap();
    assert_eq!((plain.weight.factor, plain.roughness.factor, plain.follows_relief), (0.8, 0.3, false));
    assert_eq!((plain.roughness_meaning, plain.textures().count()), (RoughnessMeaning::Perceptual, 0));
    let index = json!({ "index": 0 });
    let textured = coat(json!({
        "clearcoatFactor": 1.0, "clearcoatTexture": index, "clearcoatRoughnessTexture": index, "clearcoatNormalTexture": index
    }));
    let textured = textured.unwrap();
    assert_eq!((textured.weight.channel, textured.roughness.channel), (0, 1));
    assert!(textured.normal_map.is_some() && !textured.follows_relief);
    assert_eq!(textured.textures().count(), 3);
    let same = coat(json!({ "clearcoatFactor": 1.0, "clearcoatNormalTexture": { "index": 0, "scale": 0.5 } })).unwrap();
    assert!(same.follows_relief && same.normal_map.is_none());
    let fault = coat(json!({ "clearcoatFactor": 1.5 })).unwrap_err().to_string();
    assert!(fault.contains("clearcoatFactor"), "{fault}");
}

#[test]
fn light_passes_thin_and_solid_materials() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    made.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    made.json["extensionsUsed"] = json!(["KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_ior"]);
    let thin = json!({ "KHR_materials_transmission": { "transmissionFactor": 0.9 } });
    made.json["materials"] = json!([{ "extensions": thin }]);
    let passed = decode_strictly(&made.glb()).unwrap().materials[0].transmission.unwrap();
    assert_eq!((passed.weight, passed.ior, passed.thickness), (0.9, 1.5, 0.0));
    assert_eq!(passed.attenuation_distance, f32::INFINITY);
    let solid = json!({
        "KHR_materials_transmission": { "transmissionFactor": 1.0 },
        "KHR_materials_ior": { "ior": 1.33 },
        "KHR_materials_volume": { "thicknessFactor": 0.2, "attenuationDistance": 0.5, "attenuationColor": [0.2, 0.8, 0.6] },
    });
    made.json["materials"] = json!([{ "extensions": solid }]);
    let passed = decode_strictly(&made.glb()).unwrap().materials[0].transmission.unwrap();
    assert_eq!((passed.ior, passed.thickness, passed.attenuation_distance), (1.33, 0.2, 0.5));
    assert_eq!(passed.attenuation_color, [0.2, 0.8, 0.6]);
    made.json["materials"][0]["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = json!(-1);
    let fault = decode_strictly(&made.glb()).unwrap_err().to_string();
    assert!(fault.contains("transmissionFactor"), "{fault}");
}

/// The image of an extension is used, or the plain image beside it.
#[test]
fn textures_of_other_formats_have_an_image() {
    let _unmeasured = unmeasured();
    for (extension, both, wanted) in [
        ("EXT_texture_webp", false, Some(1)),
        ("EXT_texture_webp", true, Some(1)),
        ("KHR_texture_basisu", true, Some(0)),
        ("MSFT_texture_dds", true, Some(0)),
        ("EXT_texture_avif", false, Some(1)),
        ("KHR_texture_basisu", false, None),
    ] {
        let mut made = triangle();
        for texel in [0, 51] {
            let view = made.view(&png(1, 1, &[texel, 0, 0, 255]));
            made.push("images", json!({ "bufferView": view }));
        }
        // A KTX2 texture of 4 × 4 texels with BasisLZ.
        let words = [0u32, 1, 4, 4, 0, 0, 1, 1, 1].map(u32::to_le_bytes).concat();
        let level = [104u64, 16, 16].map(u64::to_le_bytes).concat();
        let ktx2 = made.view(&[b"\xabKTX 20\xbb\r\n\x1a\n", &words[..], &[0; 32], &level, &[0; 16]].concat());
        made.push("images", json!({ "bufferView": ktx2 }));
        let source = if wanted.is_none() { 2 } else { 1 };
        made.push("textures", json!({ "extensions": { extension: { "source": source } } }));
        if both {
            made.json["textures"][0]["source"] = json!(0);
        }
        made.push("materials", json!({ "emissiveTexture": { "index": 0 } }));
        let coordinates = made.floats("VEC2", &[0.0; 6]);
        let primitive = &mut made.json["meshes"][0]["primitives"][0];
        (primitive["attributes"]["TEXCOORD_0"], primitive["material"]) = (json!(coordinates), json!(0));
        made.json["extensionsRequired"] = json!([extension]);
        let model = made.model();
        let raster = &model.materials[0].emission.texture.as_ref().unwrap().raster;
        match wanted {
            Some(image) => {
                assert!(model.remarks.is_empty(), "{extension}: {:?}", model.remarks);
                assert_eq!(raster.value(0, 0, 0), [0.0, 0.2][image], "{extension}");
            }
            None => assert!(
                model.remarks.len() == 1 && model.remarks[0].contains("gltf-transform ktxdecompress IN.glb OUT.glb"),
                "{:?}",
                model.remarks
            ),
        }
    }
}

/// A required extension that adds a look, or that is unknown, is left out with a remark.
#[test]
fn required_looks_are_left_out() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    made.json["extensionsUsed"] = json!(["KHR_materials_sheen", "KHR_xmp_json_ld"]);
    made.json["extensionsRequired"] = json!(["KHR_materials_sheen"]);
    let remarks = made.model().remarks;
    let wanted = "requires unsupported extensions, and is drawn without them: KHR_materials_sheen";
    assert_eq!(remarks, [wanted]);
    let fault = decode_strictly(&made.glb()).unwrap_err().to_string();
    assert!(
        fault.contains("it requires KHR_materials_sheen; export it without, or load it without --strict"),
        "{fault}"
    );
    // Without its data, nothing is left to draw.
    made.json["extensionsRequired"] = json!(["XYZ_mesh_compression"]);
    made.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert!(made.fault().contains("accessor 0: has no data without XYZ_mesh_compression"), "{}", made.fault());
}
