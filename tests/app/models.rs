//! Models on the command line: refused files and messages.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

fn capture(scene: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_leadr"));
    command.args(["capture", "--size", "8x8", "--samples", "1", "--scene"]).arg(scene).args(more);
    command.env_remove("LEADR_LOG").output().expect("the program starts")
}

/// Checks for an exit code with one line of error, which it returns.
fn refusal(output: &Output, code: i32, what: &str) -> String {
    let stderr = String::from_utf8(output.stderr.clone()).expect("UTF-8");
    assert_eq!(output.status.code(), Some(code), "{what}: {stderr}");
    let errors: Vec<&str> = stderr.lines().filter(|line| line.starts_with("leadr: error: ")).collect();
    assert!(errors.len() == 1 && !stderr.contains("panicked"), "{what}: {stderr}");
    errors[0].to_owned()
}

/// A triangle, with these changes.
fn triangle(changes: &[(&str, Value)]) -> Value {
    let positions = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let mut model = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"uri": format!("data:application/octet-stream;base64,{positions}"), "byteLength": 36}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    });
    changes.iter().for_each(|(key, value)| model[*key] = value.clone());
    model
}

/// Each is refused in one line with the file and the fault, for any claimed size.
#[test]
fn hostile_models_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let accessor = |count: u64| json!([{"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"}]);
    let points = json!([{"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}]}]);
    let joints = json!([{"joints": vec![0; 1_000_000]}]);
    type Case = (&'static str, Vec<(&'static str, Value)>, &'static str);
    let cases: [Case; 5] = [
        ("circle", vec![("nodes", json!([{"mesh": 0, "children": [1]}, {"children": [0]}]))], "ancestor"),
        ("claims", vec![("accessors", accessor(1 << 31))], "2147483648"),
        ("joints", vec![("skins", joints)], "joints"),
        ("points", vec![("meshes", points)], "points and lines are not drawn"),
        ("empty", vec![("scenes", json!([{"nodes": []}]))], "no triangles"),
    ];
    for (name, changes, fault) in cases {
        let file = folder.path().join(format!("{name}.gltf"));
        fs::write(&file, triangle(&changes).to_string()).unwrap();
        let error = refusal(&capture(&file, &[]), 1, name);
        assert!(error.contains(&*file.to_string_lossy()) && error.contains(fault), "{name}: {error}");
    }
}

/// What violates glTF is repaired with one warning, or refused with `--strict`.
#[test]
fn blemishes_are_warnings_or_errors() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("blemished.gltf");
    let camera = json!([{"type": "perspective", "perspective": {"yfov": 0, "znear": 0.1}}]);
    fs::write(&file, triangle(&[("cameras", camera)]).to_string()).unwrap();
    let picture = folder.path().join("picture.png");
    let drawn = capture(&file, &["-o", picture.to_str().unwrap()]);
    let said = String::from_utf8(drawn.stderr).unwrap();
    assert!(drawn.status.success() && picture.is_file(), "{said}");
    let warnings: Vec<&str> = said.lines().filter(|line| line.contains("WARN")).collect();
    assert!(warnings.len() == 1 && warnings[0].contains("camera 0, perspective: `yfov` must be"), "{said}");
    let error = refusal(&capture(&file, &["--strict"]), 1, "--strict");
    assert!(error.contains("camera 0, perspective: `yfov` must be"), "{error}");
    let error = refusal(&capture(&file, &["--variant", "Night"]), 1, "--variant");
    assert!(error.contains("it has no variant named Night; available: none"), "{error}");
}

/// A flag with an unknown name lists the existing ones, and flags for models are refused elsewhere.
#[test]
fn flags_of_models_are_for_models() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("triangle.gltf");
    fs::write(&file, triangle(&[]).to_string()).unwrap();
    let no_camera = refusal(&capture(&file, &["--camera", "model"]), 1, "--camera model");
    assert!(no_camera.contains("it has no camera") && no_camera.contains("triangle.gltf"), "{no_camera}");
    let no_name = refusal(&capture(&file, &["--camera", "model:moon"]), 1, "--camera model:moon");
    assert!(no_name.contains("no camera is named moon; available: none"), "{no_name}");
    let plane = Path::new("plane");
    for flags in [&["--camera", "model"][..], &["--strict"], &["--variant", "Day"], &["--animation", "Walk"]] {
        let error = refusal(&capture(plane, flags), 2, flags[0]);
        assert!(error.contains("is for models: --scene FILE.glb"), "{error}");
    }
}

/// A file of 365 kB draws a mesh 20,000 times. It is refused with its counts, before its nodes are expanded.
#[test]
fn crowds_of_copies_are_refused_before_they_are_expanded() {
    let Some(folder) = leadr_testing::shared::shared_data("bad-input/models-large") else { return };
    let start = Instant::now();
    let error = refusal(&capture(&folder.join("inst_t.glb"), &[]), 1, "inst_t.glb");
    let counts = "draw 20000 meshes of 60000000 triangles and 180000000 vertices in total";
    assert!(error.contains(counts) && error.contains("; remove copies"), "{error}");
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
}

/// A link out of the model's folder is refused, and the error names the link and the flag that follows it.
#[cfg(unix)]
#[test]
fn links_out_of_a_folder_need_a_flag() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("inside");
    fs::create_dir(&inside).unwrap();
    let positions: Vec<u8> =
        [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    fs::write(folder.path().join("it.bin"), positions).unwrap();
    std::os::unix::fs::symlink("../it.bin", inside.join("it.bin")).unwrap();
    let file = inside.join("triangle.gltf");
    fs::write(&file, triangle(&[("buffers", json!([{"uri": "it.bin", "byteLength": 36}]))]).to_string()).unwrap();
    let error = refusal(&capture(&file, &[]), 1, "a link");
    assert!(
        error.contains("the link \"it.bin\" leads out of its folder; add --follow-links if you trust it"),
        "{error}"
    );
    let picture = folder.path().join("a.png");
    let output = capture(&file, &["--follow-links", "-o", &picture.to_string_lossy()]);
    assert!(output.status.success() && picture.is_file(), "{}", String::from_utf8_lossy(&output.stderr));
    let error = refusal(&capture(Path::new("plane"), &["--follow-links"]), 2, "no folder");
    assert!(error.contains("--follow-links is for a folder: add --material or --detail"), "{error}");
    let error = refusal(&capture(Path::new("ocean"), &["--follow-links"]), 2, "no folder");
    assert!(error.contains("--follow-links is for the scenes plane, sphere and for models"), "{error}");
}
