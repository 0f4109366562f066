//! Slope moments of a height map and their mip chain, which form the LEADR map (LEADR section 4). Moments are computed as in
//! LEAN mapping, and equal the moments pass to the last bit.
//!
//! Slopes are per unit texture coordinate: `x = dh/ds`, `y = dh/dt`, with `s` and `t` from 0 to 1 over the map. A height
//! scale multiplies the first moments, and its square multiplies the second moments.
//!
//! **Surface.** The moments describe a surface with a vertex at every texel centre, and four triangles in each cell between
//! four texels, which meet in its centre at the mean height of the corners. Two triangles would favour the slopes along one
//! diagonal. A texel stores the exact moments of the triangles over its own square
//! ([`moments_of_corner`](leadr_reflectance::slopes::moments::moments_of_corner)). Let `a`, `a'` be the height differences to
//! the left and right neighbours, and `b` the same differences in the rows above and below, all multiplied by the number of
//! texels. The mean slope is `E[x] = 3/8 (a + a') + 1/16 Σb`. The usual central differences ignore the texel itself.
//! They find 4 to 36 % less variance on scanned materials, and none on a checkerboard of single texels.
//!
//! **Compared with a smooth surface**, triangles are flatter at few texels per period. For a sine wave of `p` texels per
//! period, `E[x^2]` is `sinc(pi / p)^2` of the exact value: 0.95 for 8 texels, and 0.997 for 32 texels.
//!
//! **Magnification.** A texel's variance describes the triangles inside it. The sampler interpolates moments between texel
//! centres, so the mean slope varies smoothly, and the remaining slope becomes variance. The sum of squared slope and
//! variance is the same at every magnification.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::pyramid::{Pyramid, level_sizes};
use super::{HeightMap, Image};
use leadr_reflectance::limits::{at_least, within};

/// How texels outside a map are addressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The map repeats.
    #[default]
    Repeat,
    /// The edge texel repeats. Half of an edge texel lies beyond the last centre, where the sampled surface is flat across the
    /// edge.
    Clamp,
}

impl Wrap {
    /// Returns the texel that `index` addresses. The index may be outside `0..len`.
    pub(super) fn texel(self, index: i64, len: u32) -> usize {
        match self {
            Self::Repeat => index.rem_euclid(i64::from(len)) as usize,
            Self::Clamp => index.clamp(0, i64::from(len) - 1) as usize,
        }
    }
}

/// One texel of a LEADR map in texture space, as six floats. The first four floats fit an RGBA texture, the last two an RG
/// texture.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Moments {
    /// The mean slopes `E[x], E[y]` per unit of `s` and `t`.
    pub mean_slope: [f32; 2],
    /// The second moments `E[x^2], E[y^2]`.
    pub second: [f32; 2],
    /// The mixed second moment `E[x y]`.
    pub cross: f32,
    /// The mean height, in the unit of the map.
    pub height: f32,
}

impl Moments {
    /// Returns `[sx^2, sy^2, cxy]`, the variances and the covariance. The matrix is made positive semidefinite, because
    /// rounding can make the subtraction negative.
    pub fn slope_covariance(&self) -> [f64; 3] {
        let [mx, my] = self.mean_slope.map(f64::from);
        let xx = at_least(f64::from(self.second[0]) - mx * mx, 0.0);
        let yy = at_least(f64::from(self.second[1]) - my * my, 0.0);
        let limit = (xx * yy).sqrt();
        [xx, yy, within(f64::from(self.cross) - mx * my, limit)]
    }

    /// Returns the moments of slopes whose component along `t` is multiplied by `factor`.
    #[must_use]
    pub fn with_t_times(&self, factor: f32) -> Self {
        let ([x, y], [xx, yy]) = (self.mean_slope, self.second);
        Self { mean_slope: [x, factor * y], second: [xx, factor * factor * yy], cross: factor * self.cross, ..*self }
    }

    /// Returns the moments of the heights multiplied by `scale`.
    pub fn scaled(&self, scale: f32) -> Self {
        let square = scale * scale;
        Self {
            mean_slope: self.mean_slope.map(|v| v * scale),
            second: self.second.map(|v| v * square),
            cross: self.cross * square,
            height: self.height * scale,
        }
    }
}

/// One mip level.
pub type MomentLevel = Image<Moments>;

