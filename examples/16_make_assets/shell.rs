//! The snail's shell, which is a tube on a conical spiral. The textures of the shell show bands along the whorls, and growth ribs across
//! the bands.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use crate::noise::{fractal, srgb, step};
use crate::skin::Surface;

/// The number of turns of the spiral, and the growth of the radius per turn.
const TURNS: f32 = 3.6;
const GROWTH: f32 = 2.3;
/// The distance from the axis to the middle of the last whorl, in metres.
const RADIUS: f32 = 0.0118;
/// The radius of the tube, relative to the distance from the axis.
const TUBE: f32 = 0.47;
/// Centre of the shell, and direction of its mouth: radians from +z towards −y.
const MIDDLE: Vec3 = Vec3::new(0.0, 0.0186, -0.005);
const MOUTH: f32 = 1.45;

/// End of the wall inside the mouth, as the parameter `u` of [`position`].
pub const INNER: f32 = 1.06;

/// A point of the shell: `u` from the tip (0) to the lip (1), and back along the inner wall ([`INNER`]); `v` around the tube.
pub fn position(u: f32, v: f32) -> Vec3 {
    // The lip is a rounded edge.
    let inside = ((u - 1.0) / (INNER - 1.0)).max(0.0);
    let wall = 1.0 - 0.13 * step(0.0, 0.5, inside);
    let u = u.min(1.0) + 0.003 * (PI * inside.min(0.5)).sin() - 0.022 * (inside - 0.5).max(0.0);
    let back = (1.0 - u) * TURNS;
    let radius = RADIUS * GROWTH.powf(-back);
    let angle = MOUTH + back * TAU;
    // The lip flares and the tip closes.
    let lip = (1.0 + 0.10 * step(0.965, 1.0, u)) * wall;
    let tube = TUBE * radius * lip * step(-0.02, 0.06, u) * (u / 0.01).clamp(0.0, 1.0).sqrt();
    let out = Vec3::new(0.0, -angle.sin(), angle.cos());
    // The whorls are shifted to the left, so that the tip protrudes.
    let centre = out * radius + Vec3::X * (0.95 * (RADIUS - radius) - 0.0028);
    let around = v * TAU + PI;
    MIDDLE + centre + tube * (out * around.cos() + 1.06 * Vec3::X * around.sin())
}

/// Returns the texture coordinates. The first coordinate is proportional to the angle of the spiral and repeats. The second coordinate runs
/// once around the tube.
pub fn uv(u: f32, v: f32) -> Vec2 {
    Vec2::new(u * TURNS, v)
}

/// Returns the appearance of the shell at texture coordinates.
pub fn surface(p: Vec2) -> Surface {
    let cells = |n: i32, m: i32, octaves, seed| fractal(p * Vec2::new(n as f32, m as f32), [n, m], octaves, 0.55, seed);
    // The ribs are uneven, with a few pauses in growth.
    let phase = p.x * 34.0 + 1.3 * (cells(9, 3, 3, 201) - 0.5) + 0.5 * (p.y * TAU).sin();
    let rib = 0.5 + 0.5 * (phase * TAU).cos();
    let rest = step(0.90, 0.98, (p.x * 3.0 + 0.12 * (cells(5, 4, 3, 202) - 0.5)).fract());
    let fine = cells(90, 40, 3, 203) - 0.5;
    let height = 0.10 * rib * rib + 0.05 * fine - 0.12 * rest;
    // There are three wavering dark bands on the outside.
    let across = p.y + 0.020 * (cells(6, 2, 3, 204) - 0.5);
    let band = |middle: f32, half: f32| 1.0 - step(half - 0.012, half + 0.012, (across - middle).abs());
    let dark =
        band(0.36, 0.032).max(band(0.50, 0.050)).max(band(0.645, 0.034)) * (0.72 + 0.45 * (cells(26, 6, 3, 205) - 0.3));
    let horn = srgb(222, 186, 126).lerp(srgb(198, 142, 84), step(0.3, 0.7, cells(7, 5, 4, 206)));
    let mut color = horn.lerp(srgb(88, 46, 26), 0.9 * dark.clamp(0.0, 1.0));
    color *= 0.84 + 0.22 * rib;
    color = color.lerp(srgb(96, 66, 42), 0.45 * rest);
    let worn = step(0.62, 0.78, cells(12, 9, 5, 207));
    color = color.lerp(srgb(232, 222, 200), 0.35 * worn);
    Surface { height, color, roughness: 0.30 + 0.14 * (1.0 - rib) + 0.28 * worn + 0.12 * rest }
}
