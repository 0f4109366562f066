//! Horizons of a height map. The horizon around each texel is fitted by the smooth function of
//! [`leadr_reflectance::visible::horizon`].
//!
//! Rays leave every texel in 8 or 16 directions. Each ray keeps the largest excess of the heights over the plane of the
//! texel's mean slope `m`: `(h(p + o) − h(p) − m·o) / |o|`, at least 0. Samples lie 1.5, 2, 3, 4, 6, 8, 12 … texels away.
//! Nearer heights belong to the texel's own slope statistics. The heights at a sample are smoothed over a quarter of its
//! distance.

use std::f32::consts::PI;

use rayon::prelude::*;

use super::Wrap;
use super::halves::half;

/// The source text of this module, which is part of cache keys.
pub const SOURCE: &str = include_str!("horizon.rs");

const LONGEST: usize = 512;

/// Row-major heights with their wrap mode.
pub struct Heights<'a> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) texels: &'a [f32],
    pub(crate) wrap: Wrap,
    /// The row stride, if the rows of a map are concatenated into a single row.
    stride: Option<usize>,
}

impl<'a> Heights<'a> {
    /// Creates a view of `width * height` row-major heights.
    pub fn new(width: usize, height: usize, texels: &'a [f32], wrap: Wrap) -> Self {
        Self { width, height, texels, wrap, stride: None }
    }
}

/// A rectangle of texels to compute.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// The first column of the rectangle.
    pub x: usize,
    /// The first row of the rectangle.
    pub y: usize,
    /// The number of columns.
    pub width: usize,
    /// The number of rows.
    pub height: usize,
}

/// The horizon of a texel, in units of height per texel. See [`leadr_reflectance::visible::horizon::Horizon`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HorizonTexel {
    /// The odd part of the horizon, which is the linear term of the excess.
    pub(crate) lean: [f32; 2],
    /// The standard deviations of the even part of the horizon.
    pub(crate) deviations: [f32; 2],
    /// The correlation of the even part of the horizon, from -1 to 1.
    pub(crate) correlation: f32,
}

impl HorizonTexel {
    /// Converts the horizon to 4 + 1 half floats for a map of `size` texels. Lengths are then in map widths.
    pub fn halves(&self, size: [u32; 2]) -> ([u16; 4], u16) {
        let half = |v: f32| half(v).to_bits();
        let [w, h] = size.map(|n| n as f32);
        let ([lx, ly], [dx, dy]) = (self.lean, self.deviations);
        ([lx * w, ly * h, dx * w, dy * h].map(half), half(self.correlation))
    }
}

fn distance_of(step: usize) -> f32 {
    if step == 0 { 1.5 } else { (1usize << step.div_ceil(2)) as f32 * if step.is_multiple_of(2) { 1.5 } else { 1.0 } }
}

/// Returns the number of smoothing passes for the heights that a sample step reads.
fn smoothness_of(step: usize) -> usize {
    step.saturating_sub(3) / 2
}

/// The rays that search for the horizon.
#[derive(Clone, Copy, Debug)]
pub struct Rays {
    /// The number of pairs of opposite directions, at least 3.
    pub axes: usize,
    /// The length of a ray in texels.
    pub reach: usize,
}

