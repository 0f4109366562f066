//! Square, periodic height maps with hard edges. Heights are in texture widths.

use glam::DVec2;
use leadr_maps::HeightMap;
use leadr_reflectance::random::Random;
use std::f64::consts::{PI, TAU};

/// Samples a height function. Its arguments are from 0 to 1, and its values are in texture widths.
fn sampled(size: u32, height: impl Fn(f64, f64) -> f64) -> HeightMap {
    let at = |i: u32| (f64::from(i % size) / f64::from(size), f64::from(i / size) / f64::from(size));
    let texels = (0..size * size).map(|i| height(at(i).0, at(i).1) as f32).collect();
    HeightMap { width: size, height: size, texels }
}

/// Returns round studs at random places, whose tops and walls cover `cover` of the field. `radius` is that of the tops, and lengths are
/// in texels.
pub fn studs(size: u32, radius: f64, wall: f64, cover: f64, height: f64) -> HeightMap {
    let mut random = Random::stream(3, 0);
    let side = f64::from(size);
    let count = (cover * side * side / (PI * radius * radius)) as usize;
    let centres: Vec<DVec2> = (0..count).map(|_| DVec2::new(random.unit(), random.unit()) * side).collect();
    sampled(size, |x, y| {
        let at = DVec2::new(x, y) * side;
        let near = |centre: &DVec2| {
            let off = at - centre;
            height * ((radius + wall - (off - side * (off / side).round()).length()) / wall).clamp(0.0, 1.0)
        };
        centres.iter().map(near).fold(0.0, f64::max) / side
    })
}

/// Returns bricks with mortar between them, each at its own height and slightly tilted.
pub fn bricks(size: u32) -> HeightMap {
    sampled(size, |x, y| {
        let row = (8.0 * y).floor();
        let along = 4.0 * x + 0.5 * (row % 2.0);
        let (u, v) = (along.fract(), (8.0 * y).fract());
        let edge = (0.25 * u.min(1.0 - u)).min(0.125 * v.min(1.0 - v));
        let mut random = Random::stream(row as u64, along as u64 % 4);
        let mut vary = || random.range(-1.0, 1.0);
        let height = 0.018 + 0.002 * vary() + 0.006 * vary() * (u - 0.5) + 0.003 * vary() * (v - 0.5);
        let rise = ((edge - 0.005) / 0.012).clamp(0.0, 1.0);
        height * rise * rise * (3.0 - 2.0 * rise)
    })
}

/// Returns straight grooves of ground, walls of slope 2.4 and tops in equal parts.
pub fn grooves(size: u32) -> HeightMap {
    sampled(size, |x, y| {
        let wave = 4.0 * ((16.0 * x).fract() - 0.5).abs();
        // The waves along the grooves give slopes in both directions.
        0.0375 * (wave - 0.5).clamp(0.0, 1.0) + 0.004 * (TAU * (4.0 * y + x)).sin()
    })
}

/// Returns rows of overlapping, rounded roof tiles.
pub fn tiles(size: u32) -> HeightMap {
    sampled(size, |x, y| {
        let v = (8.0 * y).fract();
        let saw = if v < 0.85 { v / 0.85 } else { (1.0 - v) / 0.15 };
        let u = (8.0 * x + 0.5 * ((8.0 * y).floor() % 2.0)).fract();
        let round = (1.0 - (2.0 * u - 1.0).powi(4)).max(0.0);
        0.125 * (0.35 * saw + 0.15 * round * (1.0 + saw))
    })
}

/// Returns rows of overlapping flat shingles of different thickness, with gaps between them.
pub fn shingles(size: u32) -> HeightMap {
    sampled(size, |x, y| {
        let row = (8.0 * y).floor();
        let along = 6.0 * x + 0.5 * (row % 2.0);
        let (u, v) = (along.fract(), (8.0 * y).fract());
        let thickness = 0.03 + 0.01 * Random::stream(row as u64, along as u64 % 6).range(-1.0, 1.0);
        let wedge = if v < 0.9 { v / 0.9 } else { (1.0 - v) / 0.1 };
        let gap = (u.min(1.0 - u) / 0.06).min(1.0);
        thickness * wedge * gap
    })
}
