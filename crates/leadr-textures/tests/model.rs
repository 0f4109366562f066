//! Rewritten models: what engines find in the file, and what stays as it was.

use leadr_models::{Document, LoadOptions, Model};
use leadr_textures::engine::Engine;
use leadr_textures::model::{FilterError, FilteredModel, filter_model};
use serde_json::{Value, json};

/// Returns the bytes of a PNG of this size with the given RGB texels.
fn png(size: u32, texel: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    let image = image::RgbImage::from_fn(size, size, |x, y| image::Rgb(texel(x, y)));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// Returns a triangle with a material. Each part becomes a buffer view, after those of the mesh.
fn model(materials: Value, images: &[Vec<u8>], textures: Value) -> Vec<u8> {
    let positions = [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut binary = Vec::new();
    let mut views = Vec::new();
    let mut view = |bytes: &[u8]| {
        binary.resize(binary.len().next_multiple_of(4), 0u8);
        views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len() }));
        binary.extend(bytes);
        views.len() - 1
    };
    // The images come before the mesh, so the mesh moves when they are cut out.
    let images: Vec<Value> = images
        .iter()
        .enumerate()
        .map(|(i, png)| json!({ "name": format!("image {i}"), "mimeType": "image/png", "bufferView": view(png) }))
        .collect();
    let of = |floats: &[f32]| floats.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let (position, coordinates) = (view(&of(positions.as_flattened())), view(&of(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0])));
    let json = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 }] }],
        "accessors": [
            { "bufferView": position, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": coordinates, "componentType": 5126, "count": 3, "type": "VEC2" },
        ],
        "materials": materials,
        "images": images,
        "textures": textures,
        "samplers": [{ "minFilter": 9729 }],
        "bufferViews": views,
        "buffers": [{ "byteLength": binary.len() }],
        "extras": { "kept": [1, 2.5, "x"] },
    });
    glb(&json, &binary)
}

fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let whole = 28 + text.len() + binary.len();
    let mut file = b"glTF".to_vec();
    file.extend([2, whole as u32, text.len() as u32].into_iter().flat_map(u32::to_le_bytes));
    file.extend(b"JSON");
    file.extend(text);
    file.extend((binary.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(binary);
    file
}

fn open(bytes: &[u8]) -> Document {
    Document::decode(bytes, None, &LoadOptions::default()).expect("a document")
}

fn filtered(bytes: &[u8]) -> Result<FilteredModel, FilterError> {
    filter_model(open(bytes), Engine::Gltf, &mut |_, _| {})
}

/// The file of an image in a buffer view, and its JSON.
fn image(document: &Document, number: usize) -> (Vec<u8>, Value) {
    let image = document.json["images"][number].clone();
    let view = &document.json["bufferViews"][image["bufferView"].as_u64().unwrap() as usize];
    let [at, length] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap() as usize);
    (document.buffers[0].as_ref().unwrap()[at..at + length].to_vec(), image)
}

/// Returns the mean of a channel of each level of a UASTC file.
fn means(file: &[u8], channel: usize) -> Vec<f64> {
    use basis_universal::transcoding::{
        DecodeFlags, LowLevelUastcTranscoder, SliceParametersUastc, TranscoderBlockFormat,
    };
    let reader = ktx2::Reader::new(file).expect("a KTX2 file");
    let header = reader.header();
    let transcoder = LowLevelUastcTranscoder::new();
    let mean = |(number, level): (usize, ktx2::Level<'_>)| {
        let blocks = zstd::bulk::decompress(level.data, level.uncompressed_byte_length as usize).unwrap();
        let [width, height] = [header.pixel_width, header.pixel_height].map(|side| (side >> number).max(1));
        let parameters = SliceParametersUastc {
            num_blocks_x: width.div_ceil(4),
            num_blocks_y: height.div_ceil(4),
            has_alpha: true,
            original_width: width,
            original_height: height,
        };
        let bc7 = transcoder
            .transcode_slice(&blocks, parameters, DecodeFlags::empty(), TranscoderBlockFormat::BC7)
            .expect("UASTC blocks");
        let (wide, high) = (width.next_multiple_of(4), height.next_multiple_of(4));
        let mut texels = vec![0; (wide * high) as usize];
        texture2ddecoder::decode_bc7(&bc7, wide as usize, high as usize, &mut texels).unwrap();
        let of = |x: u32, y: u32| f64::from(texels[(y * wide + x) as usize].to_le_bytes()[[2, 1, 0, 3][channel]]);
        let all = (0..height).flat_map(|y| (0..width).map(move |x| of(x, y)));
        all.sum::<f64>() / (255.0 * f64::from(width * height))
    };
    reader.levels().enumerate().map(mean).collect()
}

