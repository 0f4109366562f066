//! Full disks, closed pipes, no threads, signals, and outputs that are inputs.
#![cfg(target_os = "linux")]

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::cli::{leadr, one_line_error, path};
use leadr::maps::save::save_png;
use leadr::maps::tonemap::Tonemap;
use leadr::maps::{RgbImage, load_color};
use leadr_testing::gpu::test_gpu;

/// A small picture.
fn write_picture(file: &Path) {
    let texels = (0..64).map(|i| [i as f32 / 64.0; 3]).collect();
    save_png(file, &RgbImage::new(8, 8, texels).unwrap(), 1.0, Tonemap::Clamp).unwrap();
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_full_disk_is_a_sentence_and_an_exit_code() {
    let full = || Stdio::from(File::options().write(true).open("/dev/full").unwrap());
    let folder = tempfile::tempdir().unwrap();
    let picture = folder.path().join("a.png");
    write_picture(&picture);
    let same = ["compare", path(&picture), path(&picture)];
    let text = |output: Output| String::from_utf8(output.stderr).unwrap();
    for (arguments, code) in [
        (&["--help"][..], 1),
        (&["--version"], 1),
        (&["capture", "--help"], 1),
        (&same, 1),
        (&[&same[..], &["--json"]].concat(), 1),
        (&["compare", "missing.png", "missing.png"], 1),
        (&["dance"], 2),
    ] {
        let output = leadr(arguments).stdout(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
        assert!(text(output).starts_with("leadr: error: "), "{arguments:?}");
        // Nothing can be reported on a full stderr, but the exit code stays.
        let output = leadr(arguments).stdout(Stdio::piped()).stderr(full()).output().unwrap();
        let quiet = if output.stdout.is_empty() { code } else { 0 };
        assert_eq!(output.status.code(), Some(quiet), "{arguments:?}");
        let output = leadr(arguments).stdout(full()).stderr(full()).output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
    }
    let output = leadr(&same).env("LEADR_LOG", "wrong").stderr(full()).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn a_reader_that_stops_early_is_no_error() {
    for arguments in [&["--help"][..], &["capture", "--help"]] {
        let mut child = leadr(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0), "{arguments:?}");
    }
}

#[test]
fn a_system_without_threads_is_reported() {
    let program = env!("CARGO_BIN_EXE_leadr");
    let line = format!("ulimit -v 3000000; exec '{program}' compare missing.png missing.png");
    let run = || Command::new("sh").args(["-c", &line]).env("RAYON_NUM_THREADS", "3000").output().unwrap();
    // Rarely, the memory ends in a thread that has just begun, and Rust's runtime aborts the program.
    let aborted = |output: &Output| String::from_utf8_lossy(&output.stderr).contains("an alternative stack");
    let output = (0..5).map(|_| run()).find(|output| !aborted(output)).expect("one of five runs ends by itself");
    let line = one_line_error(&output, 1, "no threads");
    assert!(line.contains("refuses another thread") && line.contains("ulimit"), "{line}");
}

#[test]
fn outputs_never_replace_inputs() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| path(&folder.path().join(name)).to_owned();
    write_picture(Path::new(&at("a.png")));
    write_picture(Path::new(&at("b.png")));
    fs::create_dir(at("sub")).unwrap();
    fs::hard_link(at("a.png"), at("hard.png")).unwrap();
    std::os::unix::fs::symlink("../a.png", at("sub/soft.png")).unwrap();
    fs::write(at("gold.csv"), "theta,r,g,b\n0,1,1,1\n30,0.5,0.5,0.5\n60,0.2,0.2,0.2\n").unwrap();
    fs::hard_link(at("gold.csv"), at("gold.json")).unwrap();
    let before = fs::read(at("a.png")).unwrap();
    let gpu = test_gpu().is_some();
    for output in ["a.png", "hard.png", "sub/soft.png", "sub/../a.png"] {
        let output = at(output);
        let (a, b, csv, json) = (at("a.png"), at("b.png"), at("gold.csv"), at("gold.json"));
        for arguments in [
            &["compare", &a, &a, "--error-image", &output][..],
            &["compare", &b, &b, "--mask", &a, "--error-image", &output],
            &["bench", "--scene", "sphere", "--against", &json, "--csv", &csv],
            &["bake", &a, "--kind", "height", "-o", &output],
            &["bake", "--normal", &a, "--kind", "normal", "-o", &output],
            &["fit", &csv, "-o", &json],
            &["capture", "--quiet", "--scene", "plane", "--bare", "--size", "8x8", "--height-map", &a, "-o", &output],
        ] {
            if arguments[0] == "capture" && !gpu {
                continue;
            }
            let line = one_line_error(&leadr(arguments).output().unwrap(), 2, &format!("{arguments:?}"));
            assert!(line.contains("is also an input"), "{line}");
        }
    }
    assert_eq!(fs::read(at("a.png")).unwrap(), before);
    assert_eq!(names(folder.path()), ["a.png", "b.png", "gold.csv", "gold.json", "hard.png", "sub"]);
}

#[test]
fn the_picture_of_a_page_replaces_no_other_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| path(&folder.path().join(name)).to_owned();
    fs::write(at("gold.csv"), "theta,r,g,b\n0,1,1,1\n30,0.5,0.5,0.5\n60,0.2,0.2,0.2\n").unwrap();
    fs::write(at("a.png"), "mine").unwrap();
    let fit = |flags: &[&str]| leadr(&[&["fit", &at("gold.csv"), "--lobes", "1"], flags].concat()).output().unwrap();
    let line = one_line_error(&fit(&["--page", &at("a.html")]), 2, "a page");
    assert!(line.contains("a.png") && line.contains("--picture"), "{line}");
    assert_eq!(fs::read_to_string(at("a.png")).unwrap(), "mine");
    let line = one_line_error(&fit(&["--page", &at("a.html"), "--picture", &at("sub/b.png")]), 2, "another folder");
    assert!(line.contains("folder of the page"), "{line}");
    // The same command can be repeated, and links spell out hostile names.
    for _ in 0..2 {
        let output = fit(&["--page", &at("javascript:x#y?.html")]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let page = fs::read_to_string(at("javascript:x#y?.html")).unwrap();
    assert!(page.contains("<a href=\"javascript%3Ax%23y%3F.png\">"), "{page}");
    assert_eq!(names(folder.path()), ["a.png", "gold.csv", "javascript:x#y?.html", "javascript:x#y?.png"]);
}

#[test]
fn failed_calls_leave_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| path(&folder.path().join(name)).to_owned();
    for arguments in [
        &["bake", "missing.png", "-o", &at("out/a.ktx2")][..],
        &["bake", "missing.png", "--kind", "leadr,height", "-o", &at("out/")],
        &["fit", "missing.binary", "-o", &at("out/a.json")],
        &["compare", "missing.png", "missing.png", "--error-image", &at("out/a.png")],
        &["capture", "--environment", "missing.hdr", "-o", &at("out/a.png")],
        &["capture", "--environment", "missing.hdr", "--frames", "0..2", "-o", &at("out/a.webp")],
    ] {
        one_line_error(&leadr(arguments).output().unwrap(), 1, &format!("{arguments:?}"));
        assert_eq!(names(folder.path()), [""; 0], "{arguments:?}");
    }
}

/// Starts a capture of many frames into `target`, sends the signal once `is_ready`, and returns its output.
fn stopped(signal: &str, target: &Path, is_ready: impl Fn() -> bool) -> Output {
    let scene = ["capture", "--scene", "plane", "--bare", "--size", "64x36", "--samples", "1", "--frames", "0..100000"];
    let mut child = leadr(&[&scene[..], &["-o", path(target)]].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !is_ready() {
        assert!(child.try_wait().unwrap().is_none() && start.elapsed().as_secs() < 300, "{target:?} is not drawn");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

#[test]
fn a_stopped_sequence_keeps_complete_frames() {
    let Some(_) = test_gpu() else { return };
    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("out/{frame}.png");
        let output = stopped(signal, &target, || folder.path().join("out/0001.png").exists());
        let log = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{log}");
        let files = names(&folder.path().join("out"));
        assert!(files.len() >= 2 && files.iter().all(|name| name.ends_with(".png")), "{files:?}");
        for file in &files {
            assert_eq!(load_color(folder.path().join("out").join(file)).unwrap().width, 64, "{file}");
        }
        let last: usize = log.trim_end().rsplit_once("leadr: stopped after frame ").expect(&log).1.parse().unwrap();
        // The last frame may have been finished after the line was composed.
        assert!((last + 1..=last + 2).contains(&files.len()), "{log}: {files:?}");
        assert_eq!(names(folder.path()), ["out"]);
    }
}

#[test]
fn a_stopped_animation_is_removed() {
    let Some(_) = test_gpu() else { return };
    for name in ["a.webp", "a.y4m"] {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join(name);
        fs::write(&target, "what was there").unwrap();
        let grown = || {
            let parts = fs::read_dir(folder.path()).unwrap().map(Result::unwrap).filter(|e| e.path() != target);
            parts.filter_map(|e| e.metadata().ok()).any(|part| part.len() > 20_000)
        };
        let output = stopped("-INT", &target, grown);
        let log = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(130), "{log}");
        assert!(
            log.contains("leadr: stopped after frame ") && log.contains(&format!("{name} is not written")),
            "{log}"
        );
        assert_eq!(fs::read_to_string(&target).unwrap(), "what was there");
        assert_eq!(names(folder.path()), [name]);
    }
}

#[test]
fn a_stopped_video_on_stdout_ends_with_a_whole_frame() {
    let Some(_) = test_gpu() else { return };
    let scene = ["capture", "--scene", "plane", "--bare", "--size", "64x36", "--samples", "1", "--frames", "0..100000"];
    let mut child = leadr(&[&scene[..], &["-o", "-", "--quiet"]].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut video = vec![0; 50_000];
    let mut stdout = child.stdout.take().unwrap();
    std::io::Read::read_exact(&mut stdout, &mut video).unwrap();
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    std::io::Read::read_to_end(&mut stdout, &mut video).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(143));
    let frames = video.len() - (video.iter().position(|&byte| byte == b'\n').unwrap() + 1);
    assert_eq!(frames % (6 + 3 * 64 * 36), 0, "{frames} bytes of frames");
}
