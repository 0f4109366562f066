//! A camera written as JSON: `{"position": [x, y, z], "target": [x, y, z], "up": [0, 0, 1], "fov_degrees": 40}`.
//!
//! Metres, z up; `up` and `fov_degrees` may be left out. The file is untrusted.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::error::AppError;
use crate::render::camera::Camera;

/// A file longer than this is no camera.
const MAX_BYTES: u64 = 64 * 1024;
/// Coordinates beyond this lose millimetres in 32-bit floats.
const MAX_METRES: f32 = 100_000.0;

/// A perspective camera that looks at a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraPose {
    /// The eye, metres.
    pub position: [f32; 3],
    /// The point in the middle of the picture, metres; apart from `position`.
    pub target: [f32; 3],
    /// A direction that points up in the picture; not along the view.
    #[serde(default = "z_up")]
    pub up: [f32; 3],
    /// Vertical field of view, degrees, 1 to 170.
    #[serde(default = "default_fov")]
    pub fov_degrees: f32,
}

fn z_up() -> [f32; 3] {
    [0.0, 0.0, 1.0]
}

fn default_fov() -> f32 {
    35.0
}

impl CameraPose {
    /// Reads and checks a camera file.
    ///
    /// # Errors
    /// If the file cannot be read, is too long, is not the JSON described above, or describes no camera.
    pub fn read(path: &Path) -> Result<Self, AppError> {
        let mut text = String::new();
        let file = File::open(path).map_err(|e| AppError::io("read", path, e))?;
        file.take(MAX_BYTES + 1).read_to_string(&mut text).map_err(|e| AppError::io("read", path, e))?;
        if text.len() as u64 > MAX_BYTES {
            return Err(AppError::io("read", path, format!("a camera file has at most {MAX_BYTES} bytes")));
        }
        Self::parse(&text).map_err(|fault| AppError::io("read the camera", path, fault))
    }

    fn parse(text: &str) -> Result<Self, String> {
        let pose: Self = serde_json::from_str(text).map_err(|e| e.to_string())?;
        let (position, target, up) =
            (Vec3::from_array(pose.position), Vec3::from_array(pose.target), Vec3::from_array(pose.up));
        let sane = |v: Vec3| v.is_finite() && v.abs().max_element() <= MAX_METRES;
        if !sane(position) || !sane(target) || !sane(up) {
            return Err(format!("coordinates must be finite and within {MAX_METRES} metres of the origin"));
        }
        let view = (target - position).try_normalize().ok_or("position and target are the same point")?;
        let up = up.try_normalize().ok_or("up has no direction")?;
        if view.cross(up).length() < 1e-3 {
            return Err("up must not point along the view".to_owned());
        }
        if !(1.0..=170.0).contains(&pose.fov_degrees) {
            return Err(format!("fov_degrees is {}, but must be 1 to 170", pose.fov_degrees));
        }
        Ok(pose)
    }

    /// The pose of a renderer's camera.
    #[must_use]
    pub fn of(camera: &Camera) -> Self {
        Self {
            position: camera.position.to_array(),
            target: camera.target.to_array(),
            up: camera.up.to_array(),
            fov_degrees: camera.fov_y.to_degrees(),
        }
    }

    /// The renderer's camera for this pose.
    #[must_use]
    pub fn camera(&self) -> Camera {
        let (position, target) = (Vec3::from_array(self.position), Vec3::from_array(self.target));
        Camera { up: Vec3::from_array(self.up), ..Camera::looking_at(position, target, self.fov_degrees) }
    }

    /// The same view from `metres` away from the target.
    #[must_use]
    pub fn at_distance(self, metres: f32) -> Self {
        let target = Vec3::from_array(self.target);
        let away = (Vec3::from_array(self.position) - target).normalize_or_zero();
        Self { position: (target + away * metres).to_array(), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_and_distance() {
        let pose = CameraPose::parse(r#"{"position": [0, -10, 3], "target": [0, 0, 3]}"#).unwrap();
        assert_eq!((pose.up, pose.fov_degrees), (z_up(), default_fov()));
        assert_eq!(pose.at_distance(4.0).position, [0.0, -4.0, 3.0]);
        let camera = CameraPose { up: [0.0, 1.0, 1.0], ..pose }.camera();
        assert_eq!((camera.position.y, camera.target.z, camera.up.y), (-10.0, 3.0, 1.0));
        assert!((camera.fov_y - default_fov().to_radians()).abs() < 1e-6);
        let again = CameraPose::of(&camera);
        assert_eq!((again.position, again.target, again.up), (pose.position, pose.target, [0.0, 1.0, 1.0]));
        assert!((again.fov_degrees - default_fov()).abs() < 1e-4);
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
            let fault = CameraPose::parse(text).expect_err(text);
            assert!(fault.contains(reason), "{text}: {fault}");
        }
    }
}
