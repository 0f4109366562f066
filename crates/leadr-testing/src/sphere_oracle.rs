//! Pictures of displaced spheres from another ray caster (`crates/leadr-testing/data/sphere_*.json`).

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::collections::BTreeMap;

use glam::DVec3;

use super::comparison::{number, oracle, rows};

/// The width and the height of the pictures, in pixels.
pub const SIZE: u32 = 128;
/// The radius of the sphere, as a fraction of half the width of the picture.
pub const RADIUS: f64 = 0.97;

/// Pictures of one sphere under several lights.
pub struct SphereOracle {
    /// The slope covariance `(σ_x², σ_y², c_xy)` of the sphere's surface.
    pub covariance: DVec3,
    pictures: BTreeMap<String, Picture>,
}

/// A picture of the sphere, which holds every other pixel of every other row.
pub struct Picture {
    /// The radiance of the pixel `(x, y)` at the index `y · SIZE + x`. Omitted pixels and pixels outside the sphere are NaN.
    pub radiance: Vec<f64>,
    /// The rms value of the pixels' standard errors.
    pub noise: f64,
}

impl SphereOracle {
    /// Loads the sphere of `crates/leadr-testing/data/sphere_<name>.json`.
    pub fn load(name: &str) -> Self {
        let data = oracle(&format!("sphere_{name}.json"));
        let (x, y) = (number(&data["sigma_x"]), number(&data["sigma_y"]));
        let pixels = rows(&data["pixels"]);
        let pictures = rows(&data["pictures"]).iter().zip(rows(&data["noise"])).enumerate();
        let pictures = pictures.map(|(k, (picture, noise))| {
            let mut radiance = vec![f64::NAN; (SIZE * SIZE) as usize];
            for pixel in pixels {
                let at = number(&pixel[1]) * f64::from(SIZE) + number(&pixel[0]);
                radiance[at as usize] = number(&pixel[2 + k]);
            }
            let name = picture.as_str().unwrap_or_else(|| panic!("{picture} is not a name"));
            (name.to_owned(), Picture { radiance, noise: number(noise) })
        });
        Self { covariance: DVec3::new(x * x, y * y, number(&data["c_xy"])), pictures: pictures.collect() }
    }

    /// Returns the picture called `<light>_<mask|shadow>`.
    pub fn picture(&self, name: &str) -> &Picture {
        &self.pictures[name]
    }
}

impl Picture {
    /// Returns the mean of all stored pixels, and their number.
    pub fn mean(&self) -> (f64, usize) {
        let seen: Vec<f64> = self.radiance.iter().copied().filter(|r| r.is_finite()).collect();
        (seen.iter().sum::<f64>() / seen.len() as f64, seen.len())
    }
}

/// Returns the direction of the side light in the pictures.
pub fn side_light() -> DVec3 {
    DVec3::new(0.6, 0.5, 0.62).normalize()
}

/// Evaluates the environment of the diffuse pictures. Its radiance is of order 2.
pub fn gradient(d: DVec3) -> f64 {
    1.0 + 0.3 * d.x + 0.5 * d.y + 0.2 * d.z + 0.2 * d.y * d.z + 0.15 * (d.x * d.x - d.y * d.y)
}

/// Evaluates the environment of the specular pictures.
pub fn lobes(d: DVec3) -> f64 {
    let lobe = |k: f64, towards: DVec3| (k * (d.dot(towards.normalize()) - 1.0)).exp();
    0.3 * gradient(d) + 2.0 * lobe(20.0, DVec3::new(0.5, 0.6, 0.6)) + 1.5 * lobe(60.0, DVec3::new(-0.7, 0.1, 0.3))
}