/// Computes the row-major horizons of the texels in a window. `slopes` are the mean slopes of the window's texels, in units
/// of height per texel.
pub fn horizons(heights: &Heights<'_>, window: Window, slopes: &[[f32; 2]], rays: Rays) -> Vec<HorizonTexel> {
    let Rays { axes, reach } = rays;
    if let Some(texels) = horizons_inside(heights, window, slopes, rays) {
        return texels;
    }
    let steps = (0..).take_while(|&step| distance_of(step) <= reach.min(LONGEST) as f32).count();
    let smooth = smoothed(heights, smoothness_of(steps.saturating_sub(1)));
    let field = |step: usize| match smoothness_of(step) {
        0 => heights.texels,
        k => &smooth[k - 1],
    };
    let mut texels = vec![HorizonTexel::default(); window.width * window.height];
    let rows = texels.par_chunks_mut(window.width.max(1)).enumerate().with_min_len(4);
    rows.for_each_init(
        || Row::new(window.width),
        |row, (k, out)| {
            let y = window.y + k;
            let here = &heights.texels[y * heights.width + window.x..][..window.width];
            let [across, down] = &mut row.slopes;
            for ((sx, sy), slope) in across.iter_mut().zip(down).zip(&slopes[k * window.width..]) {
                (*sx, *sy) = (slope[0], slope[1]);
            }
            row.sums.fill([0.0; 5]);
            for axis in 0..axes {
                let azimuth = PI * (axis as f32 + 0.5) / axes as f32;
                let v = [azimuth.cos(), azimuth.sin()];
                row.excess.iter_mut().for_each(|excess| excess.fill(0.0));
                for step in 0..steps {
                    for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
                        let far = distance_of(step) * sign;
                        let offset = v.map(|v| v * far);
                        let offset = if far.abs() < 4.0 { offset } else { offset.map(f32::round) };
                        row.there.fetch(heights, field(step), [window.x, y], offset);
                        row.raise(here, side, offset);
                    }
                }
                row.add(v, [(2.0 * azimuth).cos(), (2.0 * azimuth).sin()]);
            }
            for (out, sums) in out.iter_mut().zip(&row.sums) {
                *out = fitted(sums.map(|sum| sum / axes as f32));
            }
        },
    );
    texels
}

/// A fast path for small windows whose rays stay inside the map. The rows are treated as one long row, so that a row offset
/// becomes a column offset.
fn horizons_inside(
    heights: &Heights<'_>,
    window: Window,
    slopes: &[[f32; 2]],
    rays: Rays,
) -> Option<Vec<HorizonTexel>> {
    let Window { x, y, width, height } = window;
    let (margin, stride) = (rays.reach + 2, heights.width);
    let inside = |start: usize, len: usize, all: usize| start >= margin && start + len + margin <= all;
    if height < 2 || !inside(x, width, stride) || !inside(y, height, heights.height) || heights.stride.is_some() {
        return None;
    }
    let line = Heights { width: heights.texels.len(), height: 1, stride: Some(stride), ..*heights };
    let span = Window { x: y * stride + x, y: 0, width: (height - 1) * stride + width, height: 1 };
    let mut spread = vec![[0.0; 2]; span.width];
    for (row, slopes) in slopes.chunks_exact(width).enumerate() {
        spread[row * stride..][..width].copy_from_slice(slopes);
    }
    let found = horizons(&line, span, &spread, rays);
    Some((0..height).flat_map(|row| found[row * stride..][..width].iter().copied()).collect())
}

struct Row {
    slopes: [Vec<f32>; 2],
    /// The largest excess so far ahead of the texel, and the largest behind it.
    excess: [Vec<f32>; 2],
    sums: Vec<[f32; 5]>,
    there: Sampled,
}

impl Row {
    fn new(width: usize) -> Self {
        let zeros = || vec![0.0f32; width];
        Self {
            slopes: [zeros(), zeros()],
            excess: [zeros(), zeros()],
            sums: vec![[0.0; 5]; width],
            there: Sampled::new(width),
        }
    }

    /// Raises the excess ahead (0) or behind (1) to the excess of the heights at `offset`.
    fn raise(&mut self, here: &[f32], side: usize, offset: [f32; 2]) {
        let per = 1.0 / offset[0].hypot(offset[1]);
        let [ux, uy] = offset.map(|v| v * per);
        let heights = self.there.values.iter().zip(here);
        let slopes = self.slopes[0].iter().zip(&self.slopes[1]);
        for (excess, ((there, here), (sx, sy))) in self.excess[side].iter_mut().zip(heights.zip(slopes)) {
            let found = (there - here) * per - (sx * ux + sy * uy);
            *excess = if found > *excess { found } else { *excess };
        }
    }

    /// Adds the terms of two opposite directions to the sums for the fit. `v` is the direction ahead, and `harmonics` are
    /// the cosine and sine of twice the azimuth of `v`.
    fn add(&mut self, v: [f32; 2], harmonics: [f32; 2]) {
        for (sums, (ahead, behind)) in self.sums.iter_mut().zip(self.excess[0].iter().zip(&self.excess[1])) {
            let (more, mean) = (ahead - behind, 0.5 * (ahead + behind));
            let square = mean * mean;
            let added = [more * v[0], more * v[1], square, square * harmonics[0], square * harmonics[1]];
            for (sum, added) in sums.iter_mut().zip(added) {
                *sum += added;
            }
        }
    }
}

