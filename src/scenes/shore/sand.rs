//! Sand as height and colour maps: a strip across the beach, from the dry sand to below the water, and the dry sand
//! alone, which repeats.
//!
//! Places are metres: `s` from the waterline toward the sea, `y` along it.

use rayon::prelude::*;

use crate::maps::cache::remembered;
use crate::maps::material::alpha_code;
use crate::maps::noise::{features, fractal, gradient, unit};
use crate::maps::srgb::srgb8_from_linear;

/// Linear albedo of wet sand, and of the sea floor.
pub const WET: [f32; 3] = [0.185, 0.148, 0.104];
/// Linear albedo of dry sand.
const DRY: [f32; 3] = [0.47, 0.39, 0.28];
/// Where the strip begins and ends.
pub const STRIP: [f32; 2] = [-28.0, 12.0];
/// Metres of coast after which the strip repeats.
pub const STRIP_REPEAT: f32 = 20.0;
/// Edge of the square of dry sand, metres: eight of its slow waves, so that pieces of it fit together (`render::scene::Tiling`), and a whole
/// number of ripples.
pub const DRY_REPEAT: f32 = 20.0;
/// Metres along the coast after which the sand, bends included, repeats.
pub const PERIOD: f64 = 40.0;
/// Texels across and along the strip, and along an edge of the dry sand: 2 cm apart.
const STRIP_TEXELS: [u32; 2] = [2048, 1024];
const DRY_TEXELS: u32 = 1024;

/// Heights in metres and sRGB-encoded colours (a: Beckmann roughness, linear), row by row; rows run toward the sea.
pub struct Sand {
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Metres.
    pub heights: Vec<f32>,
    /// Colours.
    pub colors: Vec<[u8; 4]>,
}

/// How wet the sand is: 0 dry, 1 swept by the swash.
fn wetness(s: f32, y: f32) -> f32 {
    let ragged = 0.45 * fractal(11, 50.0 + s * 0.2, y * 0.2, 4, 4, 0.55);
    smooth(-3.9, -2.9, s + ragged)
}

