//! `leadr compare` of pictures as other programs write them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use crate::cli::{leadr, one_line_error, path};
use leadr::maps::save::encode_exr;
use leadr_testing::shared::shared_data;

fn compare(a: &Path, b: &Path, flags: &[&str]) -> Output {
    leadr(&[&["compare", path(a), path(b)], flags].concat()).output().unwrap()
}

/// Returns whether two pictures pass for equal, and what is printed to stderr.
fn passes(a: &Path, b: &Path, flags: &[&str]) -> (bool, String) {
    let output = compare(a, b, &[&["--max-flip", "0.001", "--max-rrmse", "0.002"], flags].concat());
    (output.status.code() == Some(0), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn pictures_that_look_different_never_pass() {
    let Some(reports) = shared_data("reports") else { return };
    let file = |name: &str| reports.join(name);
    for (a, b, equal) in [
        ("cmp_layers_a.exr", "cmp_layers_b.exr", false),
        ("cmp_a.png", "cmp_alpha_differs.png", false),
        ("cmp_rec709.exr", "env_acescg_chromaticities.exr", true),
        ("cmp_grey_alpha.exr", "cmp_grey_alpha.exr", true),
        ("env_plain.exr", "env_lowercase.exr", true),
        ("env_plain.exr", "env_data_window_top_half.exr", false),
    ] {
        let (passed, stderr) = passes(&file(a), &file(b), &[]);
        assert_eq!(passed, equal, "{a} against {b}: {stderr}");
    }
    let (_, stderr) = passes(&file("cmp_layers_a.exr"), &file("cmp_layers_b.exr"), &[]);
    assert!(stderr.contains("2 layers with colour") && stderr.contains("`View.Combined` is read"), "{stderr}");
    let (_, stderr) = passes(&file("cmp_a.png"), &file("cmp_alpha_differs.png"), &[]);
    assert!(stderr.contains("over black and over white"), "{stderr}");
    assert!(passes(&file("cmp_layers_a.exr"), &file("cmp_layers_b.exr"), &["--layer", "AO"]).0);
    let output = compare(&file("cmp_layers_a.exr"), &file("env_plain.exr"), &["--layer", "AO"]);
    assert!(
        one_line_error(&output, 1, "a missing layer").contains("env_plain.exr: cannot be used: it has no layer `AO`")
    );
    for (a, b) in [("cmp_nan.exr", "cmp_grey.exr"), ("cmp_grey.exr", "cmp_nan.exr")] {
        let line = one_line_error(&compare(&file(a), &file(b), &[]), 1, "NaN");
        assert!(line.contains("cmp_nan.exr: holds NaN") && !line.contains("cmp_grey"), "{line}");
    }
    let output = compare(&file("cmp_a.png"), &file("cmp_a.png"), &["--layer", "AO"]);
    assert!(one_line_error(&output, 1, "a PNG").contains("only EXR files have layers"));
}

#[test]
fn layers_that_are_named_differently_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let save = |name: &str, layer: &str| -> PathBuf {
        let file = folder.path().join(name);
        let names = ["R", "G", "B"].map(|channel| format!("{layer}{channel}"));
        let plane = [0.5f32; 64];
        let channels: Vec<(&str, &[f32])> = names.iter().map(|name| (name.as_str(), &plane[..])).collect();
        fs::write(&file, encode_exr(8, 8, &channels).unwrap()).unwrap();
        file
    };
    let (plain, combined) = (save("a.exr", ""), save("b.exr", "View.Combined."));
    let (passed, stderr) = passes(&plain, &combined, &[]);
    assert!(
        passed && stderr.contains("the unnamed layer of the reference") && stderr.contains("`View.Combined`"),
        "{stderr}"
    );
    let json = compare(&combined, &combined, &["--layer", "combined", "--json"]).stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!((&json["layer"], &json["transparent"]), (&"combined".into(), &false.into()));
    let renamed = folder.path().join("c.png");
    fs::copy(&plain, &renamed).unwrap();
    assert!(one_line_error(&compare(&renamed, &renamed, &[]), 1, "an EXR").contains("another format than its name"));
}

#[test]
fn pointers_of_git_lfs_are_named_for_every_input() {
    let folder = tempfile::tempdir().unwrap();
    let pointer = |name: &str| {
        let file = folder.path().join(name);
        fs::write(&file, "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a2146\nsize 12345\n").unwrap();
        path(&file).to_owned()
    };
    let [png, exr, hdr, glb, gltf, ktx2, json, merl] =
        ["a.png", "a.exr", "a.hdr", "a.glb", "a.gltf", "a.ktx2", "a.json", "a.binary"].map(pointer);
    let material = folder.path().join("material");
    fs::create_dir(&material).unwrap();
    fs::copy(&png, material.join("x_Displacement.png")).unwrap();
    let model = folder.path().join("model.gltf");
    let text = r#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "b.bin", "byteLength": 36}], "nodes": [{"mesh": 0}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "scenes": [{"nodes": [0]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]}"#;
    fs::write(&model, text).unwrap();
    pointer("b.bin");
    for arguments in [
        &["compare", &png, &png][..],
        &["compare", &exr, &exr],
        &["capture", "--environment", &hdr],
        &["capture", "--scene", &glb],
        &["capture", "--scene", &gltf],
        &["capture", "--scene", path(&model)],
        &["capture", "--camera", &json],
        &["capture", "--scene", "plane", "--height-map", &ktx2],
        &["capture", "--scene", "plane", "--material", &json],
        &["capture", "--scene", "plane", "--material", path(&material)],
        &["bake", &png, "-o", path(&folder.path().join("out.ktx2"))],
        &["fit", &merl],
    ] {
        let line = one_line_error(&leadr(arguments).output().unwrap(), 1, arguments[0]);
        assert!(line.contains("a pointer of Git LFS") && line.contains("git lfs pull"), "{arguments:?}: {line}");
    }
}
