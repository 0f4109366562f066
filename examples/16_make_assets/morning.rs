//! A mountain lake on a clear morning after rain, with a low sun, torn clouds lit from below, hazy ridges, a wooded shore, and gravel in
//! front. The picture is equirectangular, with +x in the middle and z up.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::noise::{cells, fractal, hash, srgb, step};

/// The width in texels. The height is half the width.
const WIDTH: usize = 1024;
/// The azimuth and the elevation of the sun, in degrees. The sun is to the right of the standard views.
const SUN: [f32; 2] = [-62.0, 14.0];
/// The radius of the sun's disc and of its hazy penumbra, in radians. The disc and the penumbra are a few texels wide.
const DISC: f32 = 0.0075;
/// The height of the eye above the ground, in metres.
const EYE: f32 = 1.5;

fn direction([azimuth, elevation]: [f32; 2]) -> Vec3 {
    let (a, e) = (azimuth.to_radians(), elevation.to_radians());
    Vec3::new(a.cos() * e.cos(), a.sin() * e.cos(), e.sin())
}

/// Returns smooth noise around the horizon in `[0, 1]`, with `cells` cells per turn.
fn around(azimuth: f32, cells: i32, octaves: u32, seed: u32) -> f32 {
    fractal(Vec2::new(azimuth / TAU * cells as f32, 0.5), [cells, 1 << 20], octaves, 0.5, seed)
}

fn clear_sky(d: Vec3, sun: Vec3) -> Vec3 {
    let up = d.z.max(0.0);
    let zenith = Vec3::new(0.115, 0.235, 0.50);
    let horizon = Vec3::new(0.78, 0.80, 0.80);
    let mut sky = horizon.lerp(zenith, 1.0 - (-up * 4.2).exp());
    let cosine = d.dot(sun).clamp(-1.0, 1.0);
    // Dawn glows along the horizon, towards the sun.
    let towards = 0.5 + 0.5 * Vec2::new(d.x, d.y).normalize_or_zero().dot(Vec2::new(sun.x, sun.y).normalize());
    let band = (-up * 7.0).exp() * towards.powi(3);
    sky = sky.lerp(Vec3::new(1.9, 1.22, 0.66), 0.75 * band);
    let aureole = 2.6 * (-(1.0 - cosine) * 900.0).exp()
        + 0.75 * (-(1.0 - cosine) * 60.0).exp()
        + 0.22 * (-(1.0 - cosine) * 7.0).exp();
    sky + Vec3::new(1.6, 1.12, 0.66) * aureole
}

/// Returns the coverage and the thickness of the clouds, which are a layer at 1200 m.
fn clouds(d: Vec3) -> (f32, f32) {
    if d.z < 0.02 {
        return (0.0, 0.0);
    }
    let p = Vec2::new(d.x, d.y) * (1.2 / (d.z + 0.06));
    let wide = [1 << 20; 2];
    let warp = Vec2::new(fractal(p * 0.9 + 40.0, wide, 3, 0.5, 61), fractal(p * 0.9 + 70.0, wide, 3, 0.5, 62)) - 0.5;
    let streaks = Vec2::new(p.x * 0.75 + p.y * 0.35, p.y * 1.25) + 0.45 * warp;
    let shape = fractal(streaks * 1.1 + 300.0, wide, 7, 0.55, 63);
    // The clouds break up towards the north-west.
    let break_up = 0.10 * (d.dot(direction([150.0, 20.0])));
    let cover = step(0.475 + break_up, 0.66 + break_up, shape);
    (cover * step(0.02, 0.10, d.z), shape)
}

fn sky(d: Vec3, sun: Vec3) -> Vec3 {
    let clear = clear_sky(d, sun);
    let (cover, shape) = clouds(d);
    let cosine = d.dot(sun).max(0.0);
    // Thin edges glow. Thick parts are grey-blue below and warm on the side of the sun.
    let toward = (d + 0.06 * (sun - d * d.dot(sun)).normalize_or_zero()).normalize();
    let lit = (shape - clouds(toward).1) * 9.0;
    let thick = step(0.35, 1.0, cover);
    let grey = Vec3::new(0.40, 0.43, 0.50) * (1.05 - 0.45 * thick);
    let warm = Vec3::new(1.75, 1.22, 0.85) * (0.35 + 0.65 * lit.clamp(0.0, 1.0)) * (0.45 + 0.55 * cosine);
    let glow = Vec3::new(4.2, 2.7, 1.5) * cosine.powi(24) * (1.0 - thick);
    let cloud = grey + warm * (1.0 - 0.45 * thick) + glow;
    let hazy = (-d.z.max(0.0) * 9.0).exp();
    clear.lerp(cloud.lerp(clear, 0.6 * hazy), 0.93 * cover)
}

