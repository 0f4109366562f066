//! Procedural height maps. All maps tile in both directions and are deterministic.
//!
//! Slopes are per unit texture coordinate, as in [`super::moments`]. All functions panic on a zero size.

use std::f32::consts::TAU;

use rayon::prelude::*;

use super::HeightMap;
use super::noise::{
    Fractal, Gradients, RotatedFractal, RotatedGradients, Scattered, hash, smoothstep, transpose, unit,
};
use leadr_reflectance::random::Random;

/// The source text of this module, which is part of cache keys.
pub const SOURCE: &str = include_str!("procedural.rs");

/// Creates a map from the values of `f(s, t)` at the texel centres.
fn fill(width: u32, height: u32, f: impl Fn(f32, f32) -> f32 + Sync) -> HeightMap {
    let mut texels = vec![0.0; width as usize * height as usize];
    texels.par_chunks_mut(width as usize).enumerate().for_each(|(y, row)| {
        let t = (y as f32 + 0.5) / height as f32;
        for (x, texel) in row.iter_mut().enumerate() {
            *texel = f((x as f32 + 0.5) / width as f32, t);
        }
    });
    HeightMap::new(width, height, texels).expect("a positive size and finite formulas")
}

/// Stretches the heights to the range 0..1 exactly. A flat map becomes 0.
fn normalised(mut map: HeightMap) -> HeightMap {
    let (low, high) = map.texels.iter().fold((f32::MAX, f32::MIN), |(a, b), &h| (a.min(h), b.max(h)));
    let range = if high > low { high - low } else { 1.0 };
    map.texels.iter_mut().for_each(|h| *h = (*h - low) / range);
    map
}

/// Generates a Gaussian random surface: white noise blurred by a Gaussian. The Gaussian's standard deviation `feature` is a
/// fraction of the map's side. `feature` must be at most 1/8, and at least 2 texels to be resolved.
///
/// The heights have mean 0. The slopes are Gaussian and uncorrelated, with `E[x^2] = E[y^2] = slope_sigma^2`. The height
/// variance is `2 (slope_sigma feature)^2`, and the height correlation at distance `r` is `exp(-r^2 / (4 feature^2))`. The
/// variances of one map have a relative standard deviation of about `2.5 feature`. If `feature` is `w` texels, the triangles
/// have `1 - 1 / (8 w^2)` of the slope variance.
pub fn gaussian(width: u32, height: u32, seed: u32, slope_sigma: f32, feature: f32) -> HeightMap {
    let feature = feature.min(0.125);
    let white: Vec<f32> =
        (0..height).flat_map(|y| (0..width).map(move |x| normal(hash(seed, x as i32, y as i32)))).collect();
    let rows = blur_rows(&white, width as usize, feature * width as f32);
    let columns = transpose(&rows, width as usize);
    let columns = blur_rows(&columns, height as usize, feature * height as f32);
    let mut texels = transpose(&columns, height as usize);
    let height_sigma = std::f32::consts::SQRT_2 * slope_sigma * feature;
    texels.iter_mut().for_each(|h| *h *= height_sigma);
    HeightMap::new(width, height, texels).expect("a positive size and finite heights")
}

/// Converts one random word to a normally distributed number (Box and Muller).
fn normal(h: u32) -> f32 {
    let radius = (-2.0 * (1.0 - unit(h)).ln()).sqrt();
    radius * (TAU * unit(hash(h, 3, 5))).cos()
}

/// Blurs rows periodically by a Gaussian of `sigma` texels. The filter has unit energy, so white noise keeps its variance of
/// 1.
fn blur_rows(texels: &[f32], width: usize, sigma: f32) -> Vec<f32> {
    let reach = (4.0 * sigma).ceil() as i64;
    let mut kernel: Vec<f32> = (-reach..=reach).map(|i| (-0.5 * (i as f32 / sigma.max(1e-6)).powi(2)).exp()).collect();
    let energy = kernel.iter().map(|k| k * k).sum::<f32>().sqrt();
    kernel.iter_mut().for_each(|k| *k /= energy);
    let mut blurred = vec![0.0; texels.len()];
    blurred.par_chunks_mut(width).zip(texels.par_chunks(width)).for_each(|(out, row)| {
        // Each row is padded by its period at both ends, so that the inner loop needs no wrapping.
        let wrapped: Vec<f32> =
            (-reach..width as i64 + reach).map(|i| row[i.rem_euclid(width as i64) as usize]).collect();
        for (x, value) in out.iter_mut().enumerate() {
            *value = kernel.iter().zip(&wrapped[x..]).map(|(k, v)| k * v).sum();
        }
    });
    blurred
}

