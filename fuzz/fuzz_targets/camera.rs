//! The JSON of a camera.
#![no_main]

use leadr::scenes::view::CameraPose;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(pose) = serde_json::from_slice::<CameraPose>(bytes)
        && pose.check().is_ok()
    {
        let camera = pose.camera();
        assert!(camera.position.is_finite() && camera.target.is_finite());
    }
});
