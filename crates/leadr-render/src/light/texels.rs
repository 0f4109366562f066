//! The texels of an equirectangular panorama. Rows run from +z to −z, and columns run clockwise seen from above.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec3};

use leadr_maps::RgbImage;
use leadr_reflectance::color::luminance;

/// Returns the luminance of a texel.
pub fn texel_luminance(texel: [f32; 3]) -> f64 {
    luminance(Vec3::from(texel).as_dvec3())
}

/// The texels of an equirectangular image on the sphere.
pub struct Texels {
    /// The solid angle of a texel in each row.
    pub solid_angles: Vec<f64>,
    /// The sine and cosine of the angle from +z, for each row.
    rows: Vec<(f64, f64)>,
    /// The direction in the horizontal plane, for each column.
    columns: Vec<DVec2>,
}

impl Texels {
    /// Computes the texels of an image of this size.
    pub fn new(image: &RgbImage) -> Self {
        let (width, height) = (image.width as usize, image.height as usize);
        let edge = |row: usize| (PI * row as f64 / height as f64).cos();
        Self {
            solid_angles: (0..height).map(|j| 2.0 * PI / width as f64 * (edge(j) - edge(j + 1))).collect(),
            rows: (0..height).map(|j| (PI * (j as f64 + 0.5) / height as f64).sin_cos()).collect(),
            columns: (0..width)
                .map(|i| DVec2::from_angle(2.0 * PI * (0.5 - (i as f64 + 0.5) / width as f64)))
                .collect(),
        }
    }

    /// Returns the unit direction of a texel's centre.
    pub fn direction(&self, row: usize, column: usize) -> DVec3 {
        let (sin, cos) = self.rows[row];
        (sin * self.columns[column]).extend(cos)
    }

    /// Whether a row may have texel centres within `reach` radians of a direction.
    pub fn row_meets(&self, row: usize, direction: DVec3, reach: f64) -> bool {
        let (sin, cos) = self.rows[row];
        (sin * direction.truncate().length() + cos * direction.z).min(1.0).acos() <= reach
    }

    /// Integrates the luminance over the sphere. A direction with height `z` is weighted by `weight(z)`.
    pub fn integral(&self, image: &RgbImage, weight: impl Fn(f64) -> f64) -> f64 {
        let rows = image.texels.chunks_exact(image.width as usize).zip(self.rows.iter().zip(&self.solid_angles));
        rows.map(|(texels, (&(_, z), solid_angle))| {
            weight(z) * solid_angle * texels.iter().map(|&t| texel_luminance(t)).sum::<f64>()
        })
        .sum()
    }
}
