//! Tests of models in files: external files, forbidden paths, and replacements.

use std::fs;
use std::path::Path;

use leadr_maps::HeightMap;
use leadr_maps::folders::OutsideLinks;
use leadr_maps::reads::{FileRead, recorded};
use leadr_maps::save::encode_png_grey16;
use leadr_models::{LoadOptions, Model, ModelFault};
use serde_json::{Value, json};

use crate::build::{F32, decode, decode_strictly, everything, glb, png, triangle};
use leadr_testing::memory::{alone, measured, unmeasured};

const STRICT: LoadOptions = LoadOptions { strict: true, variant: None, links: OutsideLinks::Refused };

/// Writes a triangle whose base colour is the image at `uri`.
fn painted(folder: &Path, uri: &str) -> std::path::PathBuf {
    let mut made = triangle();
    made.push("images", json!({ "uri": uri }));
    made.push("textures", json!({ "source": 0 }));
    let texture = json!({ "index": 0 });
    let base = json!({ "baseColorTexture": texture, "metallicRoughnessTexture": texture });
    made.push("materials", json!({ "pbrMetallicRoughness": base, "normalTexture": texture }));
    made.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    made.json["buffers"] = json!([{ "byteLength": made.binary.len(), "uri": "data%20of/it.bin" }]);
    fs::create_dir_all(folder.join("data of")).unwrap();
    fs::write(folder.join("data of/it.bin"), &made.binary).unwrap();
    let path = folder.join("painted.gltf");
    fs::write(&path, made.finished().to_string()).unwrap();
    path
}

#[test]
fn files_beside_a_model_are_found_by_their_encoded_names() {
    let _unmeasured = unmeasured();
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("maps")).unwrap();
    fs::write(folder.path().join("maps/é 1.png"), png(1, 1, &[1, 2, 3, 255])).unwrap();
    let path = painted(folder.path(), "maps/%C3%A9%201.png");
    let model = Model::load(&path, LoadOptions::default()).unwrap();
    assert_eq!(model.name, "painted");
    let texture = model.materials[0].base_color.texture.as_ref().unwrap();
    assert_eq!(texture.raster.value(0, 0, 2), 3.0 / 255.0);
    assert!(model.remarks[0].contains("has 0 sets of texture coordinates"), "{:?}", model.remarks);
}

#[test]
fn reads_on_other_threads_are_recorded() {
    let _unmeasured = unmeasured();
    let folder = tempfile::tempdir().unwrap();
    let path = painted(folder.path(), "a.png");
    let mut json: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    json["images"].as_array_mut().unwrap().push(json!({ "uri": "b.png" }));
    json["textures"].as_array_mut().unwrap().push(json!({ "source": 1 }));
    json["materials"][0]["emissiveTexture"] = json!({ "index": 1 });
    fs::write(&path, json.to_string()).unwrap();
    fs::write(folder.path().join("a.png"), png(1, 1, &[1, 2, 3, 255])).unwrap();
    let read = |blue| -> Vec<FileRead> {
        fs::write(folder.path().join("b.png"), png(1, 1, &[1, 2, blue, 255])).unwrap();
        let (model, mut read) = recorded(|| Model::load(&path, LoadOptions::default()));
        model.unwrap();
        // Other tests read their own files at the same time.
        read.retain(|file| file.path.starts_with(folder.path()));
        read
    };
    let (before, after) = (read(3), read(4));
    let names = |read: &[FileRead]| -> Vec<_> {
        read.iter().map(|file| file.path.file_name().unwrap().to_str().unwrap().to_owned()).collect()
    };
    assert_eq!(names(&before), ["a.png", "b.png", "it.bin", "painted.gltf"]);
    assert_eq!(names(&after), names(&before));
    let changed: Vec<bool> = before.iter().zip(&after).map(|(a, b)| a.checksum != b.checksum).collect();
    assert_eq!(changed, [false, true, false, false]);
}

