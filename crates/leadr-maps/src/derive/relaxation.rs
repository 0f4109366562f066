//! Heights of slopes by relaxation, coarse levels first (Chan 2018, section 4.2 and algorithm 5).
//!
//! Each texel takes the mean of what its four neighbours and the slopes between them say. That is a Gauss-Seidel step for the five-point
//! Laplacian, the normal equation of [`heights_of_slopes`](super::heights_of_slopes) at smoothness 1. Texels are visited in the order of a chessboard, red before black.
//!
//! **What differs from the algorithm as it is printed.** `Dy` is `−n.y / n.z`, not `−n.x / n.z` without a sign. A neighbour to the right or below
//! stands higher by the slope, so what it says of the texel is its height *minus* the slope: `R` and `D` lack the sign. Slopes are per texel, so those of
//! a level of half the size are twice as steep; averaging alone leaves heights half as high. `H''` is written to another map than is read, which is Jacobi's
//! iteration: waves of two texels do not decay by it.
//!
//! **Where it ends.** Heights of a coarse level, made larger, are off by what that level could not hold; that error is smooth, and relaxation barely touches
//! smooth errors. So further *cycles* solve for the error itself on coarse levels (a multigrid V-cycle).

use rayon::prelude::*;

use super::heights::Given;
use super::slopes::{Difference, Slopes};
use crate::moments::Taps;
use crate::{HeightMap, MapFault, Wrap};

/// How long heights are relaxed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Relaxation {
    /// What lies beyond the edges.
    pub wrap: Wrap,
    /// How the heights will become slopes.
    pub difference: Difference,
    /// Visits of every texel of a level, each time the level is solved.
    pub sweeps: u32,
    /// Cycles after the first pass through all levels, which is the algorithm of the paper.
    pub cycles: u32,
}

impl Default for Relaxation {
    fn default() -> Self {
        Self { wrap: Wrap::Repeat, difference: Difference::Triangles, sweeps: 3, cycles: 4 }
    }
}

/// Heights in widths of the texture, about 0, of slopes whose mean is left out where the map repeats. `progress` is told the share that is
/// done.
///
/// # Errors
/// If heights are beyond what maps hold.
pub fn relaxed_heights(slopes: &Slopes, how: &Relaxation, progress: &dyn Fn(f32)) -> Result<HeightMap, MapFault> {
    let (width, height) = (slopes.width as usize, slopes.height as usize);
    let mean = slopes.mean().map(|v| v as f32);
    let mut image = vec![0.0; width * height];
    let mut levels = vec![Level::new(width, height, [1.0; 2], how.wrap)];
    levels[0].want(slopes, how, &mut image);
    let mut averaged: Option<Slopes> = None;
    while let Some(mut next) = levels[levels.len() - 1].half() {
        let coarse = half(averaged.as_ref().unwrap_or(slopes));
        next.want(&coarse, how, &mut image);
        averaged = Some(coarse);
        levels.push(next);
    }
    drop(averaged);
    for k in (0..levels.len()).rev() {
        if k + 1 < levels.len() {
            let (fine, coarse) = levels.split_at_mut(k + 1);
            fine[k].heights.add_enlarged(&coarse[0].heights, how.wrap);
        }
        levels[k].relax(how.sweeps);
    }
    for cycle in 0..how.cycles {
        progress((1.0 + cycle as f32) / (2.0 + how.cycles as f32));
        correct(&mut levels, how.sweeps);
    }
    let heights = &levels[0].heights;
    let middle = (heights.sum() / (width * height) as f64) as f32;
    let plane = if how.wrap == Wrap::Clamp { mean } else { [0.0; 2] };
    image.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let from_middle = |k: usize, of: usize| k as f32 - 0.5 * (of as f32 - 1.0);
        let of_row = plane[1] * from_middle(y, height) - middle;
        for (x, (texel, h)) in row.iter_mut().zip(heights.row(y)).enumerate() {
            *texel = (h + of_row + plane[0] * from_middle(x, width)) / width as f32;
        }
    });
    progress(1.0);
    HeightMap::new(slopes.width, slopes.height, image)
}

