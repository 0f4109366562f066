//! Tests that decoders can read the files with several frames.

use std::fs::{self, File};
use std::io::{BufReader, Cursor};
use std::path::Path;

use crate::app::capture::args::CaptureConfig;
use crate::app::capture::save::display;
use crate::app::capture::tests::{Double, configure, files, run, sized};

/// Returns the pictures of a capture as `R, G, B` codes.
fn expected(config: &CaptureConfig) -> Vec<Vec<u8>> {
    let mut double = Double::new(config);
    let picture =
        |moment| display(&double.render(moment, &mut |_| ()).unwrap(), &config.scene.picture).texels.into_flattened();
    config.timeline.moments().into_iter().map(picture).collect()
}

/// A decoded file with its size, its number of plays, and the delay in milliseconds and the `R, G, B` codes of each frame.
#[derive(Debug, PartialEq)]
struct Shown {
    size: (u32, u32),
    plays: u32,
    frames: Vec<(f64, Vec<u8>)>,
}

fn rgb_of(rgba: &[u8]) -> Vec<u8> {
    rgba.chunks(4).flat_map(|c| [c[0], c[1], c[2]]).collect()
}

fn read_webp(path: &Path) -> Shown {
    let mut decoder = image_webp::WebPDecoder::new(BufReader::new(File::open(path).unwrap())).unwrap();
    let size = decoder.dimensions();
    let plays = match decoder.loop_count() {
        image_webp::LoopCount::Forever => 0,
        image_webp::LoopCount::Times(times) => u32::from(times.get()),
    };
    let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
    let mut read = |_| {
        let delay = f64::from(decoder.read_frame(&mut pixels).unwrap());
        (delay, if decoder.has_alpha() { rgb_of(&pixels) } else { pixels.clone() })
    };
    let count = image_webp::WebPDecoder::new(Cursor::new(fs::read(path).unwrap())).unwrap().num_frames();
    Shown { size, plays, frames: (0..count).map(&mut read).collect() }
}

#[test]
fn moving_pictures_show_every_frame_for_its_time() {
    let folder = tempfile::tempdir().unwrap();
    for (fps, plays) in [("24", "0"), ("30", "1"), ("12.5", "3")] {
        let flags = ["--frames", "2..9", "--fps", fps, "--loop", plays];
        let config = configure(folder.path(), "a.webp", &flags);
        let report = run(&config, &mut Double::new(&config)).unwrap();
        assert_eq!(report["frames"].as_array().unwrap().len(), 7);
        assert_eq!(report["frames"][3]["file"], config.output.path(0).to_str().unwrap());
        let shown = read_webp(&config.output.path(0));
        assert_eq!((shown.size, shown.plays), ((5, 3), plays.parse().unwrap()));
        let (delays, pictures): (Vec<_>, Vec<_>) = shown.frames.into_iter().unzip();
        assert_eq!(pictures, expected(&config));
        let (sum, exact) = (delays.iter().sum::<f64>(), 7000.0 / fps.parse::<f64>().unwrap());
        assert!((sum - exact).abs() <= 0.5 + 1e-9, "{fps}: {delays:?}");
        assert!(delays.iter().all(|delay| (delay - exact / 7.0).abs() < 1.0), "{fps}: {delays:?}");
    }
    assert_eq!(files(folder.path()), ["a.webp"]);
}

#[test]
fn moving_pictures_are_the_same_bytes_for_the_same_call() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = ["a", "b"].map(|name| {
        let config = configure(folder.path(), &format!("{name}.webp"), &["--frames", "0..5"]);
        let config = CaptureConfig { scene: sized(&config, 40, 30), ..config };
        run(&config, &mut Double::new(&config)).unwrap();
        fs::read(config.output.path(0)).unwrap()
    });
    assert!(bytes[0] == bytes[1] && bytes[0].len() > 500);
}

#[test]
fn failed_animation_keeps_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let config = configure(folder.path(), "a.webp", &["--frames", "0..5"]);
    let failing = || Double { fail_at: Some(3), ..Double::new(&config) };
    let fault = run(&config, &mut failing()).unwrap_err().to_string();
    assert!(fault.contains("frame 3"), "{fault}");
    assert!(files(folder.path()).is_empty(), "{:?}", files(folder.path()));
    run(&config, &mut Double::new(&config)).unwrap();
    run(&config, &mut failing()).unwrap_err();
    assert_eq!(files(folder.path()), ["a.webp"]);
    assert_eq!(read_webp(&config.output.path(0)).frames.len(), 5);
}

#[test]
fn unwritable_folder_is_detected_before_drawing() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let config = configure(folder.path(), "file/a.webp", &["--frames", "0..5"]);
    let mut double = Double::new(&config);
    assert!(run(&config, &mut double).unwrap_err().to_string().contains("file"));
    assert_eq!(double.calls, 0);
}
