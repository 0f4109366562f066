//! A device lost while a sequence is drawn: exit code 1, one line, and only complete files.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::cli::{leadr, one_line_error, path};
use leadr_testing::gpu::test_gpu;

const FRAMES: usize = 6;

/// Draws a sequence into `target`, on a device that is lost at submission `number`.
fn capture(target: &Path, number: u32) -> Output {
    let flags = ["capture", "--quiet", "--scene", "ocean", "--size", "16x16", "--samples", "1", "--frames", "0..6"];
    let mut command = leadr(&[&flags[..], &["-o", path(target)]].concat());
    command.env("LEADR_FAIL", format!("submission:{number}")).output().expect("the program starts")
}

/// The number of frames in a folder; all must be complete pictures.
fn whole_frames(folder: &Path) -> usize {
    let files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    for file in &files {
        let picture = leadr::maps::load_color(file).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((picture.width, picture.height), (16, 16), "{}", file.display());
    }
    files.len()
}

#[test]
#[ignore = "long"]
fn lost_device_leaves_complete_frames_and_one_line() {
    let Some(_) = test_gpu() else { return };
    // The number of submissions before the first frame is unspecified, so bisection finds the middle.
    let (mut early, mut late) = (0, 64);
    let number = loop {
        let number = early + (late - early) / 2;
        assert!(number > early, "no submission is in the middle of the sequence");
        let folder = tempfile::tempdir().unwrap();
        let output = capture(&folder.path().join("{frame}.png"), number);
        let frames = whole_frames(folder.path());
        if frames == FRAMES {
            late = number;
            continue;
        }
        let line = one_line_error(&output, 1, "lost");
        assert!(line.contains("device was lost: restart"), "{line}");
        if frames > 0 {
            break number;
        }
        early = number;
    };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("moving.webp");
    fs::write(&file, "what was there").unwrap();
    one_line_error(&capture(&file, number), 1, "moving.webp");
    assert_eq!(fs::read(&file).unwrap(), b"what was there");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "something is left beside it");
}
