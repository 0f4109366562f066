//! The JSON of a camera, and the camera that it describes.
#![no_main]

use leadr_scenes::camera_file::parse;
use glam::Vec2;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(pose) = parse(bytes) {
        let camera = pose.camera();
        assert!(camera.position.is_finite() && camera.target.is_finite());
        assert!(camera.clip_from_world((64, 48), Vec2::ZERO).is_finite());
        assert!(camera.rays((64, 48), Vec2::ZERO).iter().all(|ray| ray.is_finite()));
    }
});