/// The mean slopes of a level of half the size.
fn half(slopes: &Slopes) -> Slopes {
    let (columns, rows) = (Taps::of_level(slopes.width), Taps::of_level(slopes.height));
    let mut texels = vec![[0.0; 2]; columns.len() * rows.len()];
    texels.par_chunks_mut(columns.len()).zip(&rows).for_each(|(out, row)| {
        for (out, column) in out.iter_mut().zip(&columns) {
            for (y, down) in row.weighted() {
                for (x, across) in column.weighted() {
                    let slope = slopes.texels[y * slopes.width as usize + x];
                    (0..2).for_each(|i| out[i] += down * across * slope[i]);
                }
            }
        }
    });
    Slopes { width: columns.len() as u32, height: rows.len() as u32, texels, faults: slopes.faults }
}

/// One V-cycle.
fn correct(levels: &mut [Level], sweeps: u32) {
    levels[0].relax(sweeps);
    if let Some((fine, coarse)) = levels.split_first_mut()
        && !coarse.is_empty()
    {
        coarse[0].wanted = fine.residual().averaged();
        coarse[0].heights.clear();
        correct(coarse, sweeps);
        fine.heights.add_enlarged(&coarse[0].heights, fine.wrap);
        fine.relax(sweeps);
    }
}

/// An image whose even and odd rows lie apart, so that rows of one kind can be written on all cores while those of the other are read.
#[derive(Clone, Debug)]
struct Board {
    width: usize,
    height: usize,
    rows: [Vec<f32>; 2],
}

impl Board {
    fn new(width: usize, height: usize) -> Self {
        Self { width, height, rows: [width * height.div_ceil(2), width * (height / 2)].map(|n| vec![0.0; n]) }
    }

    fn row(&self, y: usize) -> &[f32] {
        &self.rows[y % 2][y / 2 * self.width..][..self.width]
    }

    fn clear(&mut self) {
        self.rows.iter_mut().for_each(|rows| rows.fill(0.0));
    }

    /// Writes all rows, by their index.
    fn write(&mut self, write: impl Fn(usize, &mut [f32]) + Sync) {
        let width = self.width;
        for (odd, rows) in self.rows.iter_mut().enumerate() {
            rows.par_chunks_mut(width).enumerate().with_min_len(16).for_each(|(k, row)| write(2 * k + odd, row));
        }
    }

    fn fill(&mut self, image: &[f32]) {
        let width = self.width;
        self.write(|y, row| row.copy_from_slice(&image[y * width..][..width]));
    }

    fn sum(&self) -> f64 {
        (0..self.height).map(|y| self.row(y).iter().map(|&v| f64::from(v)).sum::<f64>()).sum()
    }

    /// The level of half the size, by area.
    fn averaged(&self) -> Self {
        let (columns, rows) = (Taps::of_level(self.width as u32), Taps::of_level(self.height as u32));
        let mut half = Self::new(columns.len(), rows.len());
        half.write(|y, out| {
            for (out, column) in out.iter_mut().zip(&columns) {
                let sum = |row: &[f32]| column.weighted().map(|(x, weight)| weight * row[x]).sum::<f32>();
                *out = rows[y].weighted().map(|(y, weight)| weight * sum(self.row(y))).sum();
            }
        });
        half
    }