#[test]
fn remote_files_are_not_read() {
    let _unmeasured = unmeasured();
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("inside");
    fs::create_dir(&inside).unwrap();
    let secret = folder.path().join("secret.png");
    fs::write(&secret, png(1, 1, &[1, 2, 3, 255])).unwrap();
    let absolute = secret.to_str().unwrap();
    let file = format!("file://{absolute}");
    let refused = [
        ("../secret.png", "outside the model's folder"),
        ("%2e%2e/secret.png", "outside the model's folder"),
        ("x/../../secret.png", "outside the model's folder"),
        (absolute, "outside the model's folder"),
        (&file, "has a scheme"),
        ("https://example.com/a.png", "has a scheme"),
        ("..\\secret.png", "outside the model's folder"),
        ("", "has no name"),
        ("nothing.png", "cannot be found"),
        (".", "is not a regular file"),
    ];
    for (uri, wanted) in refused {
        let path = painted(&inside, uri);
        let error = Model::load(&path, STRICT).unwrap_err();
        let message = error.to_string();
        println!("{message}");
        assert!(matches!(error.fault, ModelFault::Missing { .. }), "{message}");
        assert!(message.contains("painted.gltf: image 0: the file") && message.contains(wanted), "{message}");
        let model = Model::load(&path, LoadOptions::default()).unwrap();
        assert!(
            model.remarks.iter().any(|r| r.contains("image 0") && r.contains("replacement")),
            "{:?}",
            model.remarks
        );
    }
    // The same file is accepted inside the folder.
    fs::copy(&secret, inside.join("secret.png")).unwrap();
    Model::load(painted(&inside, "secret.png"), LoadOptions::default()).unwrap();
}

/// A link to a file outside the folder is refused, alone or as a folder on the way, unless links are followed.
#[cfg(unix)]
#[test]
fn links_out_of_the_folder_are_refused() {
    use std::os::unix::fs::symlink;
    let _unmeasured = unmeasured();
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("inside");
    fs::create_dir(&inside).unwrap();
    fs::write(folder.path().join("secret.png"), png(1, 1, &[1, 2, 3, 255])).unwrap();
    fs::write(inside.join("real.png"), png(1, 1, &[1, 2, 3, 255])).unwrap();
    symlink("../secret.png", inside.join("out.png")).unwrap();
    symlink("..", inside.join("up")).unwrap();
    symlink("real.png", inside.join("alias.png")).unwrap();
    Model::load(painted(&inside, "alias.png"), LoadOptions::default()).unwrap();
    for (uri, link) in [("out.png", "out.png"), ("up/secret.png", "up")] {
        let path = painted(&inside, uri);
        let message = Model::load(&path, STRICT).unwrap_err().to_string();
        let wanted =
            format!("image 0: the file {uri:?}: the link {link:?} leads out of its folder; add --follow-links");
        assert!(message.contains(&wanted), "{message}");
        Model::load(&path, LoadOptions { links: OutsideLinks::Followed, ..LoadOptions::default() }).unwrap();
    }
    // The same check applies to buffers, which are never replaced.
    let data = inside.join("data of");
    fs::rename(&data, folder.path().join("data")).unwrap();
    symlink("../data", &data).unwrap();
    let message = Model::load(inside.join("painted.gltf"), LoadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("buffer 0: the file") && message.contains("the link \"data of\" leads out"), "{message}");
}

#[test]
fn replacements_are_seen_and_do_no_harm() {
    let _unmeasured = unmeasured();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("broken.png"), &png(4, 4, &[9; 64])[..40]).unwrap();
    let path = painted(folder.path(), "broken.png");
    let message = Model::load(&path, STRICT).unwrap_err().to_string();
    assert!(message.contains("image 0 (broken.png): is damaged"), "{message}");
    let model = Model::load(&path, LoadOptions::default()).unwrap();
    assert_eq!(model.remarks.iter().filter(|r| r.contains("image 0 (broken.png): is damaged")).count(), 1);
    let material = &model.materials[0];
    let colors = material.base_color.texture.as_ref().unwrap();
    let (one, other) = (colors.raster.color(0, 0, colors.encoding), colors.raster.color(1, 0, colors.encoding));
    assert!(one[0] > 0.3 && one[1] == 0.0 && other[0] < 0.1, "a magenta check: {one:?} {other:?}");
    let roughness = material.roughness.texture.as_ref().unwrap();
    assert_eq!(roughness.raster.value(0, 0, 1), 1.0, "the factor alone");
    assert!(material.normal_map.is_none());
    // Geometry is not replaced.
    fs::remove_file(folder.path().join("data of/it.bin")).unwrap();
    let message = Model::load(&path, LoadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("buffer 0: the file \"data%20of/it.bin\" cannot be found"), "{message}");
}