/// Returns the elevation of a ridge's crest at an azimuth, in radians.
fn crest(azimuth: f32, layer: usize) -> f32 {
    let a = azimuth.rem_euclid(TAU);
    let (low, high, cells, seed) = [(0.040, 0.430, 7, 81), (0.020, 0.200, 9, 82), (0.012, 0.090, 13, 83)][layer];
    let shape = around(a, cells, 7, seed);
    let peaks = 1.0 - (2.0 * around(a, 2 * cells, 6, seed + 20) - 1.0).abs();
    // The valley opens towards the sun.
    let sun = SUN[0].to_radians();
    let open = 1.0 - 0.55 * (-((a - sun + PI).rem_euclid(TAU) - PI).powi(2) / 0.35).exp();
    (low + (high - low) * (0.6 * shape + 0.4 * peaks * peaks)) * open
}

/// Returns the elevation of the woods on the far shore, in radians. The woods are adjacent spruces.
fn woods(azimuth: f32) -> f32 {
    let a = azimuth.rem_euclid(TAU);
    let mut top = 0.0f32;
    for (count, seed, tall) in [(330, 91, 0.062), (250, 92, 0.078), (470, 93, 0.044)] {
        let at = a / TAU * count as f32;
        for k in -1..=1 {
            let index = at.floor() as i32 + k;
            let own = hash(index.rem_euclid(count), 0, seed);
            let middle = index as f32 + 0.3 + 0.4 * hash(index.rem_euclid(count), 1, seed);
            let stand = step(0.42, 0.62, around(a, 11, 3, 95));
            let height = tall * (0.45 + 0.55 * own) * stand;
            let side = (at - middle).abs();
            // The branches form steps.
            let tip = (1.0 - side * 1.5 - 0.12 * ((at * 9.0).fract() - 0.5)).max(0.0);
            top = top.max(height * tip);
        }
    }
    top + 0.004 + 0.003 * around(a, 60, 3, 96)
}

/// The skyline, with ridge crests and tree tops by azimuth.
struct Skyline {
    crests: [Vec<f32>; 3],
    woods: Vec<f32>,
}

impl Skyline {
    /// The number of samples around the horizon, eight per texel.
    const AZIMUTHS: usize = 8 * WIDTH;

    fn new() -> Self {
        let of = |height: &dyn Fn(f32) -> f32| {
            (0..Self::AZIMUTHS).map(|i| height(i as f32 / Self::AZIMUTHS as f32 * TAU)).collect::<Vec<f32>>()
        };
        Self { crests: [0, 1, 2].map(|layer| of(&|azimuth| crest(azimuth, layer))), woods: of(&woods) }
    }

    fn at(heights: &[f32], azimuth: f32) -> f32 {
        heights[(azimuth / TAU * Self::AZIMUTHS as f32).floor().rem_euclid(Self::AZIMUTHS as f32) as usize
            % Self::AZIMUTHS]
    }
}

