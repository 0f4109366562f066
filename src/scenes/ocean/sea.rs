//! A sea as the renderer takes it.

use super::cascades::divide;
use super::spectrum::Sea;
use crate::render::camera::Camera;
use crate::render::ocean::surface::Ocean;
use crate::scenes::stage::{Stage, Views};
use glam::Vec3;

/// Samples along the edge of a tile, unless something else is asked for.
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

/// The open sea: from a boat, from a hundred metres, from a kilometre; toward the default sun. Tiles of `resolution²` samples.
#[must_use]
pub fn stage(sea: &Sea, resolution: u32) -> Stage {
    let from = |height: f32, down: f32| {
        let eye = Vec3::Z * height;
        let (sin, cos) = (-0.7f32).sin_cos();
        Camera::looking_at(eye, eye + Vec3::new(cos, sin, -down).normalize() * height, 45.0)
    };
    let views = Views { near: from(2.5, 0.1), mid: from(100.0, 0.25), far: from(1000.0, 0.35) };
    Stage::still(Vec::new(), views).with_ocean(ocean(sea, resolution, 1))
}
