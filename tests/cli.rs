//! The `leadr` program from outside: exit codes, one line on stderr, results on stdout.

use std::path::Path;
use std::process::{Command, Output};

fn leadr(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_leadr"));
    command.args(arguments).env_remove("LEADR_LOG").env("RUST_BACKTRACE", "1");
    command
}

fn run(arguments: &[&str]) -> Output {
    leadr(arguments).output().expect("the program starts")
}

/// Checks for one `leadr: error:` line, nothing on stdout, no panic; returns the line.
fn one_line_error(output: &Output, code: i32, what: &str) -> String {
    let stderr = String::from_utf8(output.stderr.clone()).expect("UTF-8");
    assert_eq!(output.status.code(), Some(code), "{what}: {stderr}");
    assert!(output.stdout.is_empty(), "{what}: stdout is for results");
    assert_eq!(stderr.lines().count(), 1, "{what}: {stderr}");
    assert!(stderr.starts_with("leadr: error: ") && !stderr.contains("panicked"), "{what}: {stderr}");
    stderr
}

fn path(path: &Path) -> &str {
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
    let cases: [(&[&str], &str); 20] = [
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
        (&["capture", "-o", "a.jpg"], "a.jpg"),
        (&["capture", "-o", "a.png", "--layers", "depth"], "--layers"),
        (&["capture", "--layers", "colour"], "colour"),
        (&["capture", "--environment", "a.png"], "--environment"),
        (&["capture", "--camera", "a.png"], "--camera"),
        (&["capture", "--height-map", "a.png"], "--height-map"),
    ];
    for (arguments, named) in cases {
        let line = one_line_error(&run(arguments), 2, &format!("{arguments:?}"));
        assert!(line.contains(named), "{arguments:?}: {line}");
    }
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

#[test]
fn a_missing_or_wrong_input_is_named_before_a_device_is_asked_for() {
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
        let output = without_driver(&["capture", "--scene", "plane", "--height-map", path(heights)]);
        let line = one_line_error(&output, 1, path(heights));
        assert!(line.contains(path(heights)), "{line}");
    }
}

/// Runs `leadr` where the loader finds no Vulkan driver.
fn without_driver(arguments: &[&str]) -> Output {
    let nothing = "/nonexistent/driver.json";
    leadr(arguments).env("VK_DRIVER_FILES", nothing).env("VK_ICD_FILENAMES", nothing).output().unwrap()
}

#[test]
fn no_vulkan_driver_is_one_sentence_that_says_what_to_install() {
    let line = one_line_error(&without_driver(&["capture"]), 1, "no driver");
    assert!(line.contains("Vulkan") && line.contains("install"), "{line}");
}

#[test]
fn an_unknown_device_is_named_with_the_choice() {
    let line = one_line_error(&run(&["capture", "--device", "abacus"]), 1, "--device abacus");
    assert!(line.contains("abacus") && line.contains("0: "), "{line}");
}
