//! Converts a sea to the form that the renderer uses.

use super::cascades::divide;
use super::spectrum::Sea;
use crate::stage::{Stage, Views};
use glam::Vec3;
use leadr_reflectance::facets::normal_distribution::normal_quantile;
use leadr_render::camera::Camera;
use leadr_render::surfaces::ocean::Ocean;
use leadr_render::surfaces::ocean::waves::foam_weight;

/// The default number of samples along the edge of a tile.
pub const RESOLUTION: u32 = 256;

/// The linear albedo below the horizon of a [`Sky`](leadr_render::light::sky::Sky) over a sea, where reflected rays would hit other waves.
/// The value estimates the reflection of the low sky at a few degrees, plus light scattered in the water.
pub const BELOW_THE_HORIZON: [f32; 3] = [0.07, 0.09, 0.11];

/// Builds the waves of `sea` on tiles of `resolution²` samples. Finer waves become roughness.
pub fn ocean(sea: &Sea, resolution: u32, seed: u64) -> Ocean {
    let divided = divide(sea, resolution, seed);
    let tail = sea.moments(divided.cut, f64::INFINITY);
    // The horizontal stretch has a normal distribution, whose variance is the variance of the slopes.
    let stretch: f64 =
        divided.cascades.iter().map(|c| (foam_weight(c.size) * c.deviations()[1]).powi(2)).sum::<f64>().sqrt();
    let foam_threshold = (1.0 + stretch * normal_quantile(whitecaps(sea.wind_speed))).max(0.05) as f32;
    let [xx, yy, xy] = tail.slopes.map(|v| v as f32);
    Ocean {
        height: sea.moments(0.0, divided.cut).height.sqrt() as f32,
        cascades: divided.cascades,
        tail: Vec3::new(xx, yy, xy),
        choppiness: 1.0,
        level: 0.0,
        color: Vec3::new(0.004, 0.022, 0.03),
        foam: Vec3::splat(0.6),
        foam_threshold,
        shore: None,
    }
}

/// Returns the fraction of the sea covered by whitecaps at a wind speed in m/s (Monahan and O'Muircheartaigh 1980): 0.5 % at 8 m/s.
fn whitecaps(wind_speed: f64) -> f64 {
    (3.84e-6 * wind_speed.powf(3.41)).clamp(1e-9, 0.5)
}

/// Builds the open sea. The views look toward the default sun from a boat, from 100 m, and from 1 km.
pub fn stage(ocean: Ocean) -> Stage {
    let from = |height: f32, down: f32| {
        let eye = Vec3::Z * height;
        let (sin, cos) = (-0.7f32).sin_cos();
        Camera::looking_at(eye, eye + Vec3::new(cos, sin, -down).normalize() * height, 45.0)
    };
    let views = Views { near: from(2.5, 0.1), mid: from(100.0, 0.25), far: from(1000.0, 0.35) };
    let mut stage = Stage::still(Vec::new(), views).with_ocean(ocean);
    stage.below_horizon = BELOW_THE_HORIZON;
    stage
}