/// Fits the smooth function to means over pairs of opposite directions `v`. The averaged quantities are `(ahead − behind)
/// v`, the square of `(ahead + behind) / 2`, and the second harmonics of the square.
fn fitted([lx, ly, square, c, s]: [f32; 5]) -> HorizonTexel {
    // The second harmonics have a factor of 2, which is reduced where the fit would be negative in some direction.
    let part = 2.0f32.min(square / c.hypot(s).max(1e-30));
    let [c, s] = [c * part, s * part];
    let deviations = [square + c, square - c].map(|v| v.max(0.0).sqrt());
    let correlation = (s / (deviations[0] * deviations[1]).max(1e-30)).clamp(-1.0, 1.0);
    HorizonTexel { lean: [lx, ly], deviations, correlation }
}

/// A row of heights at a constant offset from a row of texels.
pub(super) struct Sampled {
    pub(super) values: Vec<f32>,
    rows: [Vec<f32>; 2],
}

impl Sampled {
    pub(super) fn new(width: usize) -> Self {
        Self { values: vec![0.0; width], rows: [vec![0.0; width + 1], vec![0.0; width + 1]] }
    }

    /// Fills `values` with the heights at `offset` from consecutive texels, the first of which is `start`. The heights in
    /// `texels` are interpolated bilinearly.
    pub(super) fn fetch(&mut self, heights: &Heights<'_>, texels: &[f32], start: [usize; 2], offset: [f32; 2]) {
        let whole = offset.map(f32::floor);
        let [fx, fy] = [offset[0] - whole[0], offset[1] - whole[1]];
        let start_of = |row: i64| {
            let [x, y] = [start[0] as i64 + whole[0] as i64, start[1] as i64 + whole[1] as i64 + row];
            heights.stride.map_or([x, y], |stride| [x + y * stride as i64, 0])
        };
        if fx == 0.0 && fy == 0.0 {
            copy_row(heights, texels, start_of(0), &mut self.values);
            return;
        }
        for (k, row) in self.rows.iter_mut().enumerate() {
            copy_row(heights, texels, start_of(k as i64), row);
        }
        let [a, b] = &self.rows;
        let pairs = a.iter().zip(&a[1..]).zip(b.iter().zip(&b[1..]));
        for (value, ((a0, a1), (b0, b1))) in self.values.iter_mut().zip(pairs) {
            // This form of the interpolation keeps constant heights bit-exact.
            let (a, b) = (a0 + fx * (a1 - a0), b0 + fx * (b1 - b0));
            *value = a + fy * (b - a);
        }
    }
}

/// Copies texels of row `y`, beginning at column `x`. The row and the columns may lie outside the map.
fn copy_row(heights: &Heights<'_>, texels: &[f32], [x, y]: [i64; 2], into: &mut [f32]) {
    let (w, n) = (heights.width as i64, into.len());
    let row = &texels[heights.wrap.texel(y, heights.height as u32) * heights.width..][..heights.width];
    if x >= 0 && x + n as i64 <= w {
        into.copy_from_slice(&row[x as usize..x as usize + n]);
        return;
    }
    let mut done = 0;
    while done < n {
        let at = x + done as i64;
        let from = heights.wrap.texel(at, heights.width as u32);
        let inside = (0..w).contains(&at) || heights.wrap == Wrap::Repeat;
        let count = if inside { (n - done).min(heights.width - from) } else { 1 };
        into[done..done + count].copy_from_slice(&row[from..from + count]);
        done += count;
    }
}

