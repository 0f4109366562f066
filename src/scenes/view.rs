//! Where a scene is seen from, and how large the picture is.

use std::fmt;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::render::camera::Camera;

/// Size of a picture in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Size {
    /// Pixels across, at least 1.
    pub width: u32,
    /// Pixels down, at least 1.
    pub height: u32,
}

impl Size {
    /// Longest side in pixels; every Vulkan 1.3 GPU (and lavapipe) can render to one.
    pub const MAX_SIDE: u32 = 16_384;
    /// Most pixels: the linear colours of a picture take 16 bytes each.
    pub const MAX_PIXELS: u64 = 1 << 26;
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// Where the scene is seen from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum View {
    /// The scene's close view.
    Near,
    /// The scene fills the picture.
    Mid,
    /// The scene is small.
    Far,
    /// From a camera of the model's file.
    Model,
    /// Given by the user.
    Pose(CameraPose),
}

/// A perspective camera that looks at a point; metres, z up.
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
    /// Beyond this, 32-bit coordinates lose millimetres.
    pub const MAX_METRES: f32 = 100_000.0;

    /// Whether it describes a camera.
    ///
    /// # Errors
    /// A sentence about what is wrong.
    pub fn check(&self) -> Result<(), String> {
        let most = Self::MAX_METRES;
        let (position, target, up) =
            (Vec3::from_array(self.position), Vec3::from_array(self.target), Vec3::from_array(self.up));
        let sane = |v: Vec3| v.is_finite() && v.abs().max_element() <= most;
        if !sane(position) || !sane(target) || !sane(up) {
            return Err(format!("coordinates must be finite and within {most} metres of the origin"));
        }
        let view = (target - position).try_normalize().ok_or("position and target are the same point")?;
        let up = up.try_normalize().ok_or("up has no direction")?;
        if view.cross(up).length() < 1e-3 {
            return Err("up must not point along the view".to_owned());
        }
        if !(1.0..=170.0).contains(&self.fov_degrees) {
            return Err(format!("fov_degrees is {}, but must be 1 to 170", self.fov_degrees));
        }
        Ok(())
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
    fn poses_and_cameras_are_the_same_thing() {
        let pose = CameraPose {
            position: [0.0, -10.0, 3.0],
            target: [0.0, 0.0, 3.0],
            up: [0.0, 1.0, 1.0],
            fov_degrees: default_fov(),
        };
        assert_eq!(pose.at_distance(4.0).position, [0.0, -4.0, 3.0]);
        let camera = pose.camera();
        assert_eq!((camera.position.y, camera.target.z, camera.up.y), (-10.0, 3.0, 1.0));
        assert!((camera.fov_y - default_fov().to_radians()).abs() < 1e-6);
        let again = CameraPose::of(&camera);
        assert_eq!((again.position, again.target, again.up), (pose.position, pose.target, [0.0, 1.0, 1.0]));
        assert!((again.fov_degrees - default_fov()).abs() < 1e-4);
    }
}
