//! Text of foreign origin (names of files, strings inside files, variables, values of flags) cannot command a terminal or forge lines.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::cli::{leadr, one_line_error, path};
use leadr_testing::shared::shared_data;

/// A window title, a CSI of one character, a reversed direction, a forged line, and a letter without width.
const HOSTILE: &str = "\u{1b}]0;PWN\u{7}\u{9b}2J\u{202e}gpj\nleadr: error: forged\u{200b}\r\u{2066}end";

/// Checks that every character of a text is visible, apart from line breaks.
fn assert_visible(text: &[u8], what: &str) {
    let text = std::str::from_utf8(text).expect("UTF-8");
    for (at, c) in text.char_indices().filter(|(_, c)| *c != '\n') {
        let pair: String = ['a', c].iter().collect();
        let visible = c.is_ascii_graphic() || c == ' ' || pair.escape_debug().nth(1) == Some(c);
        assert!(visible, "{what}: {c:?} at {at} of {text:?}");
    }
}

fn assert_shown(output: &Output, what: &str) {
    assert_visible(&output.stdout, what);
    assert_visible(&output.stderr, what);
    let forged = String::from_utf8_lossy(&output.stderr).lines().any(|line| line.starts_with("leadr: error: forged"));
    assert!(!forged, "{what}: {}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn escapes_inside_measured_files_are_shown() {
    let Some(data) = shared_data("bad-input/escapes") else { return };
    let folder = tempfile::tempdir().unwrap();
    for name in ["esc.bsdf", "escfield.bsdf"] {
        let (file, page) = (data.join(name), folder.path().join(name).with_extension("html"));
        let fit = |flags: &[&str]| {
            let quick = ["fit", path(&file), "--angles", "8", "--lobes", "1", "--backscattering-only"];
            leadr(&[&quick[..], flags].concat()).output().unwrap()
        };
        let text = fit(&["--page", path(&page)]);
        assert_shown(&text, name);
        if name == "escfield.bsdf" {
            assert!(one_line_error(&text, 1, name).contains("its array '\\u{1b}]0;PWN"));
            continue;
        }
        assert_eq!(text.status.code(), Some(0), "{}", String::from_utf8_lossy(&text.stderr));
        assert_visible(&fs::read(&page).unwrap(), "the page");
        let json = fit(&["--json"]);
        assert_visible(&json.stdout, "JSON");
        let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
        assert!(json["database"].as_str().unwrap().contains("\u{1b}]0;PWNED\u{7}"), "{json}");
    }
}

#[cfg(unix)]
#[test]
fn hostile_file_names_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let file = |extension: &str| {
        let file = folder.path().join(format!("{HOSTILE}.{extension}"));
        fs::write(&file, "no such format").unwrap();
        path(&file).to_owned()
    };
    let missing = path(&folder.path().join(HOSTILE).join("missing.png")).to_owned();
    let [png, exr, hdr, glb, gltf, json, csv, bsdf] =
        ["png", "exr", "hdr", "glb", "gltf", "json", "csv", "bsdf"].map(file);
    let out = path(&folder.path().join("a.ktx2")).to_owned();
    for arguments in [
        &["capture", "--environment", &hdr][..],
        &["capture", "--environment", &exr],
        &["capture", "--scene", &glb],
        &["capture", "--scene", &gltf],
        &["capture", "--camera", &json],
        &["capture", "--scene", "plane", "--height-map", &png],
        &["capture", "--scene", "plane", "--height-map", &missing],
        &["capture", "--scene", "plane", "--material", &json],
        &["capture", "--scene", "plane", "--material", HOSTILE],
        &["capture", "-o", &csv],
        &["capture", "-o", &missing.replace("missing", "{frame}")],
        &["capture", "--scene", HOSTILE],
        &["capture", "--size", HOSTILE],
        &["capture", "--device", HOSTILE],
        &["capture", HOSTILE],
        &[HOSTILE],
        &["compare", &png, &png],
        &["compare", &missing, &missing],
        &["bake", &png, "-o", &out],
        &["bake", path(folder.path()), "-o", &out],
        &["bake", &png, "-o", HOSTILE],
        &["fit", &csv],
        &["fit", &bsdf],
        &["fit", &json],
        &["bench", "--against", &json, "--measured", &json],
    ] {
        let output = leadr(arguments).output().unwrap();
        let code = output.status.code().unwrap();
        one_line_error(&output, code, &format!("{arguments:?}"));
        assert_shown(&output, &format!("{arguments:?}"));
    }
}