/// If many buffers share one large file, each reads only its declared length.
#[test]
fn buffers_take_no_more_than_their_length() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("large.bin"), vec![0; 8 << 20]).unwrap();
    let mut made = triangle();
    made.json["buffers"] = json!([{ "byteLength": made.binary.len() }]);
    for _ in 0..100 {
        made.push("buffers", json!({ "byteLength": 16, "uri": "large.bin" }));
    }
    let file = made.glb();
    let load = || Model::decode(&file, "made", Some(folder.path()), LoadOptions::default()).map(drop);
    let (result, peak, _) = measured(load);
    result.unwrap();
    assert!(peak < 1 << 20, "{peak} bytes");
}

#[test]
fn images_of_other_formats_are_named() {
    let _unmeasured = unmeasured();
    let mut made = everything();
    made.json["textures"][0] = json!({ "extensions": { "XYZ_texture_jxl": { "source": 0 } } });
    let model = made.model();
    assert!(
        model.remarks[0].contains("texture 0 has no image in a supported format (PNG or JPEG)"),
        "{:?}",
        model.remarks
    );
    made.json["textures"][0] = json!({});
    let model = made.model();
    assert!(model.remarks[0].contains("texture 0 has no image; it is ignored"), "{:?}", model.remarks);
    assert!(model.materials[0].base_color.texture.is_none());
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.psd"), b"8BPS\0\x01").unwrap();
    let message = Model::load(painted(folder.path(), "a.psd"), STRICT).unwrap_err().to_string();
    assert!(message.contains("image 0 (a.psd): cannot be used: it is a Photoshop document, and a PNG"), "{message}");
}

#[test]
fn extras_name_a_displacement_map() {
    let _unmeasured = unmeasured();
    let folder = tempfile::tempdir().unwrap();
    let heights = HeightMap::new(2, 1, vec![0.25, 0.75]).unwrap();
    fs::write(folder.path().join("bark.png"), encode_png_grey16(&heights, 0.0, 1.0).unwrap()).unwrap();
    let load = |extras: Value, options| {
        let mut made = triangle();
        made.push("materials", json!({ "name": "bark", "extras": extras }));
        made.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        Model::decode(&made.glb(), "made", Some(folder.path()), options)
    };
    let model =
        load(json!({ "leadr_displacement": { "uri": "bark.png", "scale": 0.02, "middle": 0.25 } }), STRICT).unwrap();
    let relief = model.materials[0].relief.as_ref().unwrap();
    assert_eq!((relief.scale, relief.middle, relief.map.width), (Some(0.02), 0.25, 2));
    assert!((relief.map.at(1, 0) - 0.75).abs() < 1e-4);
    let model = load(json!({ "leadr_displacement": { "uri": "bark.png" } }), STRICT).unwrap();
    let relief = model.materials[0].relief.as_ref().unwrap();
    assert_eq!((relief.scale, relief.middle), (None, 0.5));
    for foreign in [json!(7), json!("text"), json!({ "other": [1] }), json!([])] {
        assert!(load(foreign, STRICT).unwrap().materials[0].relief.is_none());
    }
    let missing = json!({ "leadr_displacement": { "uri": "moss.png" } });
    let message = load(missing.clone(), STRICT).unwrap_err().to_string();
    assert!(
        message.contains("material 0, extras, leadr_displacement: the file \"moss.png\" cannot be found"),
        "{message}"
    );
    let model = load(missing, LoadOptions::default()).unwrap();
    assert!(
        model.materials[0].relief.is_none() && model.remarks[0].contains("is not displaced"),
        "{:?}",
        model.remarks
    );
    for (wrong, wanted) in [
        (json!({ "leadr_displacement": 7 }), "`leadr_displacement` must be an object"),
        (json!({ "leadr_displacement": {} }), "`uri` is missing"),
        (
            json!({ "leadr_displacement": { "uri": "bark.png", "scale": -1 } }),
            "`scale` must be a number from 0.0 to 1e12",
        ),
    ] {
        let message = load(wrong, STRICT).unwrap_err().to_string();
        assert!(message.contains(wanted), "{message}");
    }
}

