//! The light that a scene is seen in.

use std::path::PathBuf;

use glam::Vec3;
use serde::Serialize;

use super::studio::studio;
use crate::maps::{self, RgbImage};

/// Where light comes from besides the sun.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EnvironmentChoice {
    /// The analytic sky with its sun.
    Sky,
    /// A generated photographer's studio, without a sun.
    Studio,
    /// An equirectangular picture, `.hdr` or `.exr`.
    File(PathBuf),
}

impl EnvironmentChoice {
    /// Its equirectangular radiance; `None` for the analytic sky.
    ///
    /// # Errors
    /// A file that is missing, damaged, too large or of the wrong kind.
    pub fn load(&self) -> Result<Option<RgbImage>, maps::MapError> {
        Ok(match self {
            Self::Sky => None,
            Self::Studio => Some(studio()),
            Self::File(path) => Some(maps::load_environment(path)?),
        })
    }
}

/// Direction to the sun.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SunDirection {
    /// Degrees counter-clockwise from +x, seen from above.
    pub azimuth: f32,
    /// Degrees above the horizon, −90 to 90.
    pub elevation: f32,
}

impl SunDirection {
    /// The direction of a vector toward the sun.
    #[must_use]
    pub fn of(vector: Vec3) -> Self {
        let elevation = vector.z.atan2(vector.truncate().length()).to_degrees();
        Self { azimuth: vector.y.atan2(vector.x).to_degrees(), elevation }
    }

    /// Unit vector toward the sun; z up.
    #[must_use]
    pub fn vector(self) -> Vec3 {
        let (azimuth, elevation) = (self.azimuth.to_radians(), self.elevation.to_radians());
        Vec3::new(azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn azimuths_turn_from_x_to_y() {
        let west = SunDirection { azimuth: 180.0, elevation: 30.0 }.vector();
        assert!((west - Vec3::new(-0.75f32.sqrt(), 0.0, 0.5)).length() < 1e-6, "{west}");
        let sun = SunDirection { azimuth: -50.0, elevation: 38.0 };
        let again = SunDirection::of(sun.vector());
        assert!((again.azimuth - sun.azimuth).abs() < 1e-4 && (again.elevation - sun.elevation).abs() < 1e-4);
        assert!(SunDirection { azimuth: 90.0, elevation: 0.0 }.vector().distance(Vec3::Y) < 1e-6);
    }
}
