//! Runs the `leadr` program: exit codes, one line on stderr, results on stdout.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use leadr::maps::save::{save_exr_rgb, save_png};
use leadr::maps::tonemap::Tonemap;
use leadr::maps::{RgbImage, decode_color_srgb8, load_color};
use leadr::scenes::registry::SCENES;
use leadr_testing::gpu::test_gpu;

pub fn leadr(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_leadr"));
    command.args(arguments).env_remove("LEADR_LOG").env("RUST_BACKTRACE", "1");
    command.env("LEADR_CACHE", concat!(env!("CARGO_TARGET_TMPDIR"), "/trex"));
    command
}

fn run(arguments: &[&str]) -> Output {
    leadr(arguments).output().expect("the program starts")
}

/// Checks for one `leadr: error:` line, nothing on stdout, no panic; returns the line.
pub fn one_line_error(output: &Output, code: i32, what: &str) -> String {
    let stderr = String::from_utf8(output.stderr.clone()).expect("UTF-8");
    assert_eq!(output.status.code(), Some(code), "{what}: {stderr}");
    assert!(output.stdout.is_empty(), "{what}: stdout must hold results only");
    assert_eq!(stderr.lines().count(), 1, "{what}: {stderr}");
    assert!(stderr.starts_with("leadr: error: ") && !stderr.contains("panicked"), "{what}: {stderr}");
    stderr
}

