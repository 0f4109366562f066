//! Periodic Gaussian height fields, with a pyramid of maxima that lets rays skip empty space.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use leadr_reflectance::random::Random;

/// The energy spectrum of a random surface by wave number `k`, with correlation length `L`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spectrum {
    /// The energy is `exp(−k²L²/4)`, so that heights have the autocorrelation `exp(−r²/L²)`.
    Gaussian,
    /// The waves have nearly one length, in all directions. The energy is constant within 15 % of `k = 2/L`, and 0
    /// elsewhere.
    Ring,
}

impl Spectrum {
    fn energy(self, k: f64, correlation: f64) -> f64 {
        let x = k * correlation;
        match self {
            Self::Gaussian => (-0.25 * x * x).exp(),
            Self::Ring => f64::from((x - 2.0).abs() <= 0.3),
        }
    }
}

/// A periodic height field on a square lattice of unit cells. The diagonal from a cell's lower to its upper corner splits
/// the cell into two flat triangles. The slopes have standard deviations near 1 along both axes.
#[derive(Clone, Debug)]
pub struct Tile {
    size: u32,
    heights: Vec<f32>,
    /// The highest corner of each cell, then of each block of 2 × 2 cells, and so on.
    maxima: Vec<Vec<f32>>,
    covariance: DVec3,
}

impl Tile {
    /// Creates a random surface of `size`² cells with a correlation length of `correlation` cells. The result is
    /// deterministic.
    ///
    /// # Panics
    /// Panics if the size is not a power of two or is below 16. Also panics if the correlation length is below 2 or above an
    /// eighth of the size. A ring needs wave numbers on the tile's lattice, and a spectrum must be resolved.
    pub fn new(spectrum: Spectrum, size: u32, correlation: f64, seed: u64) -> Self {
        assert!(size.is_power_of_two() && size >= 16, "a tile of {size} cells: use a power of two, at least 16");
        assert!(
            correlation >= 2.0 && correlation * 8.0 <= f64::from(size),
            "correlation of {correlation} cells: use 2 to an eighth of the tile's {size}"
        );
        let n = size as usize;
        let mut field = vec![DVec2::ZERO; n * n];
        let wave = |i: usize| TAU * (if i > n / 2 { i as f64 - n as f64 } else { i as f64 }) / n as f64;
        field.par_chunks_mut(n).enumerate().for_each(|(y, row)| {
            for (x, value) in row.iter_mut().enumerate() {
                let amplitude = spectrum.energy(wave(x).hypot(wave(y)), correlation).sqrt();
                if amplitude > 0.0 && x + y > 0 {
                    *value = DVec2::from(Random::stream(seed, (y * n + x) as u64).normals()) * amplitude;
                }
            }
        });
        for _ in 0..2 {
            field.par_chunks_mut(n).for_each(fourier);
            field = transpose(&field, n);
        }
        // The real part has the correlation of the spectrum. The imaginary part would be another surface and is not used.
        let raw: Vec<f64> = field.iter().map(|v| v.x).collect();
        let s = slope_covariance(n, |x, y| raw[y * n + x]);
        let scale = (0.5 * (s.x + s.y)).sqrt().recip();
        Self::from_heights(size, raw.iter().map(|h| (h * scale) as f32).collect())
    }

    /// Creates the periodic surface through `heights`, row by row, in cell units.
    ///
    /// # Panics
    /// Panics if the size is not a power of two, or if the number of heights is not its square.
    pub fn from_heights(size: u32, heights: Vec<f32>) -> Self {
        let n = size as usize;
        assert!(size.is_power_of_two() && heights.len() == n * n, "{} heights for {size}² cells", heights.len());
        let at = |x: usize, y: usize| heights[(y & (n - 1)) * n + (x & (n - 1))];
        let covariance = slope_covariance(n, |x, y| f64::from(at(x, y)));
        let mut maxima: Vec<Vec<f32>> = vec![
            (0..n * n)
                .map(|i| (i % n, i / n))
                .map(|(x, y)| at(x, y).max(at(x + 1, y)).max(at(x, y + 1)).max(at(x + 1, y + 1)))
                .collect(),
        ];
        let mut side = n / 2;
        while side > 0 {
            let finer = maxima.last().expect("the cells");
            let at = |x: usize, y: usize| finer[y * 2 * side + x];
            let level = (0..side * side)
                .map(|i| (2 * (i % side), 2 * (i / side)))
                .map(|(x, y)| at(x, y).max(at(x + 1, y)).max(at(x, y + 1)).max(at(x + 1, y + 1)))
                .collect();
            maxima.push(level);
            side /= 2;
        }
        Self { size, heights, maxima, covariance }
    }

    /// Returns the number of cells along a side.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// Returns the heights of the lattice points, row by row, in cell units.
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// Returns the covariance `(s_xx, s_yy, s_xy)` of the slopes of all triangles. The mean slope is 0.
    pub fn covariance(&self) -> DVec3 {
        self.covariance
    }

    /// Returns the coarsest level of [`highest`](Self::highest), which covers the whole tile.
    pub(super) fn top(&self) -> u32 {
        self.maxima.len() as u32 - 1
    }

    /// Returns the highest point of a square of `2^level` cells. The coordinates are periodic.
    #[inline]
    pub(super) fn highest(&self, level: u32, x: i32, y: i32) -> f64 {
        let (bits, mask) = (self.top() - level, (1i32 << (self.top() - level)) - 1);
        f64::from(self.maxima[level as usize][(((y & mask) as usize) << bits) + (x & mask) as usize])
    }

