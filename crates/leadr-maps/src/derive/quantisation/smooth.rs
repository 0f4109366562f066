//! The surface with the least bending energy within half a code, found from coarse to fine.

use rayon::prelude::*;

use super::Grid;
use crate::Wrap;

/// The number of descent steps on each level.
const STEPS: usize = 40;

/// The step length, below the inverse of the largest eigenvalue of the scaled bending energy (8/3).
const STEP: f32 = 0.37;

/// The side of the coarsest level, in texels.
const COARSEST: usize = 8;

/// The distance beyond the mean and the middle of the codes in a coarse texel that its height may have.
const SLACK: f32 = 0.1;

/// The difference from a code above which the interpolated height of a coarser level is not used.
const OTHER_SIDE: f32 = 0.75;

/// One level of the pyramid. A texel holds the mean, the least and the largest code in its area.
struct Level {
    grid: Grid,
    mean: Vec<f32>,
    least: Vec<f32>,
    largest: Vec<f32>,
    /// The weights of the squared second differences along x and y, as parts of 255.
    weights: Vec<[u8; 2]>,
}

/// Returns the weight of a squared second difference of codes. Rounding alone explains differences up to 1 in a smooth
/// surface and up to 2 at most; larger ones are edges.
fn weight(second_difference: f32) -> u8 {
    let size = second_difference.abs();
    if size > 3.5 {
        return 0;
    }
    let excess = (size - 1.0).max(0.0);
    (255.0 / (1.0 + 4.0 * excess * excess)).round() as u8
}

/// Returns the weights of all texels. Second differences across the edge of a map that does not repeat have no weight.
fn weights(grid: Grid, codes: &[f32]) -> Vec<[u8; 2]> {
    let ends = |i: usize, len: usize| grid.wrap == Wrap::Clamp && (i == 0 || i + 1 == len);
    let of = |i: usize| {
        let (x, y) = (i % grid.width, i / grid.width);
        let [along_x, along_y] = grid.second_differences(codes, x, y).map(weight);
        [if ends(x, grid.width) { 0 } else { along_x }, if ends(y, grid.height) { 0 } else { along_y }]
    };
    (0..grid.len()).into_par_iter().map(of).collect()
}

impl Level {
    fn finest(grid: Grid, codes: &[f32]) -> Self {
        let copy = || codes.to_vec();
        Self { grid, mean: copy(), least: copy(), largest: copy(), weights: weights(grid, codes) }
    }

    fn halved(&self) -> Self {
        let fine = self.grid;
        let grid = Grid { width: fine.width.div_ceil(2), height: fine.height.div_ceil(2), ..fine };
        let area = |i: usize| {
            let (x, y) = (2 * (i % grid.width), 2 * (i / grid.width));
            let rows = y..(y + 2).min(fine.height);
            rows.flat_map(move |y| (x..(x + 2).min(fine.width)).map(move |x| y * fine.width + x))
        };
        let fold = |texels: &[f32], with: fn(f32, f32) -> f32| -> Vec<f32> {
            let of = |i| area(i).map(|j| texels[j]).reduce(with).unwrap_or_default();
            (0..grid.len()).into_par_iter().map(of).collect()
        };
        let count = |i: usize| area(i).count() as f32;
        let mut mean = fold(&self.mean, |a, b| a + b);
        mean.par_iter_mut().enumerate().for_each(|(i, sum)| *sum /= count(i));
        let mut weights = weights(grid, &mean);
        weights.par_iter_mut().enumerate().for_each(|(i, own)| {
            for (axis, own) in own.iter_mut().enumerate() {
                let sum: u32 = area(i).map(|j| u32::from(self.weights[j][axis])).sum();
                *own = (*own).min((sum as f32 / count(i)).round() as u8);
            }
        });
        Self { grid, mean, least: fold(&self.least, f32::min), largest: fold(&self.largest, f32::max), weights }
    }