    /// Adds a coarser image, bilinearly between its texels.
    fn add_enlarged(&mut self, coarse: &Self, wrap: Wrap) {
        let (width, height) = (self.width, self.height);
        let between = |k: usize, of: usize, from: usize| {
            let place = (k as f64 + 0.5) * from as f64 / of as f64 - 0.5;
            let low = place.floor();
            let at = |step: i64| wrap.texel(low as i64 + step, from as u32);
            (at(0), at(1), (place - low) as f32)
        };
        let columns: Vec<_> = (0..width).map(|x| between(x, width, coarse.width)).collect();
        self.write(|y, row| {
            let (a, b, down) = between(y, height, coarse.height);
            let (a, b) = (coarse.row(a), coarse.row(b));
            for (out, &(x0, x1, across)) in row.iter_mut().zip(&columns) {
                let (left, right) = (a[x0] + down * (b[x0] - a[x0]), a[x1] + down * (b[x1] - a[x1]));
                *out += left + across * (right - left);
            }
        });
    }
}

/// Heights of a level and the Laplacian that is wanted of them, with the sign of `Dᵀ D`.
struct Level {
    heights: Board,
    wanted: Board,
    /// Squares of a texel's sides, inverted, those of the finest level being 1.
    weights: [f32; 2],
    wrap: Wrap,
}

impl Level {
    fn new(width: usize, height: usize, weights: [f32; 2], wrap: Wrap) -> Self {
        Self { heights: Board::new(width, height), wanted: Board::new(width, height), weights, wrap }
    }

    /// Takes what is wanted from slopes of its size; `image` is used to work in.
    fn want(&mut self, slopes: &Slopes, how: &Relaxation, image: &mut [f32]) {
        let per_texel = self.weights.map(f32::sqrt);
        let mean = slopes.mean().map(|v| v as f32);
        let given = Given { slopes, mean, wrap: how.wrap, difference: how.difference, per_texel };
        let image = &mut image[..slopes.texels.len()];
        given.divergence(image);
        self.wanted.fill(image);
    }

    fn half(&self) -> Option<Self> {
        let size = [self.heights.width, self.heights.height];
        if size == [1, 1] {
            return None;
        }
        let [w, h] = size.map(|n| (n / 2).max(1));
        let weight = |i: usize, n: usize| self.weights[i] * (n as f32 / size[i] as f32).powi(2);
        Some(Self::new(w, h, [weight(0, w), weight(1, h)], self.wrap))
    }

    /// Weights of the neighbours before and after: one beyond an edge that does not repeat has none, nor has the texel itself.
    fn ends(&self, axis: usize, k: usize) -> [f32; 2] {
        let last = [self.heights.width, self.heights.height][axis] - 1;
        let open = |edge: bool| if edge && (last == 0 || self.wrap == Wrap::Clamp) { 0.0 } else { self.weights[axis] };
        [open(k == 0), open(k == last)]
    }

    /// `wanted − Dᵀ D heights`.
    fn residual(&self) -> Board {
        let (w, h) = (self.heights.width, self.heights.height);
        let mut left = Board::new(w, h);
        left.write(|y, out| {
            let rows = [y + h - 1, y, y + 1].map(|y| self.heights.row(y % h));
            let [up, down] = self.ends(1, y);
            for (x, (out, wanted)) in out.iter_mut().zip(self.wanted.row(y)).enumerate() {
                let [before, after] = self.ends(0, x);
                let here = rows[1][x];
                let previous = rows[1][if x == 0 { w - 1 } else { x - 1 }];
                let next = rows[1][if x + 1 == w { 0 } else { x + 1 }];
                let sum = before * (previous - here) + after * (next - here);
                *out = wanted + sum + up * (rows[0][x] - here) + down * (rows[2][x] - here);
            }
        });
        left
    }

    fn relax(&mut self, sweeps: u32) {
        for _ in 0..sweeps {
            for color in 0..2 {
                for odd in 0..2 {
                    self.relax_rows(odd, color ^ odd);
                }
            }
        }
    }

