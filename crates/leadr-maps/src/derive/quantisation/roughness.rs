//! The roughness that the codes show and the smoothest surface lacks.

use rayon::prelude::*;

use super::Grid;

/// The side of the cells whose differences are summed, in texels.
const CELL: usize = 8;

/// The number of cells around a cell that are averaged with it.
const AROUND: i64 = 2;

/// The largest difference of two codes, in codes, that rounding may have made or removed. Larger ones are sure.
const UNSURE: f32 = 2.0;

/// The share of the squared differences that may be missing by chance.
const CHANCE: f64 = 0.03;

/// The share of unsure differences below which the codes stay as they are.
const FEW: f64 = 0.1;

/// The factors on the slopes of the smoothest surface that are tried.
const FACTORS: [f64; 10] = [1.0, 1.05, 1.1, 1.2, 1.3, 1.4, 1.6, 1.8, 2.0, 2.5];

/// The variance of the curvature at which codes and smooth heights are equally good, in codes squared.
const EQUAL: f32 = 0.5;

/// Sums over the unsure differences of a cell.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// The number of differences, and the number of unsure ones.
    count: [f64; 2],
    /// The squared differences of the codes.
    codes: f64,
    /// The squared differences of the smoothest surface.
    smooth: f64,
    /// The products of the differences of the smoothest surface and of the remaining heights.
    mixed: f64,
    /// The squared differences of the remaining heights.
    rest: f64,
    /// The expected squared differences after rounding, if the slopes of the smoothest surface are multiplied by each factor.
    rounded: [f64; FACTORS.len()],
}

impl Sums {
    fn add(&mut self, codes: f32, smooth: f32) {
        self.count[0] += 1.0;
        if codes.abs() > UNSURE {
            return;
        }
        let (codes, smooth) = (f64::from(codes), f64::from(smooth));
        let rest = codes - smooth;
        self.count[1] += 1.0;
        self.codes += codes * codes;
        self.smooth += smooth * smooth;
        self.mixed += smooth * rest;
        self.rest += rest * rest;
        for (sum, factor) in self.rounded.iter_mut().zip(FACTORS) {
            let slope = (factor * smooth).abs();
            let fraction = slope.fract();
            *sum += slope * slope + fraction * (1.0 - fraction);
        }
    }

    fn join(&mut self, other: &Self) {
        (0..2).for_each(|i| self.count[i] += other.count[i]);
        self.codes += other.codes;
        self.smooth += other.smooth;
        self.mixed += other.mixed;
        self.rest += other.rest;
        self.rounded.iter_mut().zip(other.rounded).for_each(|(a, b)| *a += b);
    }

    /// Returns the factor on the slopes of the smoothest surface with which rounding gives the differences of the codes.
    fn factor(&self) -> f64 {
        let wanted = self.codes * (1.0 - CHANCE);
        match self.rounded.iter().position(|&sum| sum >= wanted) {
            Some(0) => 1.0,
            Some(k) => {
                let [below, above] = [self.rounded[k - 1], self.rounded[k]];
                let share = (wanted - below) / (above - below).max(f64::MIN_POSITIVE);
                FACTORS[k - 1] + (FACTORS[k] - FACTORS[k - 1]) * share.clamp(0.0, 1.0)
            }
            None => FACTORS[FACTORS.len() - 1],
        }
    }

    /// Returns the share of the codes in a mixture with the smoothest surface that has the squared differences of the relief.
    fn share_of_codes(&self) -> f32 {
        let factor = self.factor();
        let missing = self.smooth * (factor * factor - 1.0);
        let share = if missing <= 0.0 || self.rest <= f64::MIN_POSITIVE {
            0.0
        } else {
            (((self.mixed * self.mixed + self.rest * missing).sqrt() - self.mixed) / self.rest).clamp(0.0, 1.0)
        };
        let unsure = (self.count[1] / (self.count[0] * FEW)).min(1.0);
        (1.0 - (1.0 - share) * unsure) as f32
    }
}

/// Heights, and sums of squared slopes in codes per texel.
pub(super) struct Restored {
    /// The heights in codes.
    pub heights: Vec<f32>,
    /// The sum for the codes.
    pub raw: f64,
    /// The sum for the smoothest surface.
    pub smoothest: f64,
    /// The sum for the heights.
    pub chosen: f64,
}