/// Generates fractal gradient noise with `octaves` octaves. The first octave has `cells` lattice cells across the map. Each
/// further octave has twice the frequency and `gain` times the amplitude.
///
/// The mean is close to 0, and `|h| <= 1 + gain + gain^2 + ...`. The height variance of an octave is about 0.1 times the
/// squared amplitude if the lattice has 8 cells or more (measured).
pub fn fbm(width: u32, height: u32, seed: u32, cells: u32, octaves: u32, gain: f32) -> HeightMap {
    let noise = Fractal::new(seed, cells.max(1) as i32, octaves, gain);
    let cells = cells.max(1) as f32;
    fill(width, height, |s, t| noise.at(s * cells, t * cells))
}

/// Generates weathered rock: ridged fractal noise with a few sharp clefts. Heights span 0 to 1 exactly.
///
/// At 512 x 512 texels, over several seeds, the measured mean is 0.55 to 0.75, and the slope deviation is 9 to 12 per axis.
pub fn rock(width: u32, height: u32, seed: u32) -> HeightMap {
    let warps = [0x51, 0x52].map(|k: u32| Fractal::new(seed ^ k, 6, 3, 0.5));
    let octaves: Vec<Gradients> = (0..6).map(|k| Gradients::new(seed.wrapping_add(100 + k), 6 << k)).collect();
    let clefts = Scattered::new(seed ^ 0xc1ef, 3, |_| ());
    normalised(fill(width, height, |s, t| {
        let [u, v] = [0, 1].map(|k: usize| [s, t][k] * 6.0 + 0.35 * warps[k].at(s * 6.0, t * 6.0));
        let (mut ridges, mut amplitude) = (0.0, 0.5);
        for (octave, noise) in octaves.iter().enumerate() {
            let scale = (1 << octave) as f32;
            ridges += amplitude * (1.0 - noise.at(u * scale, v * scale).abs() * 2.0);
            amplitude *= 0.45;
        }
        let [f1, f2] = clefts.nearest_two(u * 0.5, v * 0.5);
        ridges - 0.45 * (1.0 - smoothstep(0.0, 0.09, f2 - f1))
    }))
}

/// Generates a scratched plate with straight grooves in random directions. The grooves are shallow or deep and have raised
/// rims. Heights span 0 to 1 exactly.
pub fn scratches(width: u32, height: u32, seed: u32, count: u32) -> HeightMap {
    let mut random = Random::stream(seed.into(), 0x5c7a);
    let grooves: Vec<[f32; 6]> = (0..count)
        .map(|_| {
            let (sine, cosine) = random.range(0.0, std::f64::consts::TAU).sin_cos();
            let half_length = random.range(0.1, 0.45);
            let centre = [random.unit(), random.unit()];
            [centre[0], centre[1], cosine, sine, half_length, random.range(0.2, 1.0)].map(|v| v as f32)
        })
        .collect();
    normalised(fill(width, height, |s, t| {
        let depth = |&[x, y, cosine, sine, half_length, depth]: &[f32; 6]| {
            // The distance is measured to the nearest periodic copy.
            let [u, v] = [s - x, t - y].map(|d| d - d.round());
            let (along, across) = (u * cosine + v * sine, v * cosine - u * sine);
            let end = 1.0 - smoothstep(0.6, 1.0, along.abs() / half_length);
            let a = (across / 0.008).powi(2);
            // The raised rims contain the material that the groove displaced.
            depth * end * (1.0 - a) * (-0.5 * a).exp()
        };
        -grooves.iter().map(depth).sum::<f32>()
    }))
}

