//! The view of a scene and the size of its picture.

use std::fmt;
use std::str::FromStr;

use glam::Vec3;
use serde::{Serialize, Serializer};

use leadr_render::camera::Camera;

/// The size of a picture in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// The number of pixels across, at least 1.
    pub width: u32,
    /// The number of pixels down, at least 1.
    pub height: u32,
}

impl Size {
    /// The largest side of a picture in pixels. Every Vulkan 1.3 GPU (and lavapipe) can render it.
    pub const MAX_SIDE: u32 = 16_384;
    /// The largest number of pixels. Linear colours take 16 bytes per pixel.
    pub const MAX_PIXELS: u64 = 1 << 26;
}

/// The separators that are accepted in a size such as `800x600`.
pub const TIMES: [char; 3] = ['x', 'X', '×'];

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (width, height) = text.split_once(TIMES).ok_or("a size is WIDTHxHEIGHT in pixels, such as 1280x720")?;
        let side = |text: &str| {
            let side = text.parse().map_err(|_| format!("'{text}' is not a number of pixels"))?;
            if (1..=Self::MAX_SIDE).contains(&side) {
                Ok(side)
            } else {
                Err(format!("a side is 1 to {} pixels", Self::MAX_SIDE))
            }
        };
        let size = Self { width: side(width)?, height: side(height)? };
        if u64::from(size.width) * u64::from(size.height) > Self::MAX_PIXELS {
            let side = Self::MAX_PIXELS.isqrt();
            return Err(format!("a picture has at most as many pixels as {side}x{side}"));
        }
        Ok(size)
    }
}

impl Serialize for Size {
    /// Serialises the size as `[width, height]`.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        [self.width, self.height].serialize(serializer)
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// The camera view of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViewChoice {
    /// A view of the scene from close by.
    Near,
    /// A view in which the whole scene fills the picture.
    Mid,
    /// A view of the scene from far away.
    Far,
    /// A camera of the model's file.
    Model,
    /// A pose that the user gives.
    Pose(CameraPose),
}

/// A perspective camera that looks at a point. Coordinates are in metres, with z up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CameraPose {
    /// The position of the eye in metres.
    pub position: [f32; 3],
    /// The point at the centre of the picture in metres, which must differ from `position`.
    pub target: [f32; 3],
    /// The up direction of the picture, which must not be parallel to the view direction.
    pub up: [f32; 3],
    /// The vertical field of view in degrees, from 1 to 170.
    pub fov_degrees: f32,
}

impl CameraPose {
    /// The largest coordinate in metres. Larger 32-bit coordinates lose millimetres.
    pub const MAX_METRES: f32 = 100_000.0;
    /// The default vertical field of view in degrees.
    pub const FOV_DEGREES: f32 = 35.0;

    /// Returns the default up direction, which is +z, or +y for views along z, as on a map.
    pub fn usual_up(position: [f32; 3], target: [f32; 3]) -> [f32; 3] {
        let view = (Vec3::from_array(target) - Vec3::from_array(position)).normalize_or_zero();
        if view.cross(Vec3::Z).length() < Self::ALONG { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] }
    }

    /// The sine of the angle below which two directions count as parallel.
    const ALONG: f32 = 1e-3;

    /// Checks that the pose is a valid camera.
    ///
    /// # Errors
    /// Returns a sentence that gives the reason.
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
        if view.cross(up).length() < Self::ALONG {
            return Err("up must not point along the view".to_owned());
        }
        if !(1.0..=170.0).contains(&self.fov_degrees) {
            return Err(format!("fov_degrees is {}, but must be 1 to 170", self.fov_degrees));
        }
        Ok(())
    }

    /// Converts a camera of the renderer to a pose.
    pub fn of(camera: &Camera) -> Self {
        Self {
            position: camera.position.to_array(),
            target: camera.target.to_array(),
            up: camera.up.to_array(),
            fov_degrees: camera.fov_y.to_degrees(),
        }
    }

    /// Converts the pose to a camera of the renderer.
    pub fn camera(&self) -> Camera {
        let (position, target) = (Vec3::from_array(self.position), Vec3::from_array(self.target));
        Camera { up: Vec3::from_array(self.up), ..Camera::looking_at(position, target, self.fov_degrees) }
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
            fov_degrees: CameraPose::FOV_DEGREES,
        };
        let camera = pose.camera();
        assert_eq!((camera.position.y, camera.target.z, camera.up.y), (-10.0, 3.0, 1.0));
        assert!((camera.fov_y - CameraPose::FOV_DEGREES.to_radians()).abs() < 1e-6);
        let again = CameraPose::of(&camera);
        assert_eq!((again.position, again.target, again.up), (pose.position, pose.target, [0.0, 1.0, 1.0]));
        assert!((again.fov_degrees - CameraPose::FOV_DEGREES).abs() < 1e-4);
    }
}
