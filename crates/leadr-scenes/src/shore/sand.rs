//! Height and colour maps of sand. One map is a strip along the water, from dry to wet sand. Two others are repeating squares of dry sand
//! and of wet sand.
//!
//! Positions are in metres. `s` is the distance from the waterline toward the sea, and `y` is the position along the waterline.

use rayon::prelude::*;

use crate::sphere::color_code;
use leadr_maps::cache::cached;
use leadr_maps::noise::{features, fractal, gradient, smoothstep, unit};

/// The linear albedo of wet sand and of the sea floor.
pub const WET: [f32; 3] = [0.185, 0.148, 0.104];
/// The linear albedo of dry sand.
const DRY: [f32; 3] = [0.47, 0.39, 0.28];
/// The positions `s` of the two joins: from dry sand to the strip, and from the strip to wet sand.
pub const JOINS: [f64; 2] = [-5.7, -1.9];
/// The overlap of the two pieces past each join, in metres.
pub const OVERLAPS: [f64; 2] = [0.9, 0.5];
/// The positions at which the strip starts on dry sand and ends on wet sand.
pub const STRIP: [f64; 2] = [JOINS[0] - OVERLAPS[0], JOINS[1] + OVERLAPS[1]];
/// The repeat of the whole shore (waterline bends, strip, dunes) along the coast, in metres.
pub const PERIOD: f64 = 200.0;
/// The edge of a sand square in metres. The edge is a whole number of ripples. Compared with the slow waves, the square is also large
/// enough for tiling by example (`render::scene::Tiling`).
pub const SQUARE: f32 = 20.0;
/// The numbers of texels across and along the strip, 2.5 cm apart, and along an edge of the squares, 2 and 4 cm apart.
const STRIP_TEXELS: [u32; 2] = [208, 8192];
const DRY_TEXELS: u32 = 1024;
const WET_TEXELS: u32 = 512;

/// Heights in metres and sRGB-encoded colours, in rows that run toward the sea. The alpha channel is the linear Beckmann roughness.
pub struct Sand {
    /// The number of texels per row.
    pub width: u32,
    /// The number of rows.
    pub height: u32,
    /// Heights in metres.
    pub heights: Vec<f32>,
    /// The colours of the texels.
    pub colors: Vec<[u8; 4]>,
}

/// Returns the wetness of the sand, from 0 (dry) to 1 (swept by waves).
fn wetness(s: f32, y: f32, period: i32) -> f32 {
    let ragged = 0.45 * fractal(11, 50.0 + s * 0.2, y * 0.2, period / 5, 4, 0.55);
    smoothstep(-3.9, -2.9, s + ragged)
}

/// Returns the relief of dry sand: patches of wind ripples, old tracks and slow waves. `period` is the repeat along y in metres.
fn dry_relief(s: f32, y: f32, period: i32) -> f32 {
    let slow = 0.035 * fractal(3, s * 0.4 + 40.0, y * 0.4, period * 2 / 5, 3, 0.5);
    // Ripples run along the coast and fork where their phase changes steeply.
    let bend =
        2.2 * gradient(5, s * 0.5 + 60.0, y * 0.5, period / 2) + 0.7 * gradient(6, s * 1.5, y * 1.5, period * 3 / 2);
    let phase = std::f32::consts::TAU * (s / 0.16 + bend);
    let patch = smoothstep(-0.25, 0.35, gradient(7, s * 0.3 + 70.0, y * 0.3, period * 3 / 10));
    let ripples = 0.006 * (phase.sin() + 0.3 * (2.0 * phase + 0.8).sin()) * (0.25 + 0.75 * patch);
    let mut tracks = 0.0;
    features(8, s * 1.2 + 80.0, y * 1.2, period * 6 / 5, 1, |[dx, dy], id| {
        let size = 0.16 + 0.14 * unit(id ^ 0x51);
        let d = (dx * dx + 0.6 * dy * dy) / (size * size);
        // A track is a dent with a rim.
        tracks -= 0.022 * unit(id ^ 0x77) * (1.0 - 0.7 * d) * (-d).exp();
    });
    slow + ripples + tracks + 0.0022 * fractal(9, s * 12.0, y * 12.0, period * 12, 2, 0.6)
}