fn zigzag(x: u32, _: u32) -> [u8; 3] {
    if x.is_multiple_of(2) { [178, 128, 245] } else { [78, 128, 245] }
}

#[test]
fn engines_find_rougher_levels() {
    let materials = json!([{
        "normalTexture": { "index": 0 },
        "pbrMetallicRoughness": {
            "metallicRoughnessTexture": { "index": 1 }, "roughnessFactor": 0.5, "baseColorTexture": { "index": 2 },
        },
        "occlusionTexture": { "index": 1 },
    }]);
    let textures = json!([{ "source": 0, "sampler": 0 }, { "source": 1 }, { "source": 2 }]);
    let images =
        [png(32, zigzag), png(32, |_, _| [200, 102, 30]), png(32, |x, _| if x < 16 { [0; 3] } else { [255; 3] })];
    let source = model(materials, &images, textures);
    let mut steps = Vec::new();
    let found =
        filter_model(open(&source), Engine::Gltf, &mut |done, all| steps.push((done, all))).expect("a filtered model");
    assert_eq!(steps, [(0, 3), (1, 3), (2, 3), (3, 3)]);
    assert_eq!(found.remarks, [""; 0]);
    let roles: Vec<_> = found.textures.iter().map(|texture| (texture.role, texture.size)).collect();
    assert_eq!(roles, [("roughness", [32, 32]), ("normals", [32, 32]), ("colour", [32, 32])]);
    let glb = found.glb().unwrap();
    let result = open(&glb);
    let json = &result.json;
    assert_eq!(json["extras"], json!({ "kept": [1, 2.5, "x"] }));
    assert_eq!(json["extensionsRequired"], json!(["KHR_texture_basisu"]));
    assert_eq!(json["samplers"][0]["minFilter"], 9987);
    assert_eq!(json["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"], 1.0);
    assert_eq!(json["textures"].as_array().unwrap().len(), 3);
    assert_eq!(json["materials"][0]["occlusionTexture"]["index"], 1);
    let (file, entry) = image(&result, 1);
    assert_eq!((&entry["name"], &entry["mimeType"]), (&json!("image 1"), &json!("image/ktx2")));
    // The first level has the factor, and others also the spread of the normals, whose tilt is 22 degrees either way.
    let rough = means(&file, 1);
    assert_eq!(rough.len(), 6);
    assert!(
        (rough[0] - 0.2).abs() < 0.01 && rough[1..].iter().all(|r| *r > 0.5 && (r - rough[1]).abs() < 0.02),
        "{rough:?}"
    );
    let (other, occlusion) = (means(&file, 2), means(&file, 0));
    assert!(
        other.iter().all(|v| (v - 30.0 / 255.0).abs() < 0.01)
            && occlusion.iter().all(|v| (v - 200.0 / 255.0).abs() < 0.01)
    );
    // Normals point up, with length 1; colours are means of light.
    let normals = image(&result, 0).0;
    assert!(means(&normals, 2)[1..].iter().all(|z| *z > 0.99), "{:?}", means(&normals, 2));
    let colors = means(&image(&result, 2).0, 0);
    assert!((colors[5] - 188.0 / 255.0).abs() < 0.01, "{colors:?}");
    // The mesh is the same, and the old images are gone.
    let mesh = |bytes: &[u8]| Model::decode(bytes, "m", None, LoadOptions::default()).unwrap().meshes;
    assert_eq!(mesh(&glb), mesh(&source));
    let buffer = result.buffers[0].as_ref().unwrap();
    assert!(!buffer.windows(4).any(|bytes| bytes == b"\x89PNG"));
}