/// Generates dry soil with soft undulation, half-buried pebbles of three sizes, patches of cracks, and grain. Heights span 0
/// to 1 exactly. For a tile of about 2 m a height scale near 0.06 m looks natural.
///
/// At 1024 x 1024 texels, over several seeds, the measured mean is 0.4 to 0.6, and the slope deviation is 9 to 16 per axis.
pub fn soil(width: u32, height: u32, seed: u32) -> HeightMap {
    let undulation = RotatedFractal::new(seed, 3, 5, 0.5);
    let fine = RotatedFractal::new(seed ^ 0x6a1, 96, 2, 0.6);
    let warps = [0x11, 0x12].map(|k: u32| Fractal::new(seed ^ k, 14, 3, 0.5));
    let plates = Scattered::new(seed ^ 0xc2ac, 7, |_| ());
    let cracked = RotatedGradients::new(seed ^ 0x9a7c, 3);
    let sizes = [(9, 0.35, 0.34, 0x57a1), (26, 0.45, 0.15, 0x57a2), (64, 0.5, 0.06, 0x57a3)];
    let pebbles = sizes.map(|(cells, share, size, k): (_, _, f32, u32)| (size, Pebbles::new(seed ^ k, cells, share)));
    normalised(fill(width, height, |s, t| {
        let ground = 0.30 * undulation.at(s, t);
        let grain = 0.022 * fine.at(s, t);

        let [u, v] = [0, 1].map(|k: usize| [s, t][k] * 7.0 + 0.25 * warps[k].at(s * 14.0, t * 14.0));
        let [f1, f2] = plates.nearest_two(u, v);
        let patches = smoothstep(-0.15, 0.35, cracked.at(s, t));
        // Plates of dry soil curl up slightly towards their cracks.
        let rim = 0.04 * (1.0 - smoothstep(0.05, 0.35, f2 - f1));
        let crack = 0.26 * (1.0 - smoothstep(0.01, 0.07, f2 - f1));

        let stones = pebbles.iter().fold(0.0f32, |highest, (size, some)| highest.max(size * some.height(s, t)));
        // A stone lies in the soil and bridges the cracks.
        let bare = 1.0 - smoothstep(0.0, 0.03, stones);
        ground + grain + patches * (rim - crack) * bare + stones
    }))
}

struct Pebbles {
    cells: i32,
    shapes: Scattered<Option<Pebble>>,
    /// The offsets that make outlines irregular, from noise that is finer than a pebble.
    shifts: [Fractal; 2],
}

struct Pebble {
    radius: f32,
    /// The cosine and sine of the direction of a pebble's long axis.
    rotation: [f32; 2],
    aspect: f32,
}

impl Pebbles {
    /// Creates the pebbles. `share` is the fraction of cells that contain a pebble.
    fn new(seed: u32, cells: i32, share: f32) -> Self {
        let shape = |id: u32| {
            let random = |k: i32| unit(hash(id, k, 0));
            let (sin, cos) = (TAU * random(9)).sin_cos();
            let (radius, aspect) = (0.16 + 0.3 * random(8).powi(2), 0.65 + 0.35 * random(10));
            (random(7) < share).then_some(Pebble { radius, rotation: [cos, sin], aspect })
        };
        let shifts = [0x21, 0x22].map(|k: u32| Fractal::new(seed ^ k, cells * 4, 2, 0.5));
        Self { cells, shapes: Scattered::new(seed, cells, shape), shifts }
    }

    /// Returns the height of the highest pebble at a position, 0 to 1.
    fn height(&self, s: f32, t: f32) -> f32 {
        let (x, y) = (s * self.cells as f32, t * self.cells as f32);
        let [dx, dy] = self.shifts.each_ref().map(|shift| 0.05 * shift.at(x * 4.0, y * 4.0));
        let mut highest = 0.0f32;
        self.shapes.visit(x, y, 1, |offset, pebble| {
            let Some(Pebble { radius, rotation: [cos, sin], aspect }) = pebble else { return };
            let (px, py) = (offset[0] + dx, offset[1] + dy);
            let along = (cos * px + sin * py) / radius;
            let across = (cos * py - sin * px) / (radius * aspect);
            let d2 = along * along + across * across;
            if d2 < 1.0 {
                // A pebble is a flattened dome whose rim is steep but has a finite slope.
                highest = highest.max(radius / 0.46 * (1.0 - d2) * (1.0 + 0.5 * d2));
            }
        });
        highest
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LeadrMap, Wrap};
    use super::*;

    /// Returns the largest height step between neighbours inside the map, and the largest step across its seam.
    fn steps(map: &HeightMap) -> (f32, f32) {
        let (w, h) = (map.width, map.height);
        let (mut inside, mut seam) = (0.0f32, 0.0f32);
        for y in 0..h {
            for x in 0..w {
                let here = map.at(x, y);
                let (right, down) = ((here - map.at((x + 1) % w, y)).abs(), (here - map.at(x, (y + 1) % h)).abs());
                let worst = if x + 1 < w { &mut inside } else { &mut seam };
                *worst = worst.max(right);
                let worst = if y + 1 < h { &mut inside } else { &mut seam };
                *worst = worst.max(down);
            }
        }
        (inside, seam)
    }