/// Returns the radiance above the water.
fn above(d: Vec3, sun: Vec3, skyline: &Skyline) -> Vec3 {
    let elevation = d.z.asin();
    let azimuth = d.y.atan2(d.x);
    let flat = Vec3::new(d.x, d.y, 0.0).normalize_or_zero();
    let haze = sky(Vec3::new(d.x, d.y, 0.03).normalize(), sun) * 0.92;
    let facing = 0.5 - 0.5 * flat.dot(Vec3::new(sun.x, sun.y, 0.0).normalize());
    let mut color = sky(d, sun);
    for layer in 0..3 {
        let top = Skyline::at(&skyline.crests[layer], azimuth);
        let below = top - elevation;
        if below > 0.0 {
            let scale = [60.0, 90.0, 120.0][layer];
            let folds = fractal(
                Vec2::new(azimuth.rem_euclid(TAU) / TAU * 48.0, elevation * scale),
                [48, 1 << 20],
                6,
                0.6,
                84 + layer as u32,
            );
            let beside = |by: f32| Skyline::at(&skyline.crests[layer], azimuth + by);
            let slope = (beside(0.01) - beside(-0.01)) * 12.0;
            let light = (0.35 + 0.9 * facing) * (0.65 + 0.7 * folds) + 0.25 * slope.clamp(-0.6, 0.6);
            let rock = [srgb(128, 122, 118), srgb(84, 96, 84), srgb(60, 78, 56)][layer];
            let snow = if layer == 0 {
                step(0.13, 0.21, elevation + 0.06 * (folds - 0.5)) * step(0.42, 0.58, folds)
            } else {
                0.0
            };
            let ground =
                rock.lerp(Vec3::new(0.86, 0.88, 0.95), 0.85 * snow) * Vec3::new(1.25, 1.05, 0.88) * light.max(0.08);
            let air = [0.66, 0.46, 0.28][layer] * (0.75 + 0.5 * (-(elevation) * 40.0).exp());
            color = ground.lerp(haze, air.min(0.95));
        }
    }
    let trees = Skyline::at(&skyline.woods, azimuth) - elevation;
    if trees > 0.0 {
        let needles =
            fractal(Vec2::new(azimuth.rem_euclid(TAU) / TAU * 900.0, elevation * 700.0), [900, 1 << 20], 3, 0.6, 97);
        let light = (0.30 + 0.9 * facing) * (0.5 + 0.9 * needles);
        let spruce = srgb(40, 54, 36) * Vec3::new(1.3, 1.1, 0.8) * light;
        color = spruce.lerp(haze, 0.10 + 0.22 * (-elevation * 90.0).exp());
    }
    color
}

/// Returns the radiance of the lake and the shore, seen from eye height.
fn below(d: Vec3, sun: Vec3, skyline: &Skyline) -> Vec3 {
    let wide = [1 << 20; 2];
    let p = Vec2::new(d.x, d.y) * (EYE / -d.z.min(-1e-4));
    let distance = p.length();
    let far = p + 4000.0;
    // The ripples are weaker at a distance, where they are smaller than a texel.
    let calm = 1.0 / (1.0 + distance * 0.02);
    let stretched = Vec2::new(far.x * 0.9 + far.y * 0.4, far.y * 0.9 - far.x * 0.4);
    let wave = |seed: u32| fractal(stretched * Vec2::new(1.6, 0.7), wide, 4, 0.55, seed) - 0.5;
    let tilt = Vec2::new(wave(101), wave(102)) * (0.07 * calm + 0.012);
    let reflected = Vec3::new(d.x + tilt.x, d.y + tilt.y, (-d.z + 0.3 * tilt.x.abs()).max(0.002)).normalize();
    let fresnel = 0.02 + 0.98 * (1.0 + d.z).clamp(0.0, 1.0).powi(5);
    let deep = Vec3::new(0.020, 0.045, 0.050);
    let mut water = deep.lerp(above(reflected, sun, skyline), fresnel);
    water += Vec3::new(9.0, 6.4, 3.8) * (reflected.dot(sun).max(0.0)).powi(260) * fresnel.max(0.06);

    // There are pebbles in front, which are wet at the water's edge, and grass behind them.
    let shore = 5.2 + 2.2 * (fractal(far * 0.30, wide, 3, 0.5, 111) - 0.5) + 1.6 * d.y.atan2(d.x).cos();
    let edge = step(shore - 0.25, shore + 0.15, distance);
    let (pebble, own) = cells(far * 7.0, wide, 112);
    let (small, other) = cells(far * 19.0, wide, 113);
    let round = |x: f32| (1.0 - x * x).max(0.0);
    let stone = srgb(120, 116, 108).lerp(srgb(156, 142, 122), own).lerp(srgb(84, 84, 88), step(0.7, 0.9, other));
    let mut ground = stone * (0.35 + 0.65 * round(pebble * 1.15).max(0.8 * round(small * 1.2)));
    let grass = step(0.50, 0.62, fractal(far * 0.55, wide, 4, 0.5, 114)) * step(1.0, 2.4, shore - distance);
    let blades = fractal(far * 24.0, wide, 3, 0.6, 115);
    ground = ground.lerp(srgb(92, 104, 48) * (0.35 + 0.9 * blades), 0.9 * grass);
    let wet = step(0.9, 0.0, shore - distance);
    ground *= 1.0 - 0.45 * wet;
    let light = Vec3::new(1.30, 1.06, 0.84) * (0.55 + 0.6 * fractal(far * 2.2, wide, 3, 0.5, 116));
    let dry = ground * light;
    let shallow = dry.lerp(water, (0.35 + fresnel + 0.16 * (distance - shore)).clamp(0.0, 1.0));
    dry.lerp(shallow, edge)
}