    /// Returns the bounds of the height of a texel, in codes. A coarse texel that contains a step between two codes has its
    /// height between the mean of the codes and the height of the step, because a smooth surface crosses the step evenly.
    fn bounds(&self, i: usize) -> [f32; 2] {
        let (mean, least, largest) = (self.mean[i], self.least[i], self.largest[i]);
        let step = 0.5 * (least + largest);
        match largest - least {
            0.0 => [mean - 0.5, mean + 0.5],
            1.0 => [mean.min(step) - SLACK, mean.max(step) + SLACK],
            _ => [mean - 2.0 * SLACK, mean + 2.0 * SLACK],
        }
    }

    /// Returns the bounds of a texel of the finest level. Heights do not exceed the codes of the container, and clipped areas
    /// are flat.
    fn finest_bounds(&self, i: usize, most: Option<f32>) -> [f32; 2] {
        let [low, high] = self.bounds(i);
        let (Some(most), code) = (most, self.mean[i]) else { return [low, high] };
        if code != 0.0 && code != most {
            return [low, high];
        }
        let (x, y) = (i % self.grid.width, i / self.grid.width);
        let around = [-1, 0, 1].map(|d| self.grid.column(x, d));
        let clipped = [-1, 0, 1].iter().all(|&d| around.iter().all(|&x| self.grid.row(&self.mean, y, d)[x] == code));
        if clipped { [code, code] } else { [low.max(0.0), high.min(most)] }
    }
}

/// Returns heights with little bending energy, in codes and within half a code. `most` is the largest code of the container.
pub(super) fn smooth(grid: Grid, codes: &[f32], most: Option<f32>) -> Vec<f32> {
    let mut levels = vec![Level::finest(grid, codes)];
    while let Some(last) = levels.last()
        && last.grid.width.min(last.grid.height) > COARSEST
    {
        levels.push(last.halved());
    }
    let mut coarse: Option<(Grid, Vec<f32>)> = None;
    while let Some(level) = levels.pop() {
        let is_finest = levels.is_empty();
        let bounds = |i| if is_finest { level.finest_bounds(i, most) } else { level.bounds(i) };
        let bounds: Vec<[f32; 2]> = (0..level.grid.len()).into_par_iter().map(bounds).collect();
        let mut heights = level.mean;
        if let Some((grid, coarse)) = &coarse {
            heights.par_iter_mut().zip(&bounds).enumerate().for_each(|(i, (h, [low, high]))| {
                let start = interpolated(*grid, coarse, level.grid, i);
                // Next to an edge, the coarser level belongs to both sides of the edge.
                if (start - *h).abs() < OTHER_SIDE {
                    *h = start.clamp(*low, *high);
                }
            });
        }
        descend(level.grid, &mut heights, &bounds, &level.weights);
        coarse = Some((level.grid, heights));
    }
    coarse.expect("there is a level").1
}

/// Interpolates the heights of a level at texel `i` of the next finer level.
fn interpolated(coarse: Grid, heights: &[f32], fine: Grid, i: usize) -> f32 {
    let side = |i: usize| if i.is_multiple_of(2) { -1 } else { 1 };
    let (x, y) = (i % fine.width, i / fine.width);
    let (column, beside) = (x / 2, coarse.column(x / 2, side(x)));
    let row = |dy| {
        let row = coarse.row(heights, y / 2, dy);
        0.75 * row[column] + 0.25 * row[beside]
    };
    0.75 * row(0) + 0.25 * row(side(y))
}