#[test]
fn non_models_are_refused() {
    let _unmeasured = unmeasured();
    let folder = tempfile::tempdir().unwrap();
    let message = |path: &Path| Model::load(path, LoadOptions::default()).unwrap_err().to_string();
    let missing = message(&folder.path().join("no.glb"));
    assert!(missing.contains("no.glb: cannot be found") && missing.contains("check the path"), "{missing}");
    assert!(message(folder.path()).contains("is not a regular file; give the path of a .glb or .gltf file"));
    for (content, wanted) in [
        (&b""[..], "is damaged: it is empty"),
        (b"   \n", "is damaged: it is empty"),
        (b"solid cube", "is not a glTF model; give a .glb or .gltf file"),
        (b"\x89PNG", "is not a glTF model"),
        (b"\xef\xbb\xbf{", "its JSON cannot be read"),
        (b"{", "its JSON cannot be read (EOF while parsing an object at line 1 column 1)"),
        (b"glTF", "its header ends early"),
        (b"glTF\x01\0\0\0\x0c\0\0\0", "it is a GLB of version 1"),
        (b"glTF\x02\0\0\0\x0c\0\0\0", "it has no JSON"),
    ] {
        let path = folder.path().join("odd.glb");
        fs::write(&path, content).unwrap();
        assert!(message(&path).contains(wanted), "{}", message(&path));
    }
}

/// A pipe is refused, because opening it would wait for a writer.
#[cfg(unix)]
#[test]
fn pipes_are_refused_at_once() {
    let _unmeasured = unmeasured();
    let folder = tempfile::tempdir().unwrap();
    for name in ["pipe.glb", "pipe.png"] {
        let made = std::process::Command::new("mkfifo").arg(folder.path().join(name)).status();
        assert!(made.is_ok_and(|status| status.success()), "mkfifo is needed");
    }
    let error = Model::load(folder.path().join("pipe.glb"), LoadOptions::default()).unwrap_err();
    assert!(matches!(error.fault, ModelFault::NotAFile));
    let message = Model::load(painted(folder.path(), "pipe.png"), STRICT).unwrap_err().to_string();
    assert!(message.contains("\"pipe.png\" is not a regular file"), "{message}");
}

/// Blemishes of the container and of its declaration do not change what the file says.
#[test]
fn containers_are_read_despite_blemishes() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    made.binary.extend([0; 2]);
    let json = made.finished().to_string();
    let whole = made.glb();
    let length = |change: i32| {
        let mut file = whole.clone();
        let declared = i32::from_le_bytes(file[8..12].try_into().unwrap()) + change;
        file[8..12].copy_from_slice(&declared.to_le_bytes());
        file
    };
    // The chunks as some exporters write them: the text ends in zeros, and no chunk is padded.
    let unpadded = |json: &[u8], gap: usize| {
        let mut file = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        for (kind, body) in [(b"JSON", json), (b"BIN\0", &made.binary[..])] {
            file.extend((body.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(body);
            file.resize(file.len() + gap.min(file.len().next_multiple_of(4) - file.len()), 0);
        }
        let length = file.len() as u32;
        file[8..12].copy_from_slice(&length.to_le_bytes());
        file
    };
    let padded = json.len().next_multiple_of(4) + 1;
    let uneven = format!("{json:padded$}");
    let zeros = [json.as_bytes(), &[0; 3]].concat();
    let marked = [b"\xef\xbb\xbf", json.as_bytes()].concat();
    let files = [
        ("as it is", whole.clone(), 0, true),
        ("trailing bytes", [&whole[..], b"trailing bytes"].concat(), 0, true),
        ("declared too long", length(100), 1, false),
        ("without padding", unpadded(uneven.as_bytes(), 0), 0, true),
        ("padded after its length", unpadded(uneven.as_bytes(), 3), 0, true),
        ("zeros after the JSON", glb(&zeros, &made.binary), 1, false),
        ("byte order mark", glb(&marked, &made.binary), 1, false),
        ("no padding of the buffer", whole[..whole.len() - 2].to_vec(), 2, false),
    ];
    for (name, file, remarks, is_strict) in files {
        let model = decode(&file).unwrap_or_else(|fault| panic!("{name}: {fault}"));
        assert_eq!(model.meshes[0].primitives[0].triangles.len(), 1, "{name}");
        assert_eq!(model.remarks.len(), remarks, "{name}: {:?}", model.remarks);
        assert_eq!(decode_strictly(&file).is_ok(), is_strict, "{name}");
    }
    for asset in [json!({ "version": 2 }), json!({ "version": 2.0 }), json!({ "version": "2" }), json!({}), json!(null)]
    {
        let mut odd = made.clone();
        odd.json["asset"] = asset;
        assert!(odd.repaired().1.contains("it is read as glTF 2.0"));
    }
    for old in
        [json!({ "asset": { "version": "1.0" } }), json!({ "asset": { "version": 1.0 } }), json!({ "meshes": {} })]
    {
        let fault = decode(old.to_string().as_bytes()).unwrap_err().to_string();
        assert!(fault.contains("it is glTF 1.0; export it as glTF 2.0"), "{fault}");
    }
    // The declared length of a buffer and of a view may lack their padding, and a file may be longer.
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("it.bin"), [&made.binary[..36], &[7; 5]].concat()).unwrap();
    for (buffer, view, remarks) in [(36, 36, 0), (34, 36, 1), (36, 34, 1), (60, 36, 1)] {
        let mut odd = made.clone();
        odd.json["buffers"] = json!([{ "byteLength": buffer, "uri": "it.bin" }]);
        odd.json["bufferViews"][0]["byteLength"] = json!(view);
        let text = odd.finished().to_string();
        let model = Model::decode(text.as_bytes(), "made", Some(folder.path()), LoadOptions::default()).unwrap();
        assert_eq!(
            (model.meshes[0].primitives[0].triangles.len(), model.remarks.len()),
            (1, remarks),
            "{buffer} {view}"
        );
        assert_eq!(model.meshes[0].primitives[0].positions[2], [0.0, 1.0, 0.0]);
    }
}