fn smooth(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Relief of dry sand: wind ripples in patches, old tracks, slow waves. `period`: metres after which it repeats along y.
fn dry_relief(s: f32, y: f32, period: i32) -> f32 {
    let slow = 0.035 * fractal(3, s * 0.4 + 40.0, y * 0.4, period * 2 / 5, 3, 0.5);
    // Ripples lie along the coast and fork where the bend of their phase is steep.
    let bend =
        2.2 * gradient(5, s * 0.5 + 60.0, y * 0.5, period / 2) + 0.7 * gradient(6, s * 1.5, y * 1.5, period * 3 / 2);
    let phase = std::f32::consts::TAU * (s / 0.16 + bend);
    let patch = smooth(-0.25, 0.35, gradient(7, s * 0.3 + 70.0, y * 0.3, period * 3 / 10));
    let ripples = 0.006 * (phase.sin() + 0.3 * (2.0 * phase + 0.8).sin()) * (0.25 + 0.75 * patch);
    let mut tracks = 0.0;
    features(8, s * 1.2 + 80.0, y * 1.2, period * 6 / 5, 1, |f| {
        let size = 0.16 + 0.14 * unit(f.id ^ 0x51);
        let d = (f.offset[0] * f.offset[0] + 0.6 * f.offset[1] * f.offset[1]) / (size * size);
        // A dent with a rim.
        tracks -= 0.022 * unit(f.id ^ 0x77) * (1.0 - 0.7 * d) * (-d).exp();
    });
    slow + ripples + tracks + 0.0022 * fractal(9, s * 12.0, y * 12.0, period * 12, 2, 0.6)
}

/// Relief of sand that the water has smoothed: rills, and a few shells.
fn wet_relief(s: f32, y: f32, period: i32) -> f32 {
    let rills = 0.0035
        * gradient(21, s * 0.8 + 30.0, y * 5.0, period * 5)
        * smooth(-0.2, 0.4, gradient(22, s * 0.4 + 30.0, y * 0.4, period * 2 / 5));
    rills
        + 0.008 * fractal(23, s * 0.6 + 35.0, y * 0.6, period * 3 / 5, 2, 0.5)
        + 0.0005 * gradient(24, s * 20.0, y * 20.0, period * 20)
}

/// What the highest waves left behind: 0 nothing, 1 weed.
fn wrack(s: f32, y: f32) -> f32 {
    let line = -4.1 + 0.5 * fractal(31, 5.0, y * 0.2, 4, 3, 0.5);
    let near = (-((s - line) / 0.22).powi(2)).exp();
    let tufts = smooth(0.15, 0.55, fractal(32, s * 6.0 + 50.0, y * 6.0, 120, 2, 0.6))
        * smooth(-0.3, 0.3, gradient(33, s, y * 0.5, 10));
    near * tufts
}

fn color(s: f32, y: f32, relief: f32, wet: f32, period: i32) -> [u8; 4] {
    let damp = smooth(-6.0, -3.6, s + 0.8 * fractal(12, s * 0.3 + 40.0, y * 0.3, period * 3 / 10, 3, 0.5));
    let grain = 1.0
        + 0.05 * gradient(41, s * 23.0, y * 23.0, period * 23)
        + 0.06 * fractal(42, s * 0.9 + 30.0, y * 0.9, period * 9 / 10, 3, 0.5);
    // Hollows are darker, and hold the water longer.
    let dry = grain * (1.0 + 4.0 * relief.clamp(-0.03, 0.03)) * (1.0 - 0.25 * damp);
    let weed = wrack(s, y);
    let channel = |i: usize| {
        let sand = DRY[i] * dry * (1.0 - wet) + WET[i] * wet;
        let value = sand + ([0.045, 0.038, 0.022][i] - sand) * 0.6 * weed;
        srgb8_from_linear(value)
    };
    let roughness = 0.6 + (0.12 - 0.6) * wet - 0.12 * damp * (1.0 - wet) + 0.3 * weed;
    [channel(0), channel(1), channel(2), alpha_code(roughness.max(0.05))]
}

fn map(kind: &str, [width, height]: [u32; 2], texel: impl Fn(f32, f32) -> (f32, [u8; 4]) + Sync) -> Sand {
    let programs = [include_str!("sand.rs"), include_str!("../../maps/noise.rs")];
    let at = |i: u32| {
        let (height, color) =
            texel(((i % width) as f32 + 0.5) / width as f32, ((i / width) as f32 + 0.5) / height as f32);
        [height.to_bits(), u32::from_ne_bytes(color)]
    };
    let count = width * height;
    let texels = remembered(kind, &programs, count as usize, || (0..count).into_par_iter().map(at).collect());
    let (heights, colors) = texels.iter().map(|&[h, color]| (f32::from_bits(h), color.to_ne_bytes())).unzip();
    Sand { width, height, heights, colors }
}

/// The strip across the beach.
#[must_use]
pub fn strip() -> Sand {
    let period = STRIP_REPEAT as i32;
    let relief = |s: f32, y: f32| {
        let wet = wetness(s, y);
        let weed = 0.025 * wrack(s, y);
        (dry_relief(s, y, period) * (1.0 - wet) + wet_relief(s, y, period) * wet + weed, wet)
    };
    map("sand-strip", STRIP_TEXELS, |u, v| {
        let (s, y) = (STRIP[0] + u * (STRIP[1] - STRIP[0]), v * STRIP_REPEAT);
        let (height, wet) = relief(s, y);
        (height, color(s, y, height, wet, period))
    })
}

/// Dry sand that repeats both ways.
#[must_use]
pub fn dry() -> Sand {
    let period = DRY_REPEAT as i32;
    map("sand", [DRY_TEXELS; 2], |u, v| {
        // Far enough from the water that nothing here depends on it.
        let (s, y) = (u * DRY_REPEAT, v * DRY_REPEAT);
        let relief = dry_relief(s, y, period);
        (relief, color(s - 100.0, y, relief, 0.0, period))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strip_repeats_along_the_coast_and_dries_inland() {
        for (s, y) in [(-20.0, 0.3), (-5.0, 7.7), (-1.0, 19.0), (6.0, 11.2)] {
            let at = |y: f32| (dry_relief(s, y, 20), wet_relief(s, y, 20), wetness(s, y), wrack(s, y));
            let (a, b) = (at(y), at(y + STRIP_REPEAT));
            assert!((a.0 - b.0).abs() < 1e-3 && (a.1 - b.1).abs() < 1e-3, "{s} {y}: {a:?} {b:?}");
            assert!((a.2 - b.2).abs() < 1e-3 && (a.3 - b.3).abs() < 1e-3, "{s} {y}: {a:?} {b:?}");
        }
        for y in 0..20 {
            assert_eq!((wetness(-6.0, y as f32), wetness(-1.0, y as f32)), (0.0, 1.0));
        }
    }

    #[test]
    fn wet_sand_is_as_dark_as_the_sea_floor_and_smoother_than_dry() {
        let strip = strip();
        let column = |s: f32| ((s - STRIP[0]) / (STRIP[1] - STRIP[0]) * strip.width as f32) as u32;
        let texels = |s: f32| (0..strip.height).map(move |row| (row * strip.width + column(s)) as usize);
        let bed = WET.map(srgb8_from_linear);
        assert!(texels(0.0).all(|i| strip.colors[i][..3] == bed));
        let rough = |s: f32| texels(s).map(|i| (strip.heights[i + 1] - strip.heights[i]).powi(2)).sum::<f32>();
        assert!(rough(1.0) < 0.05 * rough(-10.0), "{} {}", rough(1.0), rough(-10.0));
    }
}