/// Reduces the bending energy within `bounds` by accelerated projected gradient steps (Beck and Teboulle 2009, "FISTA").
fn descend(grid: Grid, heights: &mut [f32], bounds: &[[f32; 2]], weights: &[[u8; 2]]) {
    let width = grid.width;
    let split = |axis: usize| -> Vec<u8> { weights.par_iter().map(|pair| pair[axis]).collect() };
    let [along_x, along_y] = [0, 1].map(split);
    let mut before = heights.to_vec();
    let mut ahead = vec![0.0; heights.len()];
    for step in 0..STEPS {
        let momentum = step as f32 / (step as f32 + 3.0);
        ahead
            .par_iter_mut()
            .zip(&*heights)
            .zip(&before)
            .for_each(|((ahead, now), before)| *ahead = now + momentum * (now - before));
        let rows = heights.par_chunks_mut(width).zip(before.par_chunks_mut(width)).zip(bounds.par_chunks(width));
        rows.enumerate().for_each_init(
            || [vec![0.0; width], vec![0.0; width], vec![0.0; width]],
            |[bent, gradient, diagonal], (y, ((heights, before), bounds))| {
                before.copy_from_slice(heights);
                let ahead = [-2, -1, 0, 1, 2].map(|dy| grid.row(&ahead, y, dy));
                bend_along_x(grid, ahead[2], grid.row(&along_x, y, 0), bent, gradient, diagonal);
                bend_along_y(ahead, [-1, 0, 1].map(|dy| grid.row(&along_y, y, dy)), gradient, diagonal);
                let scaled = gradient.iter().zip(&*diagonal).map(|(gradient, diagonal)| gradient / diagonal.max(1.0));
                for (((h, bounds), ahead), scaled) in heights.iter_mut().zip(bounds).zip(ahead[2]).zip(scaled) {
                    *h = (ahead - STEP * scaled).max(bounds[0]).min(bounds[1]);
                }
            },
        );
    }
}

/// Sets the derivative and the second derivative of the bending energy along x, for the texels of a row. `bent` is scratch.
fn bend_along_x(grid: Grid, h: &[f32], w: &[u8], bent: &mut [f32], gradient: &mut [f32], diagonal: &mut [f32]) {
    let width = grid.width;
    let (h, w, bent) = (&h[..width], &w[..width], &mut bent[..width]);
    let (gradient, diagonal) = (&mut gradient[..width], &mut diagonal[..width]);
    // The texels at both ends have neighbours that the map addresses; the loops between them need no addresses.
    let ends = [0, width - 1].map(|x| (x, grid.column(x, -1), grid.column(x, 1)));
    for (x, left, right) in ends {
        bent[x] = f32::from(w[x]) * (h[left] - 2.0 * h[x] + h[right]);
    }
    for x in 1..width.saturating_sub(1) {
        bent[x] = f32::from(w[x]) * (h[x - 1] - 2.0 * h[x] + h[x + 1]);
    }
    for (x, left, right) in ends {
        gradient[x] = bent[left] - 2.0 * bent[x] + bent[right];
        diagonal[x] = f32::from(w[left]) + 4.0 * f32::from(w[x]) + f32::from(w[right]);
    }
    for x in 1..width.saturating_sub(1) {
        gradient[x] = bent[x - 1] - 2.0 * bent[x] + bent[x + 1];
        diagonal[x] = f32::from(w[x - 1]) + 4.0 * f32::from(w[x]) + f32::from(w[x + 1]);
    }
}

/// Adds the derivative and the second derivative of the bending energy along y, for the texels of a row.
fn bend_along_y(h: [&[f32]; 5], w: [&[u8]; 3], gradient: &mut [f32], diagonal: &mut [f32]) {
    let width = gradient.len();
    let (h, w, diagonal) = (h.map(|row| &row[..width]), w.map(|row| &row[..width]), &mut diagonal[..width]);
    for x in 0..width {
        let [above, here, below] = w.map(|row| f32::from(row[x]));
        gradient[x] += above * (h[0][x] - 2.0 * h[1][x] + h[2][x]) - 2.0 * here * (h[1][x] - 2.0 * h[2][x] + h[3][x])
            + below * (h[2][x] - 2.0 * h[3][x] + h[4][x]);
        diagonal[x] += above + 4.0 * here + below;
    }
}