    /// Returns the heights of a cell's corners: `(0,0)`, `(1,0)`, `(0,1)`, `(1,1)`.
    #[inline]
    pub(crate) fn corners(&self, x: i32, y: i32) -> [f64; 4] {
        let (bits, mask) = (self.top(), (1i32 << self.top()) - 1);
        let (x0, x1) = ((x & mask) as usize, ((x + 1) & mask) as usize);
        let (y0, y1) = (((y & mask) as usize) << bits, (((y + 1) & mask) as usize) << bits);
        [y0 + x0, y0 + x1, y1 + x0, y1 + x1].map(|i| f64::from(self.heights[i]))
    }

    /// Returns the slopes of the two triangles of a cell: below the diagonal (`u > v`), then above it.
    #[inline]
    pub(crate) fn slopes(&self, x: i32, y: i32) -> [DVec2; 2] {
        let [h00, h10, h01, h11] = self.corners(x, y);
        [DVec2::new(h10 - h00, h11 - h10), DVec2::new(h11 - h01, h01 - h00)]
    }

    /// Computes the mean of `f` over the slopes of all triangles, which have equal areas on the plane.
    pub fn mean_over_facets(&self, f: impl Fn(DVec2) -> f64 + Sync) -> f64 {
        let n = self.size as i32;
        let rows: Vec<f64> = (0..n)
            .into_par_iter()
            .map(|y| (0..n).map(|x| self.slopes(x, y).map(&f).iter().sum::<f64>()).sum())
            .collect();
        rows.iter().sum::<f64>() / (2.0 * f64::from(n) * f64::from(n))
    }
}

/// Computes the slope covariance over all triangles of a periodic lattice. The mean slope is 0.
fn slope_covariance(n: usize, height: impl Fn(usize, usize) -> f64 + Sync) -> DVec3 {
    let next = |i: usize| (i + 1) % n;
    let rows: Vec<DVec3> = (0..n)
        .into_par_iter()
        .map(|y| {
            let mut sum = DVec3::ZERO;
            for x in 0..n {
                let (h00, h10) = (height(x, y), height(next(x), y));
                let (h01, h11) = (height(x, next(y)), height(next(x), next(y)));
                for s in [DVec2::new(h10 - h00, h11 - h10), DVec2::new(h11 - h01, h01 - h00)] {
                    sum += DVec3::new(s.x * s.x, s.y * s.y, s.x * s.y);
                }
            }
            sum
        })
        .collect();
    rows.into_iter().sum::<DVec3>() / (2 * n * n) as f64
}

fn transpose(field: &[DVec2], n: usize) -> Vec<DVec2> {
    (0..n * n).map(|i| field[(i % n) * n + i / n]).collect()
}

/// Computes the discrete Fourier transform `Σ f_j exp(2πi jk/n)` in place (Cooley and Tukey). The length must be a power of
/// two.
fn fourier(row: &mut [DVec2]) {
    let n = row.len();
    let bits = n.trailing_zeros();
    for i in 0..n {
        let j = i.reverse_bits() >> (usize::BITS - bits);
        if i < j {
            row.swap(i, j);
        }
    }
    let times = |a: DVec2, b: DVec2| DVec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
    let mut half = 1;
    while half < n {
        let twiddles: Vec<DVec2> = (0..half).map(|k| DVec2::from_angle(PI * k as f64 / half as f64)).collect();
        for block in row.chunks_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for ((a, b), &w) in low.iter_mut().zip(high).zip(&twiddles) {
                let turned = times(*b, w);
                (*a, *b) = (*a + turned, *a - turned);
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transform_equals_its_sum() {
        let input: Vec<DVec2> = (0..16).map(|i| DVec2::from(Random::stream(1, i).normals())).collect();
        let mut fast = input.clone();
        fourier(&mut fast);
        for (k, got) in fast.iter().enumerate() {
            let want: DVec2 =
                input.iter().enumerate().map(|(j, v)| DVec2::from_angle(TAU * (j * k) as f64 / 16.0).rotate(*v)).sum();
            assert!((*got - want).length() < 1e-12, "{got} {want}");
        }
    }

    #[test]
    fn surfaces_have_their_spectrum() {
        let n = 256usize;
        for (spectrum, want) in [
            (Spectrum::Gaussian, [(-0.25f64).exp(), (-1f64).exp(), (-4f64).exp()]),
            // The ring has the autocorrelation J₀(2 r/L) (Bessel), blurred by the width of the ring.
            (Spectrum::Ring, [0.765, 0.224, -0.397]),
        ] {
            let tile = Tile::new(spectrum, n as u32, 8.0, 3);
            let at = |x: usize, y: usize| f64::from(tile.heights[(y % n) * n + x % n]);
            let correlation = |d: usize| {
                let mean =
                    |f: &dyn Fn(usize, usize) -> f64| (0..n * n).map(|i| f(i % n, i / n)).sum::<f64>() / (n * n) as f64;
                mean(&|x, y| at(x, y) * 0.5 * (at(x + d, y) + at(x, y + d))) / mean(&|x, y| at(x, y).powi(2))
            };
            for (d, want) in [4, 8, 16].into_iter().zip(want) {
                let got = correlation(d);
                assert!((got - want).abs() < 0.06, "{spectrum:?}: correlation {got} at {d} cells, not {want}");
            }
            let s = tile.covariance();
            assert!((0.5 * (s.x + s.y) - 1.0).abs() < 1e-5 && s.z.abs() < 0.1, "{s}");
        }
    }

    #[test]
    fn maxima_bound_their_squares() {
        let tile = Tile::new(Spectrum::Gaussian, 32, 3.0, 0);
        for level in 0..=tile.top() {
            for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x - 16, y - 16))) {
                let bound = tile.highest(level, x >> level, y >> level);
                assert!(tile.corners(x, y).iter().all(|&h| h <= bound));
            }
        }
    }
}