pub fn path(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

#[test]
fn help_and_version_are_results() {
    for arguments in [&["--help"][..], &["--version"], &["help", "capture"], &["capture", "--help"]] {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert!(!output.stdout.is_empty() && output.stderr.is_empty(), "{arguments:?}");
    }
    let help = String::from_utf8(run(&["capture", "--help"]).stdout).unwrap();
    assert!(help.contains("Examples:"), "{help}");
}

#[test]
fn wrong_usage_ends_with_2_and_names_the_flag() {
    let cases: [(&[&str], &str); 96] = [
        (&["capture", "--scene", "ocean", "--height-scale", "1"], "--height-scale"),
        (&["capture", "--scene", "ocean", "--no-displacement"], "--smooth-geometry"),
        (&["capture", "--scene", "ocean", "--triangle-pixels", "8"], "--triangle-pixels"),
        (&["capture", "--scene", "ocean", "--atlas-tile", "16"], "--atlas-tile"),
        (&["capture", "--scene", "ocean", "--sky-occlusion", "off"], "--sky-occlusion"),
        (&["capture", "--scene", "plane", "--atlas-tile", "64"], "--atlas-tile"),
        (&["capture", "--scene", "plane", "--wind", "9"], "--wind"),
        (&["capture", "--environment", "studio", "--sun", "10,10"], "--sun"),
        (&["capture", "--frames", "0..5", "-o", "{fame}.png"], "{fame}"),
        (&["capture", "-o", "{scene}.png"], "{scene}"),
        (&["capture", "--samples", "-1"], "a whole number from 1 to 65536"),
        (&["capture", "--size", "16384x16384"], "8192x8192"),
        (&["capture", "--wind", "-3"], "from 1 to 40"),
        (&["bench", "--frames", "-1"], "a whole number from 1 to 10000"),
        (&["bench", "--scene", "plane", "--atlas-tile", "16"], "--atlas-tile"),
        (&["compare", "a.png", "b.png", "--max-flip", "-1"], "--max-flip"),
        (&["capture", "--metal", "wood"], "--metal"),
        (&["capture", "--metal", "gold"], "--metal"),
        (&["capture", "--scene", "plane", "--anisotropy", "2"], "--anisotropy"),
        (&["capture", "--scene", "plane", "--anisotropy-rotation", "20"], "--anisotropy"),
        (&["capture", "--scene", "plane", "--clear-coat", "1.5"], "the weight must be from 0 to 1"),
        (&["capture", "--scene", "plane", "--clear-coat", "1,0"], "the roughness must be above 0 and at most 1"),
        (&["capture", "--scene", "plane", "--clear-coat-relief", "smooth"], "--clear-coat-relief needs --clear-coat"),
        (&["capture", "--scene", "plane", "--clear-coat", "1", "--clear-coat-relief", "rough"], "--clear-coat-relief"),
        (&["capture", "--scene", "trex", "--clear-coat", "1"], "--clear-coat"),
        (&["capture", "--scene", "plane", "--transmission", "2"], "--transmission"),
        (&["capture", "--scene", "plane", "--ior", "0.5"], "from 1 to 4"),
        (&["capture", "--scene", "plane", "--thickness", "1"], "--thickness needs --transmission"),
        (&["capture", "--scene", "plane", "--transmission", "1", "--attenuation", "80c0a0"], "a distance in metres"),
        (&["capture", "--scene", "plane", "--transmission", "1", "--attenuation", "80c0a0,1"], "add --thickness"),
        (&["capture", "--scene", "plane", "--transmission", "1", "--metal", "gold"], "remove --metal"),
        (
            &["capture", "--scene", "plane", "--transmission", "1", "--technique", "clean"],
            "--transmission is for the techniques",
        ),
        (
            &["capture", "--scene", "plane", "--clear-coat", "1", "--technique", "lean"],
            "--clear-coat is for the techniques",
        ),
        (
            &["capture", "--scene", "trex", "--height-scale-map", "a.png"],
            "--height-scale-map is for the scenes plane, sphere",
        ),
        (&["capture", "--scene", "plane", "--height-scale-span", "2"], "--height-scale-span needs --height-scale-map"),
        (&["capture", "--height-scale-map", "a.png", "--height-scale-span", "0"], "--height-scale-span"),
        (&["capture", "--scene", "plane", "--skin-relief", "graded"], "plane has no T-rex"),
        (&["capture", "--scene", "trex", "--skin-relief", "steep"], "--skin-relief"),
        (&["capture", "--scene", "plane", "--detail-displaces"], "--detail-displaces needs --detail"),
        (
            &["capture", "--scene", "sphere", "--detail", "a.png", "--detail-displaces"],
            "--detail-displaces is for the scenes plane",
        ),
        (&["capture", "--scene", "plane", "--detail-mask", "mask.png"], "--detail"),
        (&["capture", "--scene", "plane", "--detail", "a.png", "--detail-repeat", "0"], "--detail-repeat"),
        (
            &["capture", "--scene", "plane", "--detail", "a.png", "--technique", "reference", "--relief-shadows"],
            "--detail",
        ),
        (
            &[
                ["capture", "--scene", "plane", "--height-map", "a.png"].as_slice(),
                &["--anisotropy", "0.5", "--technique", "reference", "--relief-shadows"],
            ]
            .concat(),
            "--anisotropy",
        ),
        (&["capture", "--scene", "plane", "--height-map", "a.png", "--normal-y", "up"], "--normal-y"),
        (&[], "command"),
        (&["dance"], "dance"),
        (&["capture", "--dance"], "--dance"),
        (&["capture", "--scene", "cube"], "cube"),
        (&["capture", "--size", "0x0"], "--size"),
        (&["capture", "--size", "100000x100000"], "--size"),
        (&["capture", "--size", "64"], "--size"),
        (&["capture", "--samples", "0"], "--samples"),
        (&["capture", "--sun", "nan,0"], "--sun"),
        (&["capture", "--time", "inf"], "--time"),
        (&["capture", "--frames", "5..5", "-o", "{frame}.png"], "--frames"),
        (&["capture", "--frames", "0..5", "--shard", "6/5"], "--shard"),
        (&["capture", "--frames", "0..5", "-o", "a.png"], "{frame}"),
        (&["capture", "--shard", "1/2"], "--frames"),
        (&["capture", "--frames", "0..5", "-o", "-", "--json"], "--json"),
        (&["capture", "-o", "a.jpg"], "a.jpg"),
        (&["capture", "-o", "a.png", "--layers", "depth"], "--layers"),
        (&["capture", "--layers", "colour"], "colour"),
        (&["capture", "--environment", "a.png"], "--environment"),
        (&["capture", "--environment-lights", "5", "--environment", "studio"], "--environment-lights"),
        (&["capture", "--environment-lights", "few", "--environment", "studio"], "--environment-lights"),
        (&["capture", "--environment-lights", "2"], "--environment-lights"),
        (
            &["capture", "--environment-light-threshold", "0", "--environment", "studio"],
            "--environment-light-threshold",
        ),
        (&["capture", "--camera", "a.png"], "--camera"),
        (&["capture", "--height-map", "a.png"], "--height-map"),
        (&["capture", "--scene", "ocean", "--roughness", "0.2"], "--roughness"),
        (&["compare", "a.png"], "TEST"),
        (&["compare", "a.png", "b.exr"], "same format"),
        (&["compare", "a.jpg", "b.jpg"], "a.jpg"),
        (&["compare", "a.png", "b.png", "--max-flip=-1"], "--max-flip"),
        (&["bench", "--goals"], "--goals needs --paper"),
        (&["bench", "--measured", "a.json"], "--measured needs --against"),
        (&["capture", "--fps=24"], "--fps needs --frames"),
        (&["capture", "--sweep", "1..2", "--samples", "2"], "error: --sweep needs --frames"),
        (&["capture", "--size", "64x64", "--split", "0.3"], "error: --split needs --beside <TECHNIQUE>"),
        (&["capture", "--size", "64x64", "--sheet", "2x2"], "error: --sheet needs --frames"),
        (&["capture", "--size", "64x64", "--turntable", "--fps", "9"], "error: --fps and --turntable need --frames"),
        (&["capture", "--tecnique", "lean"], "found; a similar argument exists"),
        (&["capture", "--scene", "spere"], "a similar name exists: 'sphere'"),
        (&["capture", "--environment", "stduio"], "a similar name exists: 'studio'"),
        (&["capture", "--roughness", "2"], "must be above 0 and at most 1"),
        (
            &["capture", "--technique", "lean", "--multiscattering", "on"],
            "is for the techniques normal-mip, gloss, leadr, reference, not lean",
        ),
        (&["report"], "cargo run --release -p leadr-lab -- report"),
        (&["bake", "a.png", "--detail-gloss", "b.png", "-o", "c.ktx2"], "--detail-gloss needs --detail"),
        (&["bake", "a.png"], "--output <FILE|FOLDER> is missing"),
        (&["compare", "a.png", "b.png", "--max-flip", "2"], "from 0 to 1"),
        (&["compare", "a.png", "b.png", "--max-flip", "nan"], "from 0 to 1"),
        (&["compare", "a.png", "b.png", "--max-rrmse", "nan"], "--max-rrmse"),
        (&["compare", "a.png", "b.png", "--crop", "0,0,0,8"], "X,Y,WIDTH,HEIGHT"),
        (&["bench", "--measured", "a.json", "--against", "b.json", "--max-ratio", "nan"], "--max-ratio"),
        (&["compare", "a.png", "b.png", "--error-image", "e.exr"], "e.exr"),
    ];
    for (arguments, named) in cases {
        let line = one_line_error(&run(arguments), 2, &format!("{arguments:?}"));
        assert!(line.contains(named), "{arguments:?}: {line}");
    }
}

#[test]
fn a_misspelt_animation_is_answered_with_the_nearest() {
    let snail = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/snail.glb");
    let line = one_line_error(&run(&["capture", "--scene", snail, "--animation", "crawl"]), 1, "crawl");
    assert!(line.contains("a similar name exists: 'Crawl'"), "{line}");
}

#[cfg(not(feature = "window"))]
#[test]
fn a_build_without_the_window_names_it() {
    for arguments in [&["demo"][..], &["demo", "--scene", "ocean"], &["demo", "--help"], &["help", "demo"]] {
        let line = one_line_error(&run(arguments), 2, &format!("{arguments:?}"));
        assert!(line.contains("no window") && line.contains("leadr capture") && line.contains("cargo build"), "{line}");
    }
}

#[test]
fn completions_and_manual_pages_name_the_flags() {
    for shell in ["bash", "zsh", "fish"] {
        let output = run(&["completions", shell]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let script = String::from_utf8(output.stdout).unwrap();
        assert!(script.contains("capture") && script.contains("height-map"), "{shell}");
        assert!(script.contains("sphere") && script.contains("studio"), "{shell}");
        let left = |line: &&str| ["FILE)'", "FILE\\t", " FILE\" --"].iter().any(|word| line.contains(word));
        assert_eq!(script.lines().find(left), None, "{shell}: a word that stands for files");
    }
    let zsh = String::from_utf8(run(&["completions", "zsh"]).stdout).unwrap();
    assert!(
        zsh.contains("model\\:NAME|FILE.json|") && zsh.contains(":{compadd - near mid far model; _files}'"),
        "{zsh}"
    );
    // What bash offers after these words: names and files.
    let folder = tempfile::tempdir().unwrap();
    let offered = |flag: &str, start: &str| {
        let words = format!("COMP_WORDS=(leadr capture {flag} {start}); COMP_CWORD=3; _leadr leadr '{start}' {flag}");
        let script =
            format!("eval \"$('{}' completions bash)\"; {words}; echo ${{COMPREPLY[*]}}", env!("CARGO_BIN_EXE_leadr"));
        let output = Command::new("bash").current_dir(&folder).args(["-c", &script]).output().expect("bash");
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    };
    std::fs::write(folder.path().join("spoon.glb"), "").unwrap();
    std::fs::write(folder.path().join("street.hdr"), "").unwrap();
    assert_eq!(offered("--scene", "sp"), "sphere spheres spoon.glb");
    assert_eq!(offered("--environment", "st"), "studio street.hdr");
    assert_eq!(offered("--ground", "o"), "on off");
    let pages = folder.path().join("man1");
    assert_eq!(run(&["man", path(&pages)]).status.code(), Some(0));
    let page = |name: &str| std::fs::read_to_string(pages.join(name)).unwrap();
    assert!(page("leadr.1").contains("capture") && page("leadr-capture.1").contains("height\\-map"));
    for entry in std::fs::read_dir(&pages).unwrap() {
        let file = entry.unwrap().path();
        let text = std::fs::read_to_string(&file).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        for (number, _) in lines.iter().enumerate().filter(|(_, line)| **line == ".TP") {
            let [header, body] = [1, 2].map(|next| lines.get(number + next).copied().unwrap_or_default());
            assert!(!body.is_empty() && !body.starts_with('.'), "{}: {header} has no text", file.display());
        }
        let (synopsis, version) = (text.split_once(".SH SYNOPSIS\n").unwrap().1, text.split_once(".SH VERSION\n"));
        assert!(synopsis.lines().next().unwrap().len() < 100, "{}: {synopsis}", file.display());
        assert!(version.is_none_or(|(_, version)| !version.contains("cache")), "{}: {version:?}", file.display());
        assert!(!text.contains("help(1)"), "{}: the command help has no page", file.display());
    }
    assert!(page("leadr-capture.1").contains("\n.br\n\\- ocean: "), "one line per scene");
}

#[test]
fn every_scene_is_in_the_help_and_in_the_guide() {
    let help = String::from_utf8(run(&["capture", "--help"]).stdout).unwrap();
    let guide = include_str!("../../docs/guide/scenes.md");
    for scene in &SCENES {
        let name = scene.name;
        assert!(help.contains(&format!("- {name}: ")), "{name}: {help}");
        assert!(guide.contains(&format!("`{name}`")), "docs/guide/scenes.md says nothing of {name}");
    }
}

/// A grey ramp, with a bright square in it if `marked`.
fn picture(marked: bool) -> RgbImage {
    let texel = |i: u32| {
        let (x, y) = (i % 32, i / 32);
        let square = marked && (8..16).contains(&x) && (8..16).contains(&y);
        [if square { 0.9 } else { x as f32 / 64.0 }; 3]
    };
    RgbImage::new(32, 32, (0..32 * 32).map(texel).collect()).unwrap()
}

#[test]
fn compare_measures_and_its_thresholds_set_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    for kind in ["png", "exr"] {
        let file = |name: &str, marked| {
            let file = folder.path().join(format!("{name}.{kind}"));
            match kind {
                "png" => save_png(&file, &picture(marked), 1.0, Tonemap::Clamp).unwrap(),
                _ => save_exr_rgb(&file, &picture(marked)).unwrap(),
            }
            file
        };
        let (plain, marked) = (file("plain", false), file("marked", true));
        let measure = |test: &Path, flags: &[&str]| {
            let output = run(&[&["compare", path(&plain), path(test), "--json"], flags].concat());
            let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
            (output, json)
        };
        let (same, json) = measure(&plain, &["--max-flip", "0", "--max-rrmse", "0"]);
        assert_eq!(same.status.code(), Some(0), "{kind}: {json}");
        assert_eq!((json["flip"].as_f64(), json["rrmse"].as_f64()), (Some(0.0), Some(0.0)));
        assert_eq!(json["max_abs"].as_f64(), Some(0.0));

        let error_image = folder.path().join("made").join(format!("{kind}.png"));
        let (other, json) = measure(&marked, &["--error-image", path(&error_image)]);
        assert_eq!(other.status.code(), Some(0), "without a threshold, comparing must not fail");
        assert!(json["flip"].as_f64().unwrap() > 0.01 && json["max_abs"].as_f64().unwrap() > 0.5, "{json}");
        assert!(error_image.is_file());
        for flags in [["--max-flip", "0.001"], ["--max-rrmse", "0.001"]] {
            let (over, _) = measure(&marked, &flags);
            let stderr = String::from_utf8(over.stderr).unwrap();
            assert_eq!(over.status.code(), Some(1), "{flags:?}");
            assert!(stderr.starts_with("leadr: error: ") && stderr.contains("over 0.001"), "{stderr}");
        }
    }
}

#[test]
fn compare_measures_inside_the_crop_and_the_mask() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let save = |name: &str, image: &RgbImage| save_png(file(name), image, 1.0, Tonemap::Clamp).unwrap();
    save("plain.png", &picture(false));
    save("marked.png", &picture(true));
    let columns = |end: u32| {
        let texel = |i: u32| [if i % 32 < end { 1.0 } else { 0.0 }; 3];
        RgbImage::new(32, 32, (0..32 * 32).map(texel).collect()).unwrap()
    };
    save("left.png", &columns(4));
    save("black.png", &columns(0));
    let (plain, marked) = (file("plain.png"), file("marked.png"));
    let measure = |flags: &[&str]| {
        let output = run(&[&["compare", path(&plain), path(&marked), "--json"], flags].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<serde_json::Value>(&output.stdout).expect("one JSON object")
    };
    let (left, black) = (file("left.png"), file("black.png"));
    // The square covers the columns and rows 8 to 15.
    let away = measure(&["--crop", "20,20,8,8"]);
    assert_eq!((&away["size"], &away["pixels"], &away["flip"]), (&[8, 8].into(), &64.into(), &0.0.into()));
    let there = measure(&["--crop", "8,8,8,8"]);
    assert!(there["flip"].as_f64() > measure(&[])["flip"].as_f64() && there["max_abs"].as_f64() > Some(0.5), "{there}");
    let masked = measure(&["--mask", path(&left)]);
    assert_eq!((&masked["pixels"], &masked["rrmse"]), (&128.into(), &0.0.into()));
    assert_eq!(measure(&["--mask", path(&left), "--crop", "0,8,8,8"])["pixels"], 32);
    for (flags, named) in [
        (&["--crop", "8,8,32,8"][..], "32 x 32"),
        (&["--mask", path(&black)], "black.png"),
        (&["--mask", path(&left), "--crop", "8,8,8,8"], "--crop"),
        (&["--mask", "missing.png"], "missing.png"),
    ] {
        let line = one_line_error(&run(&[&["compare", path(&plain), path(&marked)], flags].concat()), 1, named);
        assert!(line.contains(named), "{flags:?}: {line}");
    }
}

/// Checks the common fields of results, and that the guide describes all fields.
fn check_fields(command: &str, result: &serde_json::Value) {
    assert_eq!((result["schema"].as_u64(), result["command"].as_str()), (Some(1), Some(command)), "{result}");
    for field in ["version", "commit"] {
        assert!(result[field].as_str().is_some_and(|text| !text.is_empty()), "{field}: {result}");
    }
    let guide = include_str!("../../docs/guide/json.md");
    let (shared, own) = guide.split_once("\n## capture").unwrap();
    let own = if command == "capture" { own } else { own.split_once(&format!("\n## {command}\n")).unwrap().1 };
    let section = own.split("\n## ").next().unwrap();
    for field in result.as_object().unwrap().keys() {
        let named = format!("`{field}`");
        assert!(shared.contains(&named) || section.contains(&named), "docs/guide/json.md: {command} has no {field}");
    }
}

#[test]
#[ignore = "long"]
fn every_field_of_a_result_is_in_the_guide() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    save_png(file("a.png"), &picture(true), 1.0, Tonemap::Clamp).unwrap();
    let json = |arguments: &[&str]| {
        let output = run(&[arguments, &["--json"]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<serde_json::Value>(&output.stdout).expect("one JSON object")
    };
    let compared = json(&["compare", path(&file("a.png")), path(&file("a.png"))]);
    check_fields("compare", &compared);
    assert_eq!(compared["size"], serde_json::json!([32, 32]));
    let baked = json(&["bake", path(&file("a.png")), "-o", path(&file("a.ktx2"))]);
    check_fields("bake", &baked);
    assert_eq!(baked["size"], serde_json::json!([32, 32]));
    let both =
        json(&["bake", path(&file("a.png")), "--kind", "leadr,normal", "-o", &format!("{}/", path(folder.path()))]);
    check_fields("bake", &both);
    let Some(_) = test_gpu() else { return };
    let flags = ["--scene", "plane", "--size", "8x6"];
    let captured = json(&[&["capture", "--samples", "1", "-o", path(&file("b.png"))], &flags[..]].concat());
    check_fields("capture", &captured);
    assert_eq!(captured["settings"]["size"], serde_json::json!([8, 6]));
    let flags = [&["bench", "--frames", "1", "--technique", "leadr", "--tables", "techniques"], &flags[..]].concat();
    check_fields("bench", &json(&flags));
}

#[test]
fn compare_names_the_picture_that_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    save_png(file("good.png"), &picture(false), 1.0, Tonemap::Clamp).unwrap();
    let small = RgbImage::new(1, 1, vec![[0.5; 3]]).unwrap();
    save_png(file("small.png"), &small, 1.0, Tonemap::Clamp).unwrap();
    std::fs::write(file("text.png"), "no picture").unwrap();
    for wrong in ["small.png", "text.png", "missing.png"] {
        let output = run(&["compare", path(&file("good.png")), path(&file(wrong))]);
        let line = one_line_error(&output, 1, wrong);
        assert!(line.contains(wrong), "{line}");
    }
    let alone = run(&["compare", path(&file("small.png")), path(&file("small.png")), "--max-flip", "0"]);
    assert_eq!(alone.status.code(), Some(0), "one pixel is enough");
}

#[test]
fn a_missing_or_wrong_camera_file_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.json");
    let wrong = folder.path().join("wrong.json");
    std::fs::write(&wrong, b"\x89PNG\r\n\x1a\n").unwrap();
    let huge = folder.path().join("huge.json");
    std::fs::write(&huge, vec![b' '; 1 << 20]).unwrap();
    for file in [&missing, &wrong, &huge, &folder.path().join("folder.json")] {
        if file.ends_with("folder.json") {
            std::fs::create_dir(file).unwrap();
        }
        let line = one_line_error(&run(&["capture", "--camera", path(file)]), 1, path(file));
        assert!(line.contains(file.file_name().unwrap().to_str().unwrap()), "{line}");
    }
}