impl MomentLevel {
    /// Returns the finest level of [`LeadrMap::new`].
    pub fn of_heights(map: &HeightMap, wrap: Wrap) -> Self {
        let mut texels = vec![Moments::default(); map.texels.len()];
        texels.par_chunks_mut(map.width as usize).zip(0..map.height).for_each(|(texels, y)| {
            texels.copy_from_slice(bytemuck::cast_slice(&row_moments(map, wrap, 1.0, y)));
        });
        Self { width: map.width, height: map.height, texels }
    }
}

/// The moments of a height map with all mip levels down to 1 x 1. Each level has half the width and height of the previous
/// one, rounded down, as in Vulkan.
#[derive(Clone, Debug, PartialEq)]
pub struct LeadrMap {
    /// The mip levels. Level 0 comes first.
    pub levels: Vec<MomentLevel>,
}

impl LeadrMap {
    /// Creates the map. Differences, products and the box filter are computed in 32 bits and in the order of the moments
    /// pass, so the results are bit-exact.
    ///
    /// Each level is an area average of the finer level. All texels therefore have equal weights, even at odd sizes, and the
    /// mean of every moment is equal on all levels.
    pub fn new(map: &HeightMap, wrap: Wrap) -> Self {
        let size = [map.width, map.height];
        let empty = |[width, height]: [u32; 2]| MomentLevel {
            width,
            height,
            texels: Vec::with_capacity(width as usize * height as usize),
        };
        let mut levels: Vec<MomentLevel> = level_sizes(size).into_iter().map(empty).collect();
        let rows = (0..map.height).into_par_iter().map(|y| row_moments(map, wrap, 1.0, y).into_flattened());
        let filtered = Pyramid::new(size, 6).push(rows.collect(), &mut |level, _, rows| {
            rows.iter().for_each(|row| levels[level].texels.extend_from_slice(bytemuck::cast_slice(row)));
            Ok(())
        });
        filtered.expect("the callback never fails");
        Self { levels }
    }

    /// Returns the moments of the whole map, from the smallest level.
    pub fn mean(&self) -> Moments {
        self.levels[self.levels.len() - 1].texels[0]
    }
}

/// Returns a row of level 0. The heights are multiplied by `scale`.
pub(super) fn row_moments(map: &HeightMap, wrap: Wrap, scale: f32, y: u32) -> Vec<[f32; 6]> {
    let (w, h) = (map.width as usize, map.height as usize);
    let at = |x: usize, y: usize| scale * map.texels[y * w + x];
    let texels = [w as f32, h as f32];
    let rows = [-1, 1].map(|step| wrap.texel(i64::from(y) + step, map.height));
    let y = y as usize;
    let texel = |x: usize| {
        let columns = [-1, 1].map(|step| wrap.texel(x as i64 + step, map.width));
        let here = at(x, y);
        let mut sums = [0.0; 5];
        for (row, sign_t) in rows.into_iter().zip([-1.0, 1.0]) {
            for (column, sign_s) in columns.into_iter().zip([-1.0, 1.0]) {
                let quarter = corner([here, at(column, y), at(x, row), at(column, row)], [sign_s, sign_t]);
                sums.iter_mut().zip(quarter).for_each(|(sum, v)| *sum += v);
            }
        }
        let [x, y, xx, yy, xy] = sums.map(|sum: f32| 0.25 * sum);
        let [s, t] = texels;
        [x * s, y * t, xx * (s * s), yy * (t * t), xy * (s * t), here]
    };
    (0..w).map(texel).collect()
}

/// Computes [`moments_of_corner`](leadr_reflectance::slopes::moments::moments_of_corner) in 32 bits, like the GPU pass.
/// `signs` are the directions to the neighbours.
fn corner([here, across, along, both]: [f32; 4], signs: [f32; 2]) -> [f32; 5] {
    let beside = [(across - here) * signs[0], (along - here) * signs[1]];
    let opposite = [(both - along) * signs[0], (both - across) * signs[1]];
    let mean = [0, 1].map(|i| 0.5 * (beside[i] + opposite[i]));
    let first = |i: usize| 0.5 * (beside[i] + mean[i]);
    let square = |i: usize| 0.5 * (beside[i] * beside[i] + mean[i] * mean[i]);
    [first(0), first(1), square(0), square(1), 0.5 * (beside[0] * mean[1] + mean[0] * beside[1])]
}