/// Returns the radiance from a direction, without the sun's disc.
fn radiance(d: Vec3, sun: Vec3, skyline: &Skyline) -> Vec3 {
    if d.z >= 0.0 { above(d, sun, skyline) } else { below(d, sun, skyline) }
}

/// Returns the picture, row by row.
fn picture() -> Vec<Vec3> {
    let sun = direction(SUN);
    let height = WIDTH / 2;
    let toward = |x: f32, y: f32| {
        let (phi, theta) = ((0.5 - x / WIDTH as f32) * TAU, y / height as f32 * PI);
        Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    let skyline = Skyline::new();
    let texel = |i: usize| {
        let (x, y) = (i % WIDTH, i / WIDTH);

        // There are 2 x 2 samples per texel.
        let mut sum = Vec3::ZERO;
        for k in 0..4 {
            let d = toward(x as f32 + (k % 2) as f32 * 0.5 + 0.25, y as f32 + (k / 2) as f32 * 0.5 + 0.25);
            sum += radiance(d, sun, &skyline);
            let disc = step(1.25 * DISC, 0.75 * DISC, d.angle_between(sun));
            sum += Vec3::new(21_000.0, 15_500.0, 9_600.0) * (0.93 * disc);
        }
        sum / 4.0
    };
    (0..WIDTH * height).into_par_iter().map(texel).collect()
}

/// Returns the picture as a Radiance file.
pub fn file() -> Vec<u8> {
    let height = WIDTH / 2;
    let mut file =
        format!("#?RADIANCE\nSOFTWARE=leadr-vk 16_make_assets\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {WIDTH}\n")
            .into_bytes();
    for row in picture().chunks(WIDTH) {
        file.extend([2, 2, (WIDTH >> 8) as u8, WIDTH as u8]);
        let texels: Vec<[u8; 4]> = row.iter().map(|&color| rgbe(color)).collect();
        for channel in 0..4 {
            run_lengths(&texels.iter().map(|texel| texel[channel]).collect::<Vec<u8>>(), &mut file);
        }
    }
    file
}

/// Returns three mantissas and the exponent that they share.
fn rgbe(color: Vec3) -> [u8; 4] {
    let most = color.max_element();
    if most < 1e-32 {
        return [0; 4];
    }
    let exponent = most.log2().floor() as i32 + 1;
    let scale = 2f32.powi(8 - exponent);
    let [r, g, b] = color.to_array().map(|x| (x * scale).min(255.0) as u8);
    [r, g, b, (exponent + 128) as u8]
}

/// Encodes a channel of a row: a run of four or more equal bytes is written as 128 plus its length, followed by the byte; other bytes are
/// written literally.
fn run_lengths(bytes: &[u8], file: &mut Vec<u8>) {
    let run_at = |i: usize| bytes[i..].iter().take(127).take_while(|&&b| b == bytes[i]).count();
    let mut i = 0;
    while i < bytes.len() {
        let run = run_at(i);
        if run >= 4 {
            file.extend([128 + run as u8, bytes[i]]);
            i += run;
        } else {
            let start = i;
            while i < bytes.len() && i - start < 128 && run_at(i) < 4 {
                i += 1;
            }
            file.push((i - start) as u8);
            file.extend(&bytes[start..i]);
        }
    }
}