#[test]
fn hostile_strings_inside_files_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, content: &[u8]| {
        let file = folder.path().join(name);
        fs::write(&file, content).unwrap();
        path(&file).to_owned()
    };
    let long = format!("{HOSTILE}{}", "x".repeat(1 << 20));
    let json = |value: serde_json::Value| value.to_string().into_bytes();
    let hdr = format!("#?RADIANCE\nFORMAT={}\n\n-Y 1 +X 1\n", HOSTILE.replace('\n', " "));
    let axes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{}\n", HOSTILE.replace('\n', " "));
    let model = |part: serde_json::Value| {
        let mut model = serde_json::json!({ "asset": { "version": "2.0" } });
        model.as_object_mut().unwrap().extend(part.as_object().unwrap().clone());
        json(model)
    };
    let needs = model(serde_json::json!({ "extensionsUsed": [long], "extensionsRequired": [long] }));
    let version = json(serde_json::json!({ "asset": { "version": long } }));
    let buffer = model(serde_json::json!({ "buffers": [{ "byteLength": 4, "uri": HOSTILE }] }));
    let bench = json(serde_json::json!({ "command": long }));
    let rows = json(serde_json::json!({ "command": "bench", "rows": [{ "table": long }], "device": long }));
    let camera = json(serde_json::json!({ long.clone(): 1 }));
    let fit = json(serde_json::json!({ "schema": 1, "masking": long }));
    let csv = format!("{}\n1,2\n", HOSTILE.replace('\n', " "));
    let [hdr, axes] = [("a.hdr", hdr), ("b.hdr", axes)].map(|(name, text)| file(name, text.as_bytes()));
    let [needs, version, buffer] =
        [("a.gltf", needs), ("b.gltf", version), ("c.gltf", buffer)].map(|(name, text)| file(name, &text));
    let [bench, rows, camera, fit] =
        [("a.json", bench), ("b.json", rows), ("c.json", camera), ("d.json", fit)].map(|(n, text)| file(n, &text));
    let csv = file("a.csv", csv.as_bytes());
    for arguments in [
        &["capture", "--environment", &hdr][..],
        &["capture", "--environment", &axes],
        &["capture", "--scene", &needs],
        &["capture", "--scene", &version],
        &["capture", "--scene", &buffer],
        &["capture", "--camera", &camera],
        &["capture", "--scene", "plane", "--material", &fit],
        &["fit", &csv],
        &["bench", "--measured", &bench, "--against", &bench],
        &["bench", "--measured", &rows, "--against", &rows],
    ] {
        let output = leadr(arguments).output().unwrap();
        one_line_error(&output, output.status.code().unwrap(), &format!("{arguments:?}"));
        assert_shown(&output, &format!("{arguments:?}"));
        assert!(output.stderr.len() < 10_000, "{arguments:?} prints {} bytes", output.stderr.len());
    }
}

#[test]
fn hostile_variables_are_shown() {
    let long = format!("{HOSTILE}{}", "x".repeat(100_000));
    for variable in ["LEADR_LOG", "LEADR_CACHE", "XDG_CACHE_HOME", "RAYON_NUM_THREADS", "VK_DRIVER_FILES"] {
        let output = leadr(&["compare", "a.png", "b.png"]).env(variable, &long).output().unwrap();
        assert_shown(&output, variable);
        assert!(output.stderr.len() < 10_000, "{variable}");
        let own_line = usize::from(variable == "LEADR_LOG");
        assert_eq!(String::from_utf8_lossy(&output.stderr).lines().count(), 1 + own_line, "{variable}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text_are_reported_as_they_are() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let named = |bytes: &[u8]| folder.path().join(Path::new(std::ffi::OsStr::from_bytes(bytes)));
    let output = leadr(&["compare"]).arg(named(b"a\xff.png")).arg(named(b"b.png")).output().unwrap();
    let line = one_line_error(&output, 1, "not UTF-8");
    assert!(line.contains("a\\xff.png: cannot be found"), "{line}");
    let output = leadr(&["capture", "--frames", "0..2", "-o"]).arg(named(b"\xff{frame}.png")).output().unwrap();
    assert!(one_line_error(&output, 2, "a pattern").contains("is not UTF-8"));
    // A material folder finds its maps by the words that can be read.
    let bricks = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/bricks");
    fs::create_dir(named(b"material")).unwrap();
    for entry in fs::read_dir(bricks).unwrap().map(Result::unwrap) {
        let name = [b"\xff_", entry.file_name().as_bytes()].concat();
        fs::copy(entry.path(), named(b"material").join(std::ffi::OsStr::from_bytes(&name))).unwrap();
    }
    let out = named(b"b\xff.ktx2");
    let output = leadr(&["bake"]).arg(named(b"material")).arg("-o").arg(&out).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(out.is_file() && String::from_utf8_lossy(&output.stdout).contains("b\\xff.ktx2"));
}