/// Returns the texels of `from` that each of `to` texels covers, with weights that sum to 1.
pub fn coverage(from: u32, to: u32) -> Vec<Vec<(usize, f64)>> {
    let (from, to) = (u64::from(from), u64::from(to));
    // In units of 1/(from * to) of the side, all bounds of texels are integers.
    let cover = |i: u64| {
        let (start, end) = (i * from, (i + 1) * from);
        (start / to..end.div_ceil(to))
            .map(|j| {
                let overlap = end.min((j + 1) * to) - start.max(j * to);
                (j as usize, overlap as f64 / from as f64)
            })
            .collect()
    };
    (0..to).map(cover).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::pyramid::Taps;

    fn map(width: u32, height: u32, f: impl Fn(f64, f64) -> f64) -> HeightMap {
        let at = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let texels = texels.map(|(x, y)| f(at(x, width), at(y, height)) as f32).collect();
        HeightMap::new(width, height, texels).unwrap()
    }

    /// Returns the largest relative difference between the means of `level` and level 0, over all six moments.
    fn mean_error(leadr: &LeadrMap, level: usize) -> f64 {
        let mean = |l: &MomentLevel| {
            let mut sum = [0.0f64; 6];
            for t in &l.texels {
                let t: [f32; 6] = bytemuck::cast(*t);
                sum.iter_mut().zip(t).for_each(|(s, v)| *s += f64::from(v));
            }
            sum.map(|s| s / l.texels.len() as f64)
        };
        let (a, b) = (mean(&leadr.levels[0]), mean(&leadr.levels[level]));
        let scale = a.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        a.iter().zip(b).map(|(a, b)| (a - b).abs() / scale).fold(0.0, f64::max)
    }

    #[test]
    fn plane_has_constant_slope_and_no_variance() {
        let leadr = LeadrMap::new(&map(32, 16, |s, t| 3.0 * s - 2.0 * t), Wrap::Clamp);
        for y in 1..15 {
            for x in 1..31 {
                let m = leadr.levels[0].texels[y * 32 + x];
                assert!((m.mean_slope[0] - 3.0).abs() < 1e-5 && (m.mean_slope[1] + 2.0).abs() < 1e-5, "{m:?}");
                assert!(m.slope_covariance().iter().all(|v| v.abs() < 1e-5), "{m:?}");
            }
        }
        // Level 1 is still a plane, except at the clamped edge.
        let m = leadr.levels[1].texels[4 * 16 + 8];
        assert!((m.cross + 6.0).abs() < 1e-4 && m.slope_covariance().iter().all(|v| v.abs() < 1e-5), "{m:?}");
        // Half of an edge texel is flat.
        let edge = leadr.levels[0].texels[5 * 32];
        assert!((edge.mean_slope[0] - 1.5).abs() < 1e-5 && (edge.second[0] - 4.5).abs() < 1e-4, "{edge:?}");
    }

    #[test]
    fn sine_has_the_closed_form_moments() {
        let (n, amplitude, periods) = (256, 0.3, 5.0);
        let k = TAU * periods;
        let leadr = LeadrMap::new(&map(n, 64, |s, _| amplitude * (k * s).sin()), Wrap::Repeat);
        let m = leadr.mean();
        // The exact slope between two texels is A cos(k s) * 2n sin(k / 2n).
        let seen = 2.0 * f64::from(n) * (k / (2.0 * f64::from(n))).sin();
        let discrete = amplitude * amplitude * seen * seen / 2.0;
        assert!((f64::from(m.second[0]) / discrete - 1.0).abs() < 1e-5, "{m:?} {discrete}");
        let continuous = amplitude * amplitude * k * k / 2.0;
        assert!((f64::from(m.second[0]) / continuous - 1.0).abs() < 2e-3, "{m:?} {continuous}");
        assert!(m.mean_slope[0].abs() < 1e-5 && m.second[1] == 0.0 && m.cross.abs() < 1e-6, "{m:?}");
    }

    #[test]
    fn waves_of_few_texels_are_as_flat_as_noted() {
        for (texels_per_period, factor) in [(8.0, 0.950), (32.0, 0.9968)] {
            let k = TAU * 256.0 / texels_per_period;
            let m = LeadrMap::new(&map(256, 4, |s, _| (k * s).sin()), Wrap::Repeat).mean();
            let seen = f64::from(m.second[0]) / (k * k / 2.0);
            assert!((seen - factor).abs() < 5e-4, "{texels_per_period}: {seen}");
        }
    }

    #[test]
    fn diagonal_wave_has_full_correlation() {
        let k = TAU * 4.0;
        let m = LeadrMap::new(&map(128, 128, |s, t| 0.1 * (k * (s - t)).sin()), Wrap::Repeat).mean();
        let [xx, yy, xy] = m.slope_covariance();
        // A triangle has the slope `s` of its edge along one axis, and `s cos(k/2n)` along the other.
        let cosine = (0.5 * k / 128.0).cos();
        let expected = 2.0 * cosine * cosine / (1.0 + cosine * cosine);
        assert!((xx / yy - 1.0).abs() < 1e-5 && (xy / xx + expected).abs() < 1e-5, "{m:?}");
    }

    #[test]
    fn steep_and_flat_slopes_keep_their_variance() {
        // The ripple on a slope of 100 has slope variance 0.5. The variance would be lost in 16 bits, but must not be lost
        // in 32 bits.
        let (n, k) = (512, TAU * 16.0);
        let leadr = LeadrMap::new(&map(n, 8, |s, _| 100.0 * s + (k * s).sin() / k), Wrap::Clamp);
        let level = &leadr.levels[5];
        assert_eq!((level.width, level.height), (16, 1));
        let [xx, ..] = level.texels[8].slope_covariance();
        let seen = (0.5 * k / f64::from(n)).sin() / (0.5 * k / f64::from(n));
        assert!((xx - seen * seen / 2.0).abs() < 5e-3, "variance {xx}");
        // The test surface is a nearly flat ripple.
        let leadr = LeadrMap::new(&map(n, 8, |s, _| 1e-6 * (k * s).sin() / k), Wrap::Repeat);
        let [xx, ..] = leadr.mean().slope_covariance();
        assert!((xx / (1e-12 * seen * seen / 2.0) - 1.0).abs() < 1e-3, "variance {xx}");
    }

    #[test]
    fn mips_conserve_every_mean_at_any_size() {
        for (w, h) in [(64, 64), (37, 23), (1, 19), (100, 3), (1, 1), (7, 128)] {
            let bumpy = map(w, h, |s, t| 0.2 * (TAU * (3.0 * s + 1.0)).sin() + 0.1 * (9.0 * s * t).cos() + t * t);
            let leadr = LeadrMap::new(&bumpy, Wrap::Repeat);
            let last = leadr.levels.last().unwrap();
            assert_eq!((last.width, last.height), (1, 1));
            assert_eq!(leadr.levels.len() as u32, w.max(h).ilog2() + 1);
            for level in 0..leadr.levels.len() {
                assert!(mean_error(&leadr, level) < 1e-6, "{w}x{h} level {level}: {}", mean_error(&leadr, level));
            }
        }
        // The check must detect a broken map.
        let mut broken = LeadrMap::new(&map(37, 23, |s, t| s * t), Wrap::Repeat);
        broken.levels[2].texels[3].second[0] += 0.01;
        assert!(mean_error(&broken, 2) > 1e-6);
    }

    #[test]
    fn coverage_weighs_every_texel_once() {
        for (from, to) in [(7, 3), (3, 1), (8, 4), (1, 1), (1023, 511)] {
            let taps = Taps::of_level(from);
            assert_eq!(taps.len(), to as usize);
            for (taps, cover) in taps.iter().zip(coverage(from, to)) {
                let taps: Vec<_> = taps.weighted().collect();
                assert_eq!(taps.len(), cover.len());
                assert!(taps.iter().zip(cover).all(|(a, b)| a.0 == b.0 && (f64::from(a.1) - b.1).abs() < 1e-7));
            }
            let mut weight = vec![0.0; from as usize];
            for cover in coverage(from, to) {
                assert!((cover.iter().map(|c| c.1).sum::<f64>() - 1.0).abs() < 1e-12);
                cover.iter().for_each(|&(i, w)| weight[i] += w);
            }
            assert!(weight.iter().all(|w| (w - f64::from(to) / f64::from(from)).abs() < 1e-12));
        }
    }

    #[test]
    fn height_scale_goes_squared_into_second_moments() {
        let bumpy = |scale: f64| map(16, 16, move |s, t| scale * ((TAU * s).sin() + (TAU * t).cos() + 0.5));
        let a = LeadrMap::new(&bumpy(3.0), Wrap::Repeat).levels[1].texels[5];
        let b = LeadrMap::new(&bumpy(1.0), Wrap::Repeat).levels[1].texels[5].scaled(3.0);
        let (a, b): ([f32; 6], [f32; 6]) = (bytemuck::cast(a), bytemuck::cast(b));
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * a.abs().max(1.0)), "{a:?} {b:?}");
    }
}