#[cfg(unix)]
#[test]
fn pipes_are_refused_without_waiting() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = |name: &str| {
        let pipe = folder.path().join(name);
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        path(&pipe).to_owned()
    };
    let (picture, model, json) = (pipe("a.exr"), pipe("a.glb"), pipe("a.json"));
    let (png, ktx2, binary, out) = (pipe("a.png"), pipe("a.ktx2"), pipe("a.binary"), path(folder.path()).to_owned());
    for arguments in [
        &["capture", "--camera", &json][..],
        &["capture", "--environment", &picture],
        &["capture", "--scene", &model],
        &["capture", "--scene", "plane", "--height-map", &picture],
        &["capture", "--scene", "plane", "--height-map", &ktx2],
        &["capture", "--scene", "plane", "--color-map", &png],
        &["capture", "--scene", "plane", "--material", &json],
        &["compare", &png, &png],
        &["compare", &picture, &picture],
        &["bake", &png, "-o", &format!("{out}/b.ktx2")],
        &["fit", &binary, "-o", &format!("{out}/b.json")],
        &["bench", "--measured", &json, "--against", &json],
    ] {
        let mut child = leadr(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let start = Instant::now();
        while child.try_wait().unwrap().is_none() {
            if start.elapsed().as_secs() > 60 {
                child.kill().unwrap();
                panic!("{arguments:?} waits for the pipe");
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        one_line_error(&child.wait_with_output().unwrap(), 1, &format!("{arguments:?}"));
    }
}

#[test]
fn unwritable_targets_are_reported_first() {
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("far.png");
    save_png(&picture, &self::picture(false), 1.0, Tonemap::Clamp).unwrap();
    let below = picture.join("x.png");
    // Without a driver: the target is checked before the device and the inputs.
    for arguments in [
        &["capture", "-o", path(&below)][..],
        &["capture", "--frames", "0..3", "-o", path(&picture.join("{frame}.png"))],
        &["capture", "--frames", "0..3", "-o", path(&picture.join("a.webp"))],
        &["bake", "missing.png", "-o", path(&below.with_extension("ktx2"))],
        &["fit", "missing.binary", "-o", path(&below.with_extension("json"))],
        &["compare", "missing.png", "missing.png", "--error-image", path(&below)],
    ] {
        let line = one_line_error(&without_driver(arguments), 1, &format!("{arguments:?}"));
        assert!(line.contains("far.png"), "{arguments:?}: {line}");
    }
}

#[test]
#[ignore = "long"]
fn every_scene_honours_a_flag_or_refuses_it() {
    let Some(_) = test_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let render = |flags: &[&str]| {
        let file = folder.path().join("a.png");
        let output = run(&[&["capture", "--samples", "1", "-o", path(&file)], flags].concat());
        (output.status.code() == Some(0))
            .then(|| std::fs::read(&file).map(|bytes| decode_color_srgb8(&bytes).unwrap().texels).unwrap())
    };
    let scenes: [&[&str]; 3] = [
        &["--scene", "ocean", "--size", "64x48", "--fft", "64"],
        &["--scene", "plane", "--size", "80x45", "--camera", "near"],
        &["--scene", "spheres", "--size", "320x180"],
    ];
    let flags: [&[&str]; 6] = [
        &["--roughness", "0.9"],
        &["--height-scale", "0.3"],
        &["--no-displacement"],
        &["--triangle-pixels", "60"],
        &["--atlas-tile", "16"],
        &["--sky-occlusion", "off"],
    ];
    for scene in scenes {
        let own = render(scene).unwrap();
        for flag in flags {
            if let Some(changed) = render(&[scene, flag].concat()) {
                assert!(changed != own, "{scene:?} ignores {flag:?}");
            }
        }
    }
    let wind = |wind: &str| render(&["--scene", "ocean", "--size", "64x48", "--fft", "64", "--wind", wind]).unwrap();
    assert!(wind("4") != wind("14"));
}

#[test]
fn bad_input_is_reported_before_opening_a_device() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, bytes: &[u8]| {
        let file = folder.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        file
    };
    let empty = file("empty.hdr", b"");
    let text = file("text.exr", b"no picture at all");
    let png_as_hdr = file("png.hdr", b"\x89PNG\r\n\x1a\n");
    let truncated = file("truncated.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 4\n\x02\x02");
    let huge = file("huge.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\n");
    let missing = folder.path().join("missing.hdr");
    for environment in [&empty, &text, &png_as_hdr, &truncated, &huge, &missing] {
        let output = without_driver(&["capture", "--environment", path(environment)]);
        let line = one_line_error(&output, 1, path(environment));
        assert!(line.contains(path(environment)), "{line}");
    }
    let png = file("cut.png", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR");
    for heights in [&png, &text, &folder.path().join("missing.png")] {
        for flag in ["--height-map", "--height-scale-map"] {
            let output = without_driver(&["capture", "--scene", "plane", flag, path(heights)]);
            let line = one_line_error(&output, 1, path(heights));
            assert!(line.contains(path(heights)), "{line}");
        }
    }
}

/// Runs `leadr` without any Vulkan driver.
fn without_driver(arguments: &[&str]) -> Output {
    let nothing = "/nonexistent/driver.json";
    leadr(arguments).env("VK_DRIVER_FILES", nothing).env("VK_ICD_FILENAMES", nothing).output().unwrap()
}

#[test]
fn demo_checks_flags_then_files_then_display() {
    let demo = |flags: &[&str]| {
        let mut command = leadr(&[&["demo"], flags].concat());
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        command.output().unwrap()
    };
    if cfg!(not(feature = "window")) {
        assert!(one_line_error(&demo(&[]), 2, "no window").contains("demo"));
        return;
    }
    for (flags, named) in [(["--frames", "0"], "--frames"), (["--height-map", "a.png"], "--height-map")] {
        assert!(one_line_error(&demo(&flags), 2, named).contains(named));
    }
    assert!(one_line_error(&demo(&["--environment", "missing.hdr"]), 1, "a file").contains("missing.hdr"));
    if cfg!(target_os = "linux") {
        assert!(one_line_error(&demo(&[]), 1, "no display").contains("leadr capture"));
    }
}

#[test]
fn missing_vulkan_driver_gives_install_hint() {
    let line = one_line_error(&without_driver(&["capture"]), 1, "no driver");
    assert!(line.contains("Vulkan") && line.contains("install"), "{line}");
}

#[test]
fn unknown_device_lists_the_choices() {
    let Some(_) = test_gpu() else { return };
    let line = one_line_error(&run(&["capture", "--device", "abacus"]), 1, "--device abacus");
    assert!(line.contains("abacus") && line.contains("0: "), "{line}");
}

#[test]
#[ignore = "long"]
fn capture_is_deterministic_and_reports_settings() {
    let Some(_) = test_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let flags = ["capture", "--scene", "sphere", "--size", "48x32", "--samples", "2", "--validation", "--json"];
    for (name, extra) in [("a.png", &[][..]), ("b.exr", &["--layers", "depth,normal,mean-slope,covariance,lod,albedo"])]
    {
        let render = |file: &Path| {
            let output = run(&[&flags[..], extra, &["-o", path(file)]].concat());
            assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
            (std::fs::read(file).unwrap(), serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap())
        };
        let (first, report) = render(&folder.path().join(name));
        let (second, _) = render(&folder.path().join(format!("again-{name}")));
        assert_eq!(first, second, "{name}");
        assert!(report["device"].as_str().is_some_and(|device| !device.is_empty()), "{report}");
        assert!(report["frames"][0]["passes"].as_array().is_some_and(|passes| passes.len() > 3), "{report}");
    }
    // Something is visible: the sphere differs from its background.
    let image = load_color(folder.path().join("a.png")).unwrap();
    let difference: f32 = (0..3).map(|c| (image.at(24, 16)[c] - image.at(1, 1)[c]).abs()).sum();
    assert!(difference > 0.1, "{:?} {:?}", image.at(24, 16), image.at(1, 1));
}

#[test]
#[ignore = "long"]
fn capture_prints_only_file_names() {
    let Some(_) = test_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let pattern = folder.path().join("{frame}.png");
    let flags = ["capture", "--scene", "sphere", "--size", "8x8", "--samples", "1", "--frames", "0..3"];
    for (extra, kept) in [("--resume", false), ("--resume", true), ("--quiet", false)] {
        let output = run(&[&flags[..], &[extra, "-o", path(&pattern)]].concat());
        let (message, log) = (String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap());
        assert_eq!(output.status.code(), Some(0), "{log}");
        if extra == "--quiet" {
            assert!(message.is_empty() && log.is_empty(), "{message}{log}");
            continue;
        }
        let names: Vec<_> = message.lines().map(Path::new).collect();
        assert_eq!(names.len(), 3, "{message}");
        assert!(names.iter().all(|name| name.is_file()), "{message}");
        assert!(
            log.contains("3 frames in") && log.contains("of set-up") && log.contains("3 of them kept") == kept,
            "{log}"
        );
    }
}

#[test]
#[ignore = "long"]
fn video_on_stdout_is_clean_and_closed_pipe_is_reported() {
    let Some(_) = test_gpu() else { return };
    let flags =
        ["capture", "--scene", "sphere", "--size", "64x64", "--samples", "1", "--frames", "0..4", "--fps", "24"];
    let output = run(&[&flags[..], &["-o", "-"]].concat());
    let log = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{log}");
    let header = b"YUV4MPEG2 W64 H64 F24:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n";
    assert_eq!(output.stdout.strip_prefix(header).map(<[u8]>::len), Some(4 * (6 + 3 * 64 * 64)));
    assert!(log.contains("4 frames in"), "{log}");

    // Quiet, because a slow machine would get progress messages.
    let mut child = leadr(&[&flags[..], &["-o", "-", "--quiet"]].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let line = one_line_error(&child.wait_with_output().unwrap(), 1, "a closed pipe");
    assert!(line.contains("standard output"), "{line}");
}

#[test]
fn the_report_names_the_lights_of_a_picture() {
    let Some(_) = test_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let sky = folder.path().join("sky.exr");
    // The centre of the image is the direction +x.
    let mut image = RgbImage::new(128, 64, vec![[1.0; 3]; 128 * 64]).unwrap();
    for at in [31 * 128 + 63, 31 * 128 + 64, 32 * 128 + 63, 32 * 128 + 64] {
        image.texels[at] = [2001.0, 1001.0, 501.0];
    }
    save_exr_rgb(&sky, &image).unwrap();
    let capture = |extra: &[&str]| {
        let file = folder.path().join("a.png");
        let flags =
            ["capture", "--scene", "plane", "--size", "8x8", "--samples", "1", "--json", "--environment", path(&sky)];
        let output = run(&[&flags[..], extra, &["-o", path(&file)]].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap()
    };
    let report = capture(&[]);
    let lights = report["lights"].as_array().unwrap();
    assert_eq!(lights.len(), 1, "{report}");
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    assert!((number(&lights[0]["direction"][0]) - 1.0).abs() < 1e-5, "{lights:?}");
    let texel = 2.0 * std::f64::consts::PI / 128.0 * (std::f64::consts::PI / 64.0).sin();
    for (channel, radiance) in [2000.0, 1000.0, 500.0].into_iter().enumerate() {
        let irradiance = number(&lights[0]["irradiance"][channel]);
        assert!((irradiance / (4.0 * texel * radiance) - 1.0).abs() < 0.02, "{lights:?}");
    }
    // A square of 5.6 degrees has the variance of a disk of 3.2.
    assert!((number(&lights[0]["radius_degrees"]) - 3.25).abs() < 0.1, "{lights:?}");
    assert_eq!(report["settings"]["environment_lights"], 4);
    assert_eq!(report["settings"]["environment_light_threshold"], 8.0);
    assert_eq!(capture(&["--environment-lights", "0"])["lights"], serde_json::json!([]));
}

#[test]
fn roughness_replaces_that_of_displaced_surfaces() {
    let Some(_) = test_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let render = |name: &str, flags: &[&str]| {
        let file = folder.path().join(name);
        let scene = ["capture", "--scene", "pillow", "--camera", "near", "--atlas-tile", "8", "--size", "24x16"];
        let light = ["--terms", "specular-lights", "--samples", "1", "-o", path(&file)];
        let output = run(&[&scene[..], flags, &light].concat());
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let texels = load_color(file).unwrap().texels;
        texels.iter().map(|t| t.iter().sum::<f32>()).fold(0.0, f32::max)
    };
    // A smooth cloth has highlights, a rough one has none; its own roughness is between.
    let [smooth, own, rough] =
        [&["--roughness", "0.1"][..], &[], &["--roughness", "1"]].map(|flags| render("pillow.png", flags));
    assert!(smooth > own && own > rough, "{smooth} {own} {rough}");
}

#[test]
#[ignore = "long"]
fn the_trex_baked_and_from_the_cache_is_the_same_picture() {
    let Some(_) = test_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let render = |name: &str, time: &str| {
        let file = folder.path().join(name);
        let flags =
            ["capture", "--atlas-tile", "8", "--size", "96x96", "--samples", "1", "--validation", "--time", time];
        let output = leadr(&[&flags[..], &["-o", path(&file)]].concat()).env("LEADR_CACHE", &cache).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        std::fs::read(file).unwrap()
    };
    let baked = render("baked.png", "0.3");
    let mut kinds: Vec<String> = std::fs::read_dir(&cache)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap().rsplit_once('-').unwrap().0.to_owned())
        .collect();
    kinds.sort();
    assert_eq!(kinds, ["classes", "horizon", "horizon", "soil", "trex-8"], "of the animal and of the ground");
    assert_eq!(render("cached.png", "0.3"), baked);
    assert_ne!(render("later.png", "0.6"), baked, "it walks");
    // The animal in the middle differs from the sky above and the ground below.
    let image = load_color(folder.path().join("baked.png")).unwrap();
    let apart = |a: [f32; 3], b: [f32; 3]| (0..3).map(|c| (a[c] - b[c]).abs()).sum::<f32>();
    let [sky, animal, ground] = [image.at(48, 4), image.at(48, 46), image.at(48, 90)];
    let nearest = apart(sky, animal).min(apart(animal, ground)).min(apart(sky, ground));
    assert!(nearest > 0.05, "{sky:?} {animal:?} {ground:?}");
}
