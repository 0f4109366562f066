//! The lighting of a scene.

use std::path::PathBuf;
use std::str::FromStr;

use glam::Vec3;
use serde::Serialize;

use super::studio::studio;
use super::text::similar;
use leadr_maps::RgbImage;
use leadr_render::settings::numbers::finite;

/// The environment light, in addition to the sun.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EnvironmentChoice {
    /// The analytic sky with its sun.
    Sky,
    /// A generated photo studio, without a sun.
    Studio,
    /// A panorama, cube or light probe in a `.hdr` or `.exr` file.
    File(PathBuf),
}

impl EnvironmentChoice {
    /// Loads the equirectangular radiance, rotated by `degrees` counter-clockwise when seen from above. `layer` is the name of the layer of
    /// an EXR file. Returns `None` for the analytic sky.
    ///
    /// # Errors
    /// If the file is missing, damaged, too large or of the wrong type, or has no such layer.
    pub fn load(&self, degrees: f32, layer: Option<&str>) -> Result<Option<RgbImage>, leadr_maps::MapError> {
        let picture = match self {
            Self::Sky => return Ok(None),
            Self::Studio => studio(),
            Self::File(path) => leadr_maps::load_environment_layer(path, layer)?,
        };
        Ok(Some(rotated(picture, degrees)))
    }
}

impl FromStr for EnvironmentChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.eq_ignore_ascii_case("sky") {
            return Ok(Self::Sky);
        }
        if text.eq_ignore_ascii_case("studio") {
            return Ok(Self::Studio);
        }
        let path = PathBuf::from(text);
        match path.extension().and_then(|extension| extension.to_str()) {
            Some(kind) if kind.eq_ignore_ascii_case("hdr") || kind.eq_ignore_ascii_case("exr") => Ok(Self::File(path)),
            _ => {
                let similar = similar(text, ["sky", "studio"]);
                Err(format!("no such environment{similar}; use 'sky', 'studio' or a .hdr or .exr file"))
            }
        }
    }
}

/// Rotates a panorama counter-clockwise when seen from above. The function shifts whole texels and interpolates the remaining fraction of a
/// texel, so every row keeps its power.
fn rotated(picture: RgbImage, degrees: f32) -> RgbImage {
    let width = picture.width as usize;
    // The azimuth decreases with the column.
    let columns = (f64::from(degrees) / 360.0).rem_euclid(1.0) * width as f64;
    let (whole, rest) = if (columns - columns.round()).abs() < 1e-4 {
        (columns.round() as usize % width, 0.0)
    } else {
        (columns as usize, columns.fract() as f32)
    };
    if whole == 0 && rest == 0.0 {
        return picture;
    }
    let row = |row: &[[f32; 3]]| -> Vec<[f32; 3]> {
        let from = |column: usize| row[(column + whole) % width];
        let between = |[a, b]: [[f32; 3]; 2]| std::array::from_fn(|c| a[c] + rest * (b[c] - a[c]));
        (0..width).map(|column| between([from(column), from(column + 1)])).collect()
    };
    let texels = picture.texels.chunks_exact(width).flat_map(row).collect();
    RgbImage { texels, ..picture }
}

/// The direction to the sun.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SunDirection {
    /// The azimuth in degrees, counter-clockwise from +x when seen from above.
    pub azimuth: f32,
    /// The elevation in degrees above the horizon, from −90 to 90.
    pub elevation: f32,
}

impl SunDirection {
    /// Returns the angles of a vector toward the sun.
    pub fn of(vector: Vec3) -> Self {
        let elevation = vector.z.atan2(vector.truncate().length()).to_degrees();
        Self { azimuth: vector.y.atan2(vector.x).to_degrees(), elevation }
    }

    /// Returns the unit vector toward the sun, with z up.
    #[must_use]
    pub fn vector(self) -> Vec3 {
        let (azimuth, elevation) = (self.azimuth.to_radians(), self.elevation.to_radians());
        Vec3::new(azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin())
    }
}

/// The direction to the sun by default.
pub const DEFAULT_SUN: SunDirection = SunDirection { azimuth: -50.0, elevation: 38.0 };

impl FromStr for SunDirection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (azimuth, elevation) = text.split_once(',').ok_or("the sun is AZIMUTH,ELEVATION in degrees")?;
        let sun = Self { azimuth: finite(azimuth)?, elevation: finite(elevation)? };
        if !(-90.0..=90.0).contains(&sun.elevation) {
            return Err("the sun's elevation is -90 to 90 degrees".to_owned());
        }
        if sun.azimuth.abs() > 360.0 {
            return Err("the sun's azimuth is -360 to 360 degrees".to_owned());
        }
        Ok(sun)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panoramas_rotate_counter_clockwise_and_keep_their_power() {
        // The columns run clockwise from -x, so the centre of the first of four columns is at 135 degrees.
        let texels = [1.0, 2.0, 4.0, 8.0, 3.0, 3.0, 3.0, 5.0].map(|v| [v, 0.0, 2.0 * v]).to_vec();
        let picture = RgbImage::new(4, 2, texels).unwrap();
        let red = |degrees| rotated(picture.clone(), degrees).texels.iter().map(|t| t[0]).collect::<Vec<_>>();
        assert_eq!(red(90.0), [2.0, 4.0, 8.0, 1.0, 3.0, 3.0, 5.0, 3.0]);
        assert_eq!(red(-90.0), red(270.0));
        assert_eq!((red(360.0), red(-0.0)), (red(0.0), red(0.0)));
        assert_eq!(red(45.0)[..4], [1.5, 3.0, 6.0, 4.5]);
        assert_eq!(red(33.0)[..4].iter().sum::<f32>(), 15.0);
    }

    #[test]
    fn azimuths_run_from_x_to_y() {
        let west = SunDirection { azimuth: 180.0, elevation: 30.0 }.vector();
        assert!((west - Vec3::new(-0.75f32.sqrt(), 0.0, 0.5)).length() < 1e-6, "{west}");
        let sun = SunDirection { azimuth: -50.0, elevation: 38.0 };
        let again = SunDirection::of(sun.vector());
        assert!((again.azimuth - sun.azimuth).abs() < 1e-4 && (again.elevation - sun.elevation).abs() < 1e-4);
        assert!(SunDirection { azimuth: 90.0, elevation: 0.0 }.vector().distance(Vec3::Y) < 1e-6);
    }
}