/// Returns the heights after 1, 2, … smoothing passes. Each pass uses the weights 1/4, 1/2, 1/4 along both axes. The spacing
/// doubles with each pass.
fn smoothed(heights: &Heights<'_>, times: usize) -> Vec<Vec<f32>> {
    let (width, rows) =
        heights.stride.map_or((heights.width, heights.height), |stride| (stride, heights.width / stride));
    let heights = &Heights::new(width, rows, heights.texels, heights.wrap);
    let mut levels: Vec<Vec<f32>> = Vec::with_capacity(times);
    for k in 0..times {
        let apart = 1i64 << k;
        let source = levels.last().map_or(heights.texels, |level| &level[..]);
        let mut level = vec![0.0f32; source.len()];
        level.par_chunks_mut(heights.width.max(1)).enumerate().with_min_len(16).for_each(|(y, out)| {
            let mut row = vec![0.0f32; heights.width];
            let mut side = vec![0.0f32; heights.width];
            // Each pass filters along columns, then along rows.
            for (apart, weight) in [(-apart, 0.25f32), (0, 0.5), (apart, 0.25)] {
                copy_row(heights, source, [0, y as i64 + apart], &mut side);
                row.iter_mut().zip(&side).for_each(|(sum, &v)| *sum += weight * v);
            }
            let columns = Heights::new(heights.width, 1, &row, heights.wrap);
            for (apart, weight) in [(-apart, 0.25f32), (0, 0.5), (apart, 0.25)] {
                copy_row(&columns, &row, [apart, 0], &mut side);
                out.iter_mut().zip(&side).for_each(|(sum, &v)| *sum += weight * v);
            }
        });
        levels.push(level);
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the excess of a texel's horizon at an azimuth in radians.
    fn excess(texel: &HorizonTexel, azimuth: f32) -> f32 {
        let v = [azimuth.cos(), azimuth.sin()];
        let [x, y] = [v[0] * texel.deviations[0], v[1] * texel.deviations[1]];
        let square = x * x + y * y + 2.0 * texel.correlation * x * y;
        texel.lean[0] * v[0] + texel.lean[1] * v[1] + square.max(0.0).sqrt()
    }

    fn of(width: usize, wrap: Wrap, height: impl Fn(usize, usize) -> f32, reach: usize) -> Vec<HorizonTexel> {
        let texels: Vec<f32> = (0..width * width).map(|k| height(k % width, k / width)).collect();
        let heights = Heights::new(width, width, &texels, wrap);
        let window = Window { x: 0, y: 0, width, height: width };
        horizons(&heights, window, &vec![[0.0; 2]; width * width], Rays { axes: 8, reach })
    }

    #[test]
    fn flat_ground_has_no_horizon() {
        assert!(of(32, Wrap::Repeat, |_, _| 3.0, 16).iter().all(|texel| *texel == HorizonTexel::default()));
    }

    #[test]
    fn wall_horizon_matches_its_height() {
        // The ground is at height 0, and a wall of height 6 begins at column 40.
        let texels = of(64, Wrap::Clamp, |x, _| if x < 40 { 0.0 } else { 6.0 }, 24);
        let texel = &texels[32 * 64 + 32];
        let seen = excess(texel, 0.0);
        assert!((0.55..0.85).contains(&seen), "{seen} for a wall of 6 at 8");
        assert!(excess(texel, PI) < 0.1 && excess(texel, PI) > -0.1);
        // On top of the wall the horizon is empty.
        let texel = &texels[32 * 64 + 50];
        assert!(excess(texel, 0.0).abs() < 1e-3 && excess(texel, PI).abs() < 1e-3, "{texel:?}");
    }

    #[test]
    fn a_valley_is_closed_across_and_open_along() {
        let texels = of(64, Wrap::Repeat, |x, _| 4.0 * (1.0 + (x as f32 * PI / 16.0).cos()), 32);
        let texel = &texels[20 * 64 + 16];
        let (across, along) = (excess(texel, 0.0), excess(texel, 0.5 * PI));
        assert!(across > 0.4 && along < 0.25 * across, "{across} across, {along} along");
        assert!(texel.lean[0].abs() < 1e-3 && texel.lean[1].abs() < 1e-3);
    }

    #[test]
    fn windows_and_repeated_maps_agree() {
        let height = |x: usize, y: usize| ((x * 7 + y * 13) % 11) as f32 + (y as f32 * 0.3).sin();
        let whole = of(32, Wrap::Repeat, height, 12);
        let texels: Vec<f32> = (0..96 * 96).map(|k| height(k % 96 % 32, k / 96 % 32)).collect();
        let heights = Heights::new(96, 96, &texels, Wrap::Clamp);
        let window = Window { x: 32, y: 32, width: 32, height: 32 };
        for (a, b) in whole.iter().zip(horizons(&heights, window, &[[0.0; 2]; 32 * 32], Rays { axes: 8, reach: 12 })) {
            assert!((a.lean[0] - b.lean[0]).abs() < 1e-4 && (a.deviations[1] - b.deviations[1]).abs() < 1e-4);
        }
    }
}