    fn mean_and_sigma(map: &HeightMap) -> (f64, [f64; 2]) {
        let m = LeadrMap::new(map, Wrap::Repeat).mean();
        let [xx, yy, _] = m.slope_covariance();
        (f64::from(m.height), [xx.sqrt(), yy.sqrt()])
    }

    #[test]
    fn all_tile_and_are_reproducible() {
        let n = 256;
        type Make = fn(u32) -> HeightMap;
        let maps: [(&str, Make); 4] = [
            ("gaussian", |seed| gaussian(256, 256, seed, 1.0, 0.02)),
            ("fbm", |seed| fbm(256, 256, seed, 5, 4, 0.5)),
            ("rock", |seed| rock(256, 256, seed)),
            ("soil", |seed| soil(256, 256, seed)),
        ];
        for (name, make) in maps {
            let map = make(7);
            let (inside, seam) = steps(&map);
            assert!(seam <= inside * 1.05, "{name} has a seam: {seam} against {inside} inside");
            assert_eq!(map, make(7), "{name} differs between two calls");
            assert_ne!(map, make(8), "{name} ignores its seed");
        }
        // A ramp does not tile, so the check must fail.
        let ramp = fill(n, n, |s, _| s);
        let (inside, seam) = steps(&ramp);
        assert!(seam > inside * 1.05);
    }

    #[test]
    fn gaussian_has_its_stated_moments() {
        let (slope, feature, seeds) = (0.7f32, 0.015f32, 16);
        let (mut slope_ratio, mut height_ratio, mut kurtosis) = (0.0, 0.0, 0.0);
        for seed in 0..seeds {
            let map = gaussian(512, 512, seed, slope, feature);
            let moment =
                |n: i32| map.texels.iter().map(|&h| f64::from(h).powi(n)).sum::<f64>() / map.texels.len() as f64;
            let (_, sigma) = mean_and_sigma(&map);
            let ratios = sigma.map(|s| (s / f64::from(slope)).powi(2));
            // The tolerance is five standard deviations of the variance of one map.
            assert!(ratios.iter().all(|r| (r - 1.0).abs() < 5.0 * 2.5 * f64::from(feature)), "seed {seed}: {ratios:?}");
            slope_ratio += (ratios[0] + ratios[1]) / 2.0 / f64::from(seeds);
            height_ratio += moment(2) / (2.0 * f64::from(slope * feature).powi(2)) / f64::from(seeds);
            kurtosis += moment(4) / moment(2).powi(2) / f64::from(seeds);
        }
        println!("slope variance {slope_ratio:.4}, height variance {height_ratio:.4}, kurtosis {kurtosis:.3}");
        let texels = f64::from(feature) * 512.0;
        let seen = 1.0 - 0.125 / (texels * texels);
        assert!((slope_ratio / seen - 1.0).abs() < 0.025 && (height_ratio - 1.0).abs() < 0.03);
        assert!((kurtosis - 3.0).abs() < 0.1);
    }

    #[test]
    fn fbm_is_bounded_and_has_its_stated_variance() {
        for seed in 0..4 {
            let map = fbm(256, 256, seed, 16, 1, 0.5);
            assert!(map.texels.iter().all(|h| h.abs() <= 1.0));
            let variance = map.texels.iter().map(|&h| f64::from(h).powi(2)).sum::<f64>() / map.texels.len() as f64;
            println!("variance {variance:.4}");
            assert!((variance - 0.1).abs() < 0.035, "{variance}");
        }
    }

    #[test]
    fn rock_and_soil_have_their_stated_statistics() {
        for seed in [1, 2, 3] {
            for (name, map, means, slopes) in [
                ("rock", rock(512, 512, seed), 0.55..0.75, 9.0..12.0),
                ("soil", soil(1024, 1024, seed), 0.4..0.6, 9.0..16.0),
            ] {
                let (mean, sigma) = mean_and_sigma(&map);
                println!("{name} {seed}: mean {mean:.3} slope sigma {sigma:.2?}");
                assert!(map.texels.contains(&0.0) && map.texels.contains(&1.0));
                assert!(means.contains(&mean), "{name} {seed}: mean {mean}");
                assert!(sigma.iter().all(|s| slopes.contains(s)), "{name} {seed}: {sigma:?}");
            }
        }
    }
}
