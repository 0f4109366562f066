//! Noise from integer arithmetic, so that every machine generates identical files.

use glam::{Vec2, Vec3};

/// Returns a number in `[0, 1)` for a lattice point.
pub fn hash(x: i32, y: i32, seed: u32) -> f32 {
    let mut h =
        (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77) ^ seed.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    ((h ^ (h >> 15)) >> 8) as f32 / (1 << 24) as f32
}

/// Returns smooth value noise in `[0, 1]`. `p` is in cells, and the period is `cells`.
pub fn value(p: Vec2, cells: [i32; 2], seed: u32) -> f32 {
    let (cell, part) = (p.floor(), p - p.floor());
    let smooth = part * part * part * (part * (part * 6.0 - 15.0) + 10.0);
    let at =
        |x: i32, y: i32| hash((cell.x as i32 + x).rem_euclid(cells[0]), (cell.y as i32 + y).rem_euclid(cells[1]), seed);
    let row = |y: i32| at(0, y) + (at(1, y) - at(0, y)) * smooth.x;
    row(0) + (row(1) - row(0)) * smooth.y
}

/// Returns the sum of octaves of [`value`]. Each octave has twice the frequency and `gain` times the amplitude of the one before. The
/// result is in `[0, 1]`, with a mean of about 1/2.
pub fn fractal(p: Vec2, cells: [i32; 2], octaves: u32, gain: f32, seed: u32) -> f32 {
    let (mut sum, mut weights, mut weight) = (0.0, 0.0, 1.0);
    for octave in 0..octaves {
        let scale = 1 << octave;
        sum += weight * value(p * scale as f32, cells.map(|n| n * scale), seed + octave);
        weights += weight;
        weight *= gain;
    }
    sum / weights
}

/// Returns the distance to the nearest of the scattered points, and the random number of this point. There is one point per cell.
pub fn cells(p: Vec2, cells: [i32; 2], seed: u32) -> (f32, f32) {
    let cell = p.floor();
    let mut nearest = (f32::MAX, 0.0);
    for y in -1..=1 {
        for x in -1..=1 {
            let [cx, cy] = [cell.x as i32 + x, cell.y as i32 + y];
            let [hx, hy] = [cx.rem_euclid(cells[0]), cy.rem_euclid(cells[1])];
            let point = Vec2::new(cx as f32 + hash(hx, hy, seed), cy as f32 + hash(hx, hy, seed ^ 0x5bd1));
            let distance = p.distance(point);
            if distance < nearest.0 {
                nearest = (distance, hash(hx, hy, seed ^ 0x1b56));
            }
        }
    }
    nearest
}

/// Returns a Hermite step from `a` to `b`.
pub fn step(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns the linear colour of sRGB codes.
pub fn srgb(r: u8, g: u8, b: u8) -> Vec3 {
    Vec3::from([r, g, b].map(|code| {
        let x = f32::from(code) / 255.0;
        if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
    }))
}

/// Returns the sRGB codes of a linear colour.
pub fn codes(color: Vec3) -> [u8; 3] {
    color.to_array().map(|x| {
        let x = x.clamp(0.0, 1.0);
        let y = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (255.0 * y + 0.5) as u8
    })
}
