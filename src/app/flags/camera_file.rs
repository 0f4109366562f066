//! A camera written as JSON: `{"position": [x, y, z], "target": [x, y, z], "up": [0, 0, 1], "fov_degrees": 40}`.
//!
//! Metres, z up; `up` and `fov_degrees` may be left out. The file is untrusted.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::app::error::AppError;
use crate::scenes::view::CameraPose;

/// A file longer than this is no camera.
const MAX_BYTES: u64 = 64 * 1024;

/// Reads and checks a camera file.
///
/// # Errors
/// If the file cannot be read, is too long, is not the JSON described above, or describes no camera.
pub fn read(path: &Path) -> Result<CameraPose, AppError> {
    let mut text = String::new();
    let file = File::open(path).map_err(|e| AppError::io("read", path, e))?;
    file.take(MAX_BYTES + 1).read_to_string(&mut text).map_err(|e| AppError::io("read", path, e))?;
    if text.len() as u64 > MAX_BYTES {
        return Err(AppError::io("read", path, format!("a camera file has at most {MAX_BYTES} bytes")));
    }
    parse(&text).map_err(|fault| AppError::io("read the camera", path, fault))
}

fn parse(text: &str) -> Result<CameraPose, String> {
    let pose: CameraPose = serde_json::from_str(text).map_err(|e| e.to_string())?;
    pose.check().map(|()| pose)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_and_field_of_view_may_be_left_out() {
        let pose = parse(r#"{"position": [0, -10, 3], "target": [0, 0, 3]}"#).unwrap();
        assert_eq!((pose.up, pose.fov_degrees), ([0.0, 0.0, 1.0], 35.0));
    }

    #[test]
    fn what_is_no_camera_is_refused_with_its_reason() {
        let cases = [
            ("", "EOF"),
            ("[]", "invalid"),
            (r#"{"position": [0, 0, 0]}"#, "target"),
            (r#"{"position": [0, 0], "target": [0, 0, 3]}"#, "length"),
            (r#"{"position": [0, 0, 3], "target": [0, 0, 3]}"#, "same point"),
            (r#"{"position": [0, 0, 9], "target": [0, 0, 3]}"#, "up must not"),
            (r#"{"position": [1, 0, 9], "target": [0, 0, 3], "up": [0, 0, 0]}"#, "no direction"),
            (r#"{"position": [1e39, 0, 9], "target": [0, 0, 3]}"#, ""),
            (r#"{"position": [1e9, 0, 9], "target": [0, 0, 3]}"#, "within"),
            (r#"{"position": [1, 0, 9], "target": [0, 0, 3], "fov_degrees": 0}"#, "1 to 170"),
            (r#"{"position": [1, 0, 9], "target": [0, 0, 3], "fov": 40}"#, "unknown field"),
        ];
        for (text, reason) in cases {
            let fault = parse(text).expect_err(text);
            assert!(fault.contains(reason), "{text}: {fault}");
        }
    }
}
