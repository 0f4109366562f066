//! A sea as the renderer takes it.

use super::cascades::divide;
use super::spectrum::Sea;
use crate::render::ocean::surface::Ocean;
use glam::Vec3;

/// Samples along the edge of a tile.
pub const RESOLUTION: u32 = 256;

/// The waves of `sea` on tiles of `resolution²` samples; what is finer is roughness.
#[must_use]
pub fn ocean(sea: &Sea, resolution: u32, seed: u64) -> Ocean {
    let divided = divide(sea, resolution, seed);
    let tail = sea.moments(divided.cut, f64::INFINITY);
    let [xx, yy, xy] = tail.slopes.map(|v| v as f32);
    Ocean {
        height: sea.moments(0.0, divided.cut).height.sqrt() as f32,
        cascades: divided.cascades,
        tail: Vec3::new(xx, yy, xy),
        choppiness: 1.0,
        level: 0.0,
        color: Vec3::new(0.004, 0.022, 0.03),
        foam: Vec3::splat(0.6),
        foam_threshold: 0.35,
    }
}