/// Returns the relief of sand that water has smoothed, with rills and a few shells.
fn wet_relief(s: f32, y: f32, period: i32) -> f32 {
    let rills = 0.0035
        * gradient(21, s * 0.8 + 30.0, y * 5.0, period * 5)
        * smoothstep(-0.2, 0.4, gradient(22, s * 0.4 + 30.0, y * 0.4, period * 2 / 5));
    rills
        + 0.008 * fractal(23, s * 0.6 + 35.0, y * 0.6, period * 3 / 5, 2, 0.5)
        + 0.0005 * gradient(24, s * 20.0, y * 20.0, period * 20)
}

/// Returns the amount of weed on the wrack line, which the highest waves leave, from 0 to 1.
fn wrack(s: f32, y: f32, period: i32) -> f32 {
    let line = -4.1 + 0.5 * fractal(31, 5.0, y * 0.2, period / 5, 3, 0.5);
    let near = (-((s - line) / 0.22).powi(2)).exp();
    let tufts = smoothstep(0.15, 0.55, fractal(32, s * 6.0 + 50.0, y * 6.0, period * 6, 2, 0.6))
        * smoothstep(-0.3, 0.3, gradient(33, s, y * 0.5, period / 2));
    near * tufts
}

fn color(s: f32, y: f32, relief: f32, wet: f32, period: i32) -> [u8; 4] {
    let damp = smoothstep(-5.2, -3.4, s + 0.6 * fractal(12, s * 0.3 + 40.0, y * 0.3, period * 3 / 10, 3, 0.5));
    let grain = 1.0
        + 0.05 * gradient(41, s * 23.0, y * 23.0, period * 23)
        + 0.06 * fractal(42, s * 0.9 + 30.0, y * 0.9, period * 9 / 10, 3, 0.5);
    // Hollows are darker, and stay wet for longer.
    let dry = grain * (1.0 + 4.0 * relief.clamp(-0.03, 0.03)) * (1.0 - 0.25 * damp);
    let weed = wrack(s, y, period);
    let channel = |i: usize| {
        let sand = DRY[i] * dry * (1.0 - wet) + WET[i] * wet;
        sand + ([0.045, 0.038, 0.022][i] - sand) * 0.6 * weed
    };
    let roughness = 0.6 + (0.12 - 0.6) * wet - 0.12 * damp * (1.0 - wet) + 0.3 * weed;
    color_code([0, 1, 2].map(channel), roughness.max(0.05))
}

fn map(kind: &str, [width, height]: [u32; 2], texel: impl Fn(f32, f32) -> (f32, [u8; 4]) + Sync) -> Sand {
    let programs = [include_str!("sand.rs"), include_str!("../sphere.rs"), leadr_maps::noise::SOURCE];
    let at = |i: u32| {
        let (height, color) =
            texel(((i % width) as f32 + 0.5) / width as f32, ((i / width) as f32 + 0.5) / height as f32);
        [height.to_bits(), u32::from_ne_bytes(color)]
    };
    let count = width * height;
    let is_low = |texel: &[u32; 2]| f32::from_bits(texel[0]).abs() <= 1.0;
    let texels = cached(kind, &programs, count as usize, is_low, || (0..count).into_par_iter().map(at).collect());
    let (heights, colors) = texels.iter().map(|&[h, color]| (f32::from_bits(h), color.to_ne_bytes())).unzip();
    Sand { width, height, heights, colors }
}

/// Builds the strip along the water.
pub fn strip() -> Sand {
    let period = PERIOD as i32;
    map("sand-strip", STRIP_TEXELS, |u, v| {
        let [begin, end] = STRIP.map(|s| s as f32);
        let (s, y) = (begin + u * (end - begin), v * PERIOD as f32);
        let wet = wetness(s, y, period);
        let weed = 0.025 * wrack(s, y, period);
        let height = dry_relief(s, y, period) * (1.0 - wet) + wet_relief(s, y, period) * wet + weed;
        (height, color(s, y, height, wet, period))
    })
}

/// Builds dry sand that repeats in both directions.
pub fn dry() -> Sand {
    square("sand", DRY_TEXELS, dry_relief, 0.0, -100.0)
}

/// Builds wet sand that repeats in both directions.
pub fn wet() -> Sand {
    square("wet-sand", WET_TEXELS, wet_relief, 1.0, 100.0)
}

