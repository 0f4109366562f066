//! Tests of small files that declare large amounts of data. The files are refused, or read with little memory and time.

use std::time::Duration;

use serde_json::json;

use crate::build::{F32, U32, decode, decode_strictly, png, triangle};
use leadr_models::limits::{MAX_JOINTS, MAX_OBJECTS};
use leadr_testing::memory::{alone, measured, unmeasured};

/// A small file with excessive claims costs little memory and time.
#[test]
fn oversized_claims_are_cheap() {
    let _alone = alone();
    let mut cases: Vec<(&str, Vec<u8>, &str)> = Vec::new();
    let zeros = |count: u64| json!({ "type": "VEC3", "componentType": F32, "count": count });
    for (name, count) in [("2^31 vertices of zeros", 1u64 << 31), ("2^64 vertices of zeros", u64::MAX)] {
        let mut made = triangle();
        let accessor = made.push("accessors", zeros(count));
        made.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(accessor);
        cases.push((name, made.glb(), "is too large: its parts unpack to more than"));
    }
    let mut made = triangle();
    let accessor = made.push("accessors", zeros(1 << 20));
    let primitives = vec![json!({ "attributes": { "POSITION": accessor } }); 1000];
    made.push("meshes", json!({ "primitives": primitives }));
    cases.push(("a thousand primitives of a million vertices", made.glb(), "is too large: its parts unpack"));

    // Many parts share large data.
    let mut made = triangle();
    let target = json!({ "POSITION": 0 });
    made.json["meshes"][0]["primitives"][0]["targets"] = json!(vec![target; 4096]);
    made.json["nodes"] = json!(vec![json!({ "mesh": 0 }); 100_000]);
    cases.push(("a hundred thousand nodes of 4096 weights", made.glb(), "is too large: its parts unpack"));
    let mut made = triangle();
    let indices: Vec<u8> = (0..100_000u32).flat_map(u32::to_le_bytes).collect();
    let (indices, values) = (made.view(&indices), made.view(&[0; 400_000]));
    let sparse = json!({ "count": 100_000, "indices": { "bufferView": indices, "componentType": U32 }, "values": { "bufferView": values } });
    let accessor = json!({ "type": "SCALAR", "componentType": F32, "count": 100_000, "sparse": sparse });
    made.json["accessors"].as_array_mut().unwrap().extend(vec![accessor; 10_000]);
    cases.push(("ten thousand accessors with the same changes", made.glb(), "is too large: its parts unpack"));
    let mut made = triangle();
    let count = 1_000_000;
    made.push("skins", json!({ "joints": vec![0; count] }));
    cases.push(("a million joints", made.glb(), "skin 0 has 1000000 joints; the limit is 65536"));
    assert_eq!(MAX_JOINTS, 65536);
    let mut made = triangle();
    made.json["nodes"] = json!(vec![json!({}); MAX_OBJECTS + 1]);
    cases.push(("too many nodes", made.glb(), "its JSON has more than 1048576 objects"));
    let deep = [vec![b'['; 1 << 20], vec![b']'; 1 << 20]].concat();
    let text = [br#"{"asset":{"version":"2.0"},"extras":"#.to_vec(), deep, b"}".to_vec()].concat();
    cases.push(("a million brackets", text, "its JSON cannot be read"));
    // The text is the largest allowed JSON. Small objects need the most memory relative to their text.
    let objects = vec![r#"{"":0}"#; MAX_OBJECTS - 3].join(",");
    let text = format!(r#"{{"asset":{{"version":"2.0"}},"extras":[{objects}],"scene":{{}}}}"#);
    cases.push(("a million objects", text.into_bytes(), "`scene` must be a whole number"));
    let commas =
        [br#"{"asset":{"version":"2.0"},"extras":[0"#.to_vec(), b",0".repeat(1 << 25), b"]}".to_vec()].concat();
    cases.push(("33 million values", commas, "its JSON has more than 8388608 values"));

    // Each of 1000 images uses the same 16384 x 16384 picture, from a file of a few hundred bytes.
    let mut made = triangle();
    let view = made.view(&claiming(png(1, 1, &[0; 4]), 16384));
    for number in 0..1000 {
        made.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        made.push("textures", json!({ "source": number }));
    }
    cases.push((
        "a claim of a picture",
        made.glb(),
        "image 0: is too large: the header claims 1 GiB when decoded, and the file has only",
    ));

    for (name, file, wanted) in cases {
        let (_, peak, time) = measured(|| decode(&file));
        assert!(peak < 600 << 20 && time < Duration::from_secs(5), "{name}: {peak} bytes, {time:?}");
        let (result, peak, time) = measured(|| decode_strictly(&file));
        let message = result.map(drop).expect_err(name).to_string();
        println!("{name}: {message} ({} bytes of file, {peak} of memory, {time:?})", file.len());
        assert!(message.contains(wanted), "{name}: {message}");
        // Parsed objects need about forty times the bytes of their text. Everything else must fit into the free allowance.
        assert!(peak < ((160 << 20) + 50 * file.len()).min(600 << 20), "{name}: {peak} bytes");
        assert!(time < Duration::from_secs(5), "{name}: {time:?}");
    }
}

/// Forty images of 8192 x 8192 are refused from their headers, with any number of threads.
#[test]
fn images_are_counted_before_they_are_decoded() {
    let _alone = alone();
    let Some(folder) = leadr_testing::shared::shared_data("bad-input/models-large") else { return };
    let file = std::fs::read(folder.join("img8k_x40.glb")).unwrap();
    for threads in [1, 16] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let (result, peak, _) = pool.install(|| measured(|| decode_strictly(&file)));
        let message = result.map(drop).unwrap_err().to_string();
        assert!(message.contains("with the images before it, it needs more than 4 GiB"), "{message}");
        assert!(peak < 8 << 20, "{threads} threads: {peak} bytes");
    }
}

/// The same PNG with another size in its header and a matching checksum.
fn claiming(mut png: Vec<u8>, side: u32) -> Vec<u8> {
    png[16..20].copy_from_slice(&side.to_be_bytes());
    png[20..24].copy_from_slice(&side.to_be_bytes());
    let mut sum = u32::MAX;
    for &byte in &png[12..29] {
        sum ^= u32::from(byte);
        (0..8).for_each(|_| sum = if sum & 1 == 1 { sum >> 1 ^ 0xedb8_8320 } else { sum >> 1 });
    }
    png[29..33].copy_from_slice(&(!sum).to_be_bytes());
    png
}

/// The deepest allowed chain of nodes must be posed without recursion.
#[test]
fn deep_hierarchies_are_posed() {
    let _unmeasured = unmeasured();
    let count = 200_000;
    let node =
        |i: usize| json!({ "translation": [0.0, 0.0, 1.0], "children": (i + 1..count).take(1).collect::<Vec<_>>() });
    let mut made = triangle();
    made.json["nodes"] = (0..count).map(node).collect();
    let model = made.model();
    let pose = model.pose(None, 0.0);
    assert_eq!(pose.world_from_node[count - 1].w_axis.z, count as f32);
    assert_eq!(model.shown_nodes().len(), count);
}