#[test]
fn one_image_with_two_partners_becomes_two() {
    let material = |normal: Value| json!({ "normalTexture": normal, "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 1 } } });
    let materials = json!([material(json!({ "index": 0 })), material(json!({ "index": 0, "scale": 0.2 })), { "emissiveTexture": { "index": 1 } }]);
    let textures = json!([{ "source": 0 }, { "source": 1 }]);
    let images = [png(16, zigzag), png(16, |_, _| [0, 51, 255])];
    let found = filtered(&model(materials, &images, textures)).unwrap();
    let result = open(&found.glb().unwrap());
    let of = |material: usize, key: &str| {
        let texture = result.json.pointer(&format!("/materials/{material}/{key}/index")).unwrap().as_u64().unwrap();
        let texture = &result.json["textures"][texture as usize];
        assert!(texture["source"].is_null());
        image(&result, texture["extensions"]["KHR_texture_basisu"]["source"].as_u64().unwrap() as usize).0
    };
    let roughness = "pbrMetallicRoughness/metallicRoughnessTexture";
    let (full, flatter) = (means(&of(0, roughness), 1)[3], means(&of(1, roughness), 1)[3]);
    assert!(full > 0.5 && flatter < 0.4 && flatter > 0.2, "{full} {flatter}");
    // The same image as a colour.
    assert!(means(&of(2, "emissiveTexture"), 2)[0] > 0.99);
    assert_eq!(result.json["textures"].as_array().unwrap().len(), 5);
}

#[test]
fn materials_without_a_roughness_texture_get_one() {
    let materials = json!([{ "normalTexture": { "index": 0 }, "pbrMetallicRoughness": { "roughnessFactor": 0.2 } }]);
    let source = model(materials, &[png(32, zigzag)], json!([{ "source": 0, "sampler": 0 }]));
    let found = filtered(&source).unwrap();
    let result = open(&found.glb().unwrap());
    let info = &result.json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"];
    let texture = &result.json["textures"][info["index"].as_u64().unwrap() as usize];
    assert_eq!(texture["sampler"], 0);
    let file = image(&result, texture["extensions"]["KHR_texture_basisu"]["source"].as_u64().unwrap() as usize).0;
    let (rough, metal) = (means(&file, 1), means(&file, 2));
    assert!((rough[0] - 0.2).abs() < 0.01 && rough[2] > 0.5, "{rough:?}");
    // The metalness factor alone decides.
    assert!(metal.iter().all(|v| *v > 0.99));
}

#[test]
fn sides_become_multiples_of_a_block() {
    let materials = json!([{ "emissiveTexture": { "index": 0 } }, { "emissiveTexture": { "index": 1 } }]);
    let images = [png(18, |_, _| [90; 3]), png(3, |_, _| [90; 3])];
    let source = model(materials, &images, json!([{ "source": 0 }, { "source": 1 }]));
    let found = filtered(&source).unwrap();
    assert_eq!(found.textures[0].size, [16, 16]);
    assert_eq!(found.remarks.len(), 1);
    assert!(found.remarks[0].contains("3 x 3 texels"));
    let result = open(&found.glb().unwrap());
    assert_eq!(result.json["textures"][1], json!({ "source": 1 }));
    assert!(image(&result, 1).0.starts_with(b"\x89PNG"));
    assert!((means(&image(&result, 0).0, 0)[0] - 90.0 / 255.0).abs() < 0.01);
}

#[test]
fn models_without_textures_are_refused() {
    let source = model(json!([{ "pbrMetallicRoughness": {} }]), &[], json!([]));
    let fault = filtered(&source).unwrap_err();
    assert!(matches!(fault, FilterError::Nothing));
    let broken =
        model(json!([{ "emissiveTexture": { "index": 0 } }]), &[b"not a picture".to_vec()], json!([{ "source": 0 }]));
    assert_eq!(open(&broken).remarks.len(), 1);
    assert!(matches!(filtered(&broken).unwrap_err(), FilterError::Nothing));
    let odd = model(json!({}), &[], json!([]));
    assert!(matches!(filtered(&odd).unwrap_err(), FilterError::Invalid { .. }));
}

#[test]
fn bevy_gets_plain_images_and_godot_keeps_its_colors() {
    let materials = json!([{
        "normalTexture": { "index": 0 },
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 1 }, "roughnessFactor": 0.5 },
    }]);
    let images = [png(16, zigzag), png(16, |_, _| [90; 3])];
    let source = model(materials, &images, json!([{ "source": 0 }, { "source": 1 }]));
    let bevy = filter_model(open(&source), Engine::Bevy, &mut |_, _| {}).unwrap();
    let result = open(&bevy.glb().unwrap());
    assert!(result.json["extensionsUsed"].is_null() && result.json["extensionsRequired"].is_null());
    assert_eq!(result.json["textures"], json!([{ "source": 0 }, { "source": 1 }, { "source": 2 }]));
    for number in 0..3 {
        let file = image(&result, number).0;
        let srgb = if number == 1 { ktx2::Format::BC7_SRGB_BLOCK } else { ktx2::Format::BC7_UNORM_BLOCK };
        assert_eq!(ktx2::Reader::new(&file).unwrap().header().format, Some(srgb));
    }
    let godot = filter_model(open(&source), Engine::Godot, &mut |_, _| {}).unwrap();
    let files = godot.files("my model").unwrap();
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["my model_image0.ktx2", "my model_image2.ktx2", "my model.bin", "my model.gltf"]);
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in &files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let again = Document::open(folder.path().join("my model.gltf"), &LoadOptions::default()).unwrap();
    assert_eq!(again.images.iter().map(|image| image.file.is_some()).collect::<Vec<_>>(), [true, false, true]);
    // The colour is still a PNG in the buffer.
    assert!(image(&again, 1).0.starts_with(b"\x89PNG") && again.images[1].raster.is_some());
}