/// Builds a square of dry or wet sand. The sand is evaluated at the distance `away`, where the waterline has no influence.
fn square(kind: &str, texels: u32, relief: fn(f32, f32, i32) -> f32, wet: f32, away: f32) -> Sand {
    let period = SQUARE as i32;
    map(kind, [texels; 2], |u, v| {
        let (s, y) = (u * SQUARE, v * SQUARE);
        let height = relief(s, y, period);
        (height, color(s + away, y, height, wet, period))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::srgb::srgb8_from_linear;

    #[test]
    fn sand_repeats_and_dries_inland() {
        let at = |s: f32, y: f32, period: i32| {
            [dry_relief(s, y, period), wet_relief(s, y, period), wetness(s, y, period), wrack(s, y, period)]
        };
        let apart = |a: [f32; 4], b: [f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-3);
        for (s, y) in [(-6.2, 0.3), (-5.0, 7.7), (-4.0, 19.0), (-2.0, 11.2)] {
            for period in [SQUARE, PERIOD as f32] {
                let (here, there) = (at(s, y, period as i32), at(s, y + period, period as i32));
                assert!(apart(here, there), "{s} {y} {period}: {here:?} {there:?}");
            }
            let (strip, square) = (at(s, y, PERIOD as i32), at(s, y + SQUARE, PERIOD as i32));
            assert!(!apart(strip, square), "the strip does not repeat after {SQUARE} m");
        }
        for y in 0..200 {
            let wetness = |s: f64| wetness(s as f32, y as f32, PERIOD as i32);
            assert_eq!((wetness(STRIP[0] + 0.8), wetness(STRIP[1] - 0.5)), (0.0, 1.0), "{y}");
        }
    }

    /// Returns the autocorrelation of the strip at `lag` rows along the coast, without the component that is constant along the coast.
    fn repetition(strip: &Sand, lag: usize, of: &dyn Fn(usize) -> f32) -> f32 {
        let (width, height) = (strip.width as usize, strip.height as usize);
        let (mut product, mut square) = (0.0, 0.0);
        for column in (0..width).step_by(8) {
            let along: Vec<f32> = (0..height).step_by(8).map(|row| of(row * width + column)).collect();
            let mean = along.iter().sum::<f32>() / along.len() as f32;
            let beside = along.iter().cycle().skip(lag / 8);
            product += along.iter().zip(beside).map(|(a, b)| (a - mean) * (b - mean)).sum::<f32>();
            square += along.iter().map(|a| (a - mean).powi(2)).sum::<f32>();
        }
        product / square
    }

    #[test]
    fn the_strip_does_not_repeat_itself() {
        let strip = strip();
        let most = |of: &dyn Fn(usize) -> f32| {
            (1024..=4096).step_by(64).map(|lag| repetition(&strip, lag, of)).fold(f32::MIN, f32::max)
        };
        let [heights, colors] = [most(&|i| strip.heights[i]), most(&|i| f32::from(strip.colors[i][1]))];
        println!("highest correlation from 25 to 100 m further: heights {heights:.2}, colours {colors:.2}");
        assert!(heights < 0.3 && colors < 0.3, "{heights} {colors}");
        // A strip that repeats twice fails this check.
        let twice = |i: usize| strip.heights[i % (strip.heights.len() / 2)];
        assert!(repetition(&strip, strip.height as usize / 2, &twice) > 0.99);
    }

    #[test]
    fn ground_squares_continue_the_strip() {
        let strip = strip();
        let mean = |sand: &Sand, columns: std::ops::Range<u32>, of: &dyn Fn(usize) -> f32| {
            let texels = (0..sand.height).flat_map(|row| columns.clone().map(move |x| (row * sand.width + x) as usize));
            texels.map(of).sum::<f32>() / (sand.height * columns.len() as u32) as f32
        };
        for (square, columns) in [(dry(), 0..16), (wet(), 192..208)] {
            for channel in 0..4 {
                let [a, b] = [(&strip, columns.clone()), (&square, 0..square.width)]
                    .map(|(sand, columns)| mean(sand, columns, &|i| f32::from(sand.colors[i][channel])));
                assert!((a - b).abs() < 2.0, "channel {channel}: {a} and {b} codes");
            }
        }
    }

    #[test]
    fn wet_sand_is_as_dark_as_the_sea_floor_and_smoother_than_dry() {
        let (wet, dry) = (wet(), dry());
        let bed = WET.map(srgb8_from_linear);
        assert!(wet.colors.iter().all(|color| color[..3] == bed));
        let rough = |sand: &Sand| {
            let width = SQUARE / sand.width as f32;
            let slope = |pair: &[f32]| ((pair[1] - pair[0]) / width).powi(2);
            sand.heights.windows(2).map(slope).sum::<f32>() / sand.heights.len() as f32
        };
        assert!(rough(&wet) < 0.05 * rough(&dry), "{} {}", rough(&wet), rough(&dry));
    }
}