/// Parts that nothing uses may be broken, and a broken part takes only those that use it with it.
#[test]
fn broken_parts_take_only_their_users_with_them() {
    let _unmeasured = unmeasured();
    let mut made = triangle();
    made.push("images", json!({ "uri": "missing.png" }));
    made.push("textures", json!({ "source": 0 }));
    made.push("materials", json!({ "emissiveTexture": { "index": 0 } }));
    made.push("accessors", json!({ "bufferView": 99, "componentType": F32, "type": "VEC3", "count": 3 }));
    made.push("buffers", json!({ "byteLength": made.binary.len() }));
    made.push("buffers", json!({ "byteLength": 12, "uri": "missing.bin" }));
    made.push("bufferViews", json!({ "buffer": 1, "byteLength": 12 }));
    assert!(made.model().remarks.is_empty(), "{:?}", made.model().remarks);
    assert!(decode_strictly(&made.glb()).is_err());
    let lost = made.push("accessors", json!({ "bufferView": 1, "componentType": F32, "type": "VEC3", "count": 1 }));
    let broken = json!({ "primitives": [{ "attributes": { "POSITION": lost } }, { "attributes": { "POSITION": 1 } }] });
    made.push("meshes", broken);
    let sampler = json!({ "input": 1, "output": 0 });
    let channel = json!({ "sampler": 0, "target": { "node": 0, "path": "translation" } });
    made.push("animations", json!({ "samplers": [sampler], "channels": [channel] }));
    made.push("animations", json!({ "samplers": [], "channels": [] }));
    let model = made.model();
    assert_eq!((model.meshes[0].primitives.len(), model.meshes[1].primitives.len()), (1, 0));
    assert!(model.animations.is_empty());
    let all = model.remarks.join("\n");
    for wanted in
        ["\"missing.bin\"", "refers to buffer view 99", "the channel is left out", "animation 1: has no channels"]
    {
        assert!(all.contains(wanted), "{wanted}: {all}");
    }
    // Primitives may have different numbers of morph targets.
    let mut made = triangle();
    let target = json!({ "POSITION": 0 });
    let primitives = made.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(json!({ "attributes": { "POSITION": 0 }, "targets": [target, target] }));
    made.json["meshes"][0]["weights"] = json!([0.0, 1.0]);
    let (model, remark) = made.repaired();
    assert!(remark.contains("different numbers of morph targets"), "{remark}");
    let pose = model.pose(None, 0.0);
    let corner = [0, 1].map(|primitive| model.posed_vertices(&pose, 0, primitive).positions[1]);
    assert_eq!(corner, [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
}