/// Returns the JSON pointers of all values inside a value.
fn pointers(value: &Value, at: &str, all: &mut Vec<String>) {
    let mut inside = |key: &str, value: &Value| {
        let at = format!("{at}/{key}");
        all.push(at.clone());
        pointers(value, &at, all);
    };
    match value {
        Value::Object(values) => values.iter().for_each(|(key, value)| inside(key, value)),
        Value::Array(values) => values.iter().enumerate().for_each(|(i, value)| inside(&i.to_string(), value)),
        _ => {}
    }
}

#[test]
fn no_value_of_a_model_is_trusted() {
    let materials = json!([
        {
            "normalTexture": { "index": 0, "scale": 0.5, "texCoord": 0 },
            "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 1 }, "roughnessFactor": 0.5 },
            "occlusionTexture": { "index": 1 },
            "alphaMode": "MASK",
            "alphaCutoff": 0.5,
        },
        { "extensions": { "KHR_materials_clearcoat": { "clearcoatNormalTexture": { "index": 0 }, "clearcoatRoughnessFactor": 0.2 } } },
    ]);
    let images = [png(4, zigzag), png(4, |_, _| [90; 3])];
    let textures = json!([
        { "source": 0, "sampler": 0 },
        { "source": 1, "extensions": { "EXT_texture_webp": { "source": 1 } } },
    ]);
    let source = model(materials, &images, textures);
    let document = open(&source);
    let mut all = Vec::new();
    pointers(&document.json, "", &mut all);
    let hostile = [
        json!(null),
        json!(-1),
        json!(u64::MAX),
        json!(1e300),
        json!(2),
        json!("x"),
        json!([]),
        json!({}),
        json!([{}]),
    ];
    let (mut whole, mut refused) = (0, 0);
    for pointer in &all {
        for value in &hostile {
            let mut json = document.json.clone();
            *json.pointer_mut(pointer).unwrap() = value.clone();
            let file = glb(&json, document.buffers[0].as_ref().unwrap());
            let Ok(changed) = Document::decode(&file, None, &LoadOptions::default()) else { continue };
            match filter_model(changed, Engine::Bevy, &mut |_, _| {})
                .and_then(|model| model.clone().glb().map(|glb| (model, glb)))
            {
                Ok((model, glb)) => {
                    whole += 1;
                    assert!(model.files("model").is_ok(), "{pointer} {value}");
                    assert!(Document::decode(&glb, None, &LoadOptions::default()).is_ok(), "{pointer} {value}");
                }
                Err(fault) => {
                    refused += 1;
                    assert!(!fault.to_string().contains('\n'), "{fault}");
                }
            }
        }
    }
    assert!(whole > 100 && refused > 10, "{whole} {refused} of {}", all.len() * hostile.len());
}