/// Mixes the smoothest surface with the codes, so that each area has the squared slopes that its codes show.
pub(super) fn with_roughness(grid: Grid, codes: &[f32], mut smooth: Vec<f32>) -> Restored {
    let cells = Grid { width: grid.width.div_ceil(CELL), height: grid.height.div_ceil(CELL), ..grid };
    let sums: Vec<Sums> = (0..cells.len())
        .into_par_iter()
        .map(|cell| {
            let (x, y) = (CELL * (cell % cells.width), CELL * (cell / cells.width));
            let mut sums = Sums::default();
            for y in y..(y + CELL).min(grid.height) {
                for x in x..(x + CELL).min(grid.width) {
                    let [a, b] = [codes, &smooth].map(|texels| differences(grid, texels, x, y));
                    (0..2).for_each(|axis| sums.add(a[axis], b[axis]));
                }
            }
            sums
        })
        .collect();
    let shares: Vec<f32> = around(cells, &sums, Sums::default(), Sums::join).iter().map(Sums::share_of_codes).collect();
    let ones = shares.iter().map(|&share| (share, 1.0)).collect::<Vec<_>>();
    let even = around(cells, &ones, (0.0, 0.0), |sum, one| *sum = (sum.0 + one.0, sum.1 + one.1));
    let shares: Vec<f32> = even.iter().map(|(sum, count)| sum / count).collect();
    let [raw, smoothest] = [codes, &smooth].map(|texels| energy(grid, texels));
    smooth.par_chunks_mut(grid.width).enumerate().for_each(|(y, row)| {
        let of_curvature = shares_of_curvature(grid, codes, y);
        for (x, h) in row.iter_mut().enumerate() {
            let share = interpolated(cells, &shares, x, y).max(of_curvature[x]);
            let code = codes[y * grid.width + x];
            *h = if share < 1.0 { (*h + share * (code - *h)).clamp(code - 0.5, code + 0.5) } else { code };
        }
    });
    let chosen = energy(grid, &smooth);
    Restored { heights: smooth, raw, smoothest, chosen }
}

/// Returns the differences to the next texels along x and y.
fn differences(grid: Grid, texels: &[f32], x: usize, y: usize) -> [f32; 2] {
    let here = grid.row(texels, y, 0);
    [here[grid.column(x, 1)] - here[x], grid.row(texels, y, 1)[x] - here[x]]
}

/// Returns the sum of the mean squared slopes of the cells between the texels, each of which has four triangles. Rows are summed in order.
fn energy(grid: Grid, texels: &[f32]) -> f64 {
    let row = |y| -> f64 {
        let [upper, lower] = [0, 1].map(|dy| grid.row(texels, y, dy));
        // The slopes at two opposite edges. The triangles on the other edges have their mean.
        let square = |a: f32, b: f32| f64::from(0.25 * (a * a + b * b) + 0.125 * (a + b) * (a + b));
        let of_cell = |x: usize| {
            let next = grid.column(x, 1);
            let [a, b, c, d] = [upper[x], upper[next], lower[x], lower[next]];
            square(b - a, d - c) + square(c - a, d - b)
        };
        (0..grid.width).map(of_cell).sum()
    };
    let rows: Vec<f64> = (0..grid.height).into_par_iter().map(row).collect();
    rows.iter().sum()
}

/// Joins each cell with the cells around it.
fn around<T: Copy + Sync + Send>(cells: Grid, values: &[T], empty: T, join: fn(&mut T, &T)) -> Vec<T> {
    let of = |cell: usize| {
        let (x, y) = (cell % cells.width, cell / cells.width);
        let mut sum = empty;
        for dy in -AROUND..=AROUND {
            let row = cells.row(values, y, dy);
            (-AROUND..=AROUND).for_each(|dx| join(&mut sum, &row[cells.column(x, dx)]));
        }
        sum
    };
    (0..cells.len()).into_par_iter().map(of).collect()
}

/// Interpolates the values of cells at a texel.
fn interpolated(cells: Grid, values: &[f32], x: usize, y: usize) -> f32 {
    let at = |i: usize| {
        let position = (i as f32 + 0.5) / CELL as f32 - 0.5;
        (i / CELL, if position < (i / CELL) as f32 { -1 } else { 1 }, (position - (i / CELL) as f32).abs())
    };
    let ((column, side, across), (line, below, along)) = (at(x), at(y));
    let row = |dy| {
        let row = cells.row(values, line, dy);
        row[column] + across * (row[cells.column(column, side)] - row[column])
    };
    row(0) + along * (row(below) - row(0))
}

/// Returns the shares of the codes in a row, where the relief is so rough that a smooth surface predicts it no better than the
/// codes. The curvature is averaged over 5 x 5 texels.
fn shares_of_curvature(grid: Grid, codes: &[f32], y: usize) -> Vec<f32> {
    let mut columns = vec![0.0; grid.width];
    for dy in -2..=2 {
        let y = grid.beside(y, dy, grid.height);
        for (x, sum) in columns.iter_mut().enumerate() {
            *sum += grid.second_differences(codes, x, y).iter().map(|bend| (bend * bend).min(16.0)).sum::<f32>();
        }
    }
    let share = |x: usize| {
        let sum: f32 = (-2..=2).map(|dx| columns[grid.column(x, dx)]).sum();
        // Rounding makes a mean square of up to 1.
        let variance = (sum / 50.0 - 1.0).max(0.0);
        let [square, equal] = [variance, EQUAL].map(|v| v * v);
        square / (square + equal)
    };
    (0..grid.width).map(share).collect()
}