    /// Visits every second texel, from `first` on, of the even or odd rows.
    fn relax_rows(&mut self, odd: usize, first: usize) {
        let (w, h) = (self.heights.width, self.heights.height);
        if odd >= h {
            return;
        }
        // Where an odd number of rows repeats, the last one's neighbour is of its own kind.
        let seam = [h - 1, 0].map(|y| self.heights.row(y).to_vec());
        let mut own = std::mem::take(&mut self.heights.rows[odd]);
        let other = &self.heights;
        let neighbour = |y: usize| match y {
            _ if y % 2 != odd => other.row(y),
            0 => &seam[1][..],
            _ => &seam[0][..],
        };
        own.par_chunks_mut(w).enumerate().with_min_len(16).for_each(|(k, row)| {
            let y = 2 * k + odd;
            let (above, below) = (neighbour((y + h - 1) % h), neighbour((y + 1) % h));
            let [up, down] = self.ends(1, y);
            let wanted = self.wanted.row(y);
            for x in (first..w).step_by(2) {
                let [before, after] = self.ends(0, x);
                let all = before + after + up + down;
                if all > 0.0 {
                    let previous = row[if x == 0 { w - 1 } else { x - 1 }];
                    let next = row[if x + 1 == w { 0 } else { x + 1 }];
                    let sum = before * previous + after * next + up * above[x] + down * below[x];
                    row[x] = (sum + wanted[x]) / all;
                }
            }
        });
        self.heights.rows[odd] = own;
    }
}

#[cfg(test)]
mod tests {
    use super::super::heights::{Integration, heights_of_slopes};
    use super::super::slopes::slopes_of_heights;
    use super::*;

    /// Hills of several sizes over a map.
    fn hills(width: u32, height: u32) -> Slopes {
        let texel = |i: u32| {
            let [s, t] = [(i % width) as f32 / width as f32, (i / width) as f32 / height as f32]
                .map(|v| v * std::f32::consts::TAU);
            0.05 * s.sin()
                + 0.03 * (2.0 * t + s).cos()
                + 0.01 * (7.0 * s - 5.0 * t).sin()
                + 0.002 * ((i * 7919) % 101) as f32 / 101.0
        };
        let map = HeightMap::new(width, height, (0..width * height).map(texel).collect()).unwrap();
        slopes_of_heights(&map, 1.0, Wrap::Clamp, Difference::Central)
    }

    fn error(slopes: &Slopes, how: Relaxation) -> f64 {
        let relaxed = relaxed_heights(slopes, &how, &|_| {}).unwrap();
        let direct = Integration { wrap: how.wrap, difference: how.difference, smoothness: 1.0 };
        let direct = heights_of_slopes(slopes, &direct, &|_| {}).unwrap().heights;
        let mut sums = [0.0; 2];
        for (a, b) in relaxed.texels.iter().zip(&direct.texels) {
            let (a, b) = (f64::from(*a), f64::from(*b));
            sums = [sums[0] + (a - b).powi(2), sums[1] + b * b];
        }
        (sums[0] / sums[1].max(1e-30)).sqrt()
    }

    #[test]
    fn cycles_end_at_the_direct_solution() {
        for (width, height) in [(128, 128), (96, 40), (77, 51), (1, 64), (64, 1), (3, 5)] {
            let slopes = hills(width, height);
            for wrap in [Wrap::Repeat, Wrap::Clamp] {
                for difference in [Difference::Triangles, Difference::Central, Difference::Forward] {
                    let of = |cycles| error(&slopes, Relaxation { wrap, difference, sweeps: 3, cycles });
                    let errors = [0, 3, 12].map(of);
                    let what = format!("{width} x {height} {wrap:?} {difference:?}: {errors:?}");
                    assert!(errors[1] < 0.03 && errors[2] < 2e-4, "{what}");
                    assert!(errors[1] < 0.3 * errors[0] || errors[0] < 1e-3, "{what}");
                }
            }
        }
    }

    #[test]
    fn one_texel_has_no_height() {
        let slopes = Slopes::new(1, 1, vec![[1.0, -1.0]]).unwrap();
        assert_eq!(relaxed_heights(&slopes, &Relaxation::default(), &|_| {}).unwrap().texels, [0.0]);
    }
}
