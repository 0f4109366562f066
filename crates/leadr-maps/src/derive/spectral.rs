//! Orthonormal transforms of real images of any size. If a kernel is even along both axes, the transform turns convolution
//! by the kernel into a product. Repeating images use the Hartley transform. Images mirrored at their edges use the cosine
//! transform (DCT-II).
//!
//! Two rows form the real and imaginary parts of one complex transform. Nothing is therefore computed twice, and only the
//! image is stored.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use rayon::prelude::*;
use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use crate::Wrap;

pub(super) struct Transform {
    length: usize,
    wrap: Wrap,
    forward: Arc<dyn Fft<f32>>,
    backward: Arc<dyn Fft<f32>>,
    /// A table of `exp(-i pi k / 2 n)`.
    twiddles: Vec<Complex<f32>>,
}

#[derive(Clone)]
pub(super) struct Scratch {
    pair: Vec<Complex<f32>>,
    own: Vec<Complex<f32>>,
    blank: Vec<f32>,
}

impl Transform {
    pub fn new(length: usize, wrap: Wrap) -> Self {
        let mut planner = FftPlanner::new();
        let twiddle = |k: usize| {
            let angle = 0.5 * PI * k as f64 / length as f64;
            Complex::new(angle.cos() as f32, -angle.sin() as f32)
        };
        Self {
            length,
            wrap,
            forward: planner.plan_fft_forward(length),
            backward: planner.plan_fft_inverse(length),
            twiddles: (0..length).map(twiddle).collect(),
        }
    }

    /// Returns the phase per texel of each basis function, in the same order as the coefficients.
    pub fn phases(&self) -> Vec<f64> {
        let step = if self.wrap == Wrap::Repeat { TAU } else { PI } / self.length as f64;
        (0..self.length).map(|k| step * k as f64).collect()
    }

    pub fn scratch(&self) -> Scratch {
        let zero = Complex::new(0.0, 0.0);
        let own = self.forward.get_inplace_scratch_len().max(self.backward.get_inplace_scratch_len());
        Scratch { pair: vec![zero; self.length], own: vec![zero; own], blank: vec![0.0; self.length] }
    }

    /// Returns the position of a texel in Makhoul's (1980) order, which lists the even columns first, then the odd columns
    /// in reverse.
    fn slot(&self, x: usize) -> usize {
        if x.is_multiple_of(2) { x / 2 } else { self.length - 1 - x / 2 }
    }

    /// Transforms one or two consecutive rows in place. The transform is inverse unless `forward` is set.
    pub fn rows(&self, rows: &mut [f32], scratch: &mut Scratch, forward: bool) {
        let pair = if forward { Self::forward } else { Self::backward };
        let (a, b) = rows.split_at_mut(self.length);
        if b.is_empty() {
            let mut blank = std::mem::take(&mut scratch.blank);
            blank.fill(0.0);
            pair(self, [a, &mut blank], scratch);
            scratch.blank = blank;
        } else {
            pair(self, [a, b], scratch);
        }
    }

    fn forward(&self, [a, b]: [&mut [f32]; 2], scratch: &mut Scratch) {
        let n = self.length;
        let z = &mut scratch.pair;
        for x in 0..n {
            let slot = if self.wrap == Wrap::Repeat { x } else { self.slot(x) };
            z[slot] = Complex::new(a[x], b[x]);
        }
        self.forward.process_with_scratch(z, &mut scratch.own);
        let unit = (1.0 / n as f64).sqrt() as f32;
        for k in 0..n {
            let (here, other) = (z[k], z[if k == 0 { 0 } else { n - k }]);
            // The sums are twice the spectra of the two rows.
            let of_a = Complex::new(here.re + other.re, here.im - other.im);
            let of_b = Complex::new(here.im + other.im, other.re - here.re);
            if self.wrap == Wrap::Repeat {
                (a[k], b[k]) = (0.5 * unit * (of_a.re - of_a.im), 0.5 * unit * (of_b.re - of_b.im));
            } else {
                let unit = if k == 0 { unit } else { std::f32::consts::SQRT_2 * unit };
                let twiddle = self.twiddles[k];
                (a[k], b[k]) = (0.5 * unit * (of_a * twiddle).re, 0.5 * unit * (of_b * twiddle).re);
            }
        }
    }

    fn backward(&self, [a, b]: [&mut [f32]; 2], scratch: &mut Scratch) {
        if self.wrap == Wrap::Repeat {
            return self.forward([a, b], scratch);
        }
        let n = self.length;
        let z = &mut scratch.pair;
        let unit = (1.0 / n as f64).sqrt() as f32;
        for k in 0..n {
            let of = |row: &[f32]| {
                if k == 0 {
                    return Complex::new(row[0] * unit, 0.0);
                }
                let half = std::f32::consts::FRAC_1_SQRT_2 * unit;
                Complex::new(row[k] * half, -row[n - k] * half) * self.twiddles[k].conj()
            };
            let (of_a, of_b) = (of(a), of(b));
            z[k] = Complex::new(of_a.re - of_b.im, of_a.im + of_b.re);
        }
        self.backward.process_with_scratch(z, &mut scratch.own);
        for x in 0..n {
            let slot = self.slot(x);
            (a[x], b[x]) = (z[slot].re, z[slot].im);
        }
    }
}

pub(super) fn transpose(from: &[f32], width: usize, to: &mut [f32]) {
    const BLOCK: usize = 32;
    let height = from.len() / width.max(1);
    to.par_chunks_mut(BLOCK * height.max(1)).enumerate().for_each(|(k, rows)| {
        for y0 in (0..height).step_by(BLOCK) {
            for (x, row) in (k * BLOCK..).zip(rows.chunks_exact_mut(height)) {
                for (y, texel) in (y0..).zip(&mut row[y0..height.min(y0 + BLOCK)]) {
                    *texel = from[y * width + x];
                }
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(n: usize) -> Vec<f32> {
        (0..2 * n).map(|i| ((i * 7919 + 13) % 101) as f32 / 50.0 - 1.0).collect()
    }

    #[test]
    fn transforms_are_their_sums() {
        for n in [1, 2, 3, 8, 15, 31] {
            for wrap in [Wrap::Repeat, Wrap::Clamp] {
                let transform = Transform::new(n, wrap);
                let (given, mut found) = (rows(n), rows(n));
                transform.rows(&mut found, &mut transform.scratch(), true);
                for row in 0..2 {
                    for (k, phase) in transform.phases().into_iter().enumerate() {
                        let function = |x: usize| match wrap {
                            Wrap::Repeat => (phase * x as f64).cos() + (phase * x as f64).sin(),
                            Wrap::Clamp if k == 0 => 1.0,
                            Wrap::Clamp => 2f64.sqrt() * (phase * (x as f64 + 0.5)).cos(),
                        };
                        let sum: f64 = (0..n).map(|x| f64::from(given[row * n + x]) * function(x)).sum();
                        let error = sum / (n as f64).sqrt() - f64::from(found[row * n + k]);
                        assert!(error.abs() < 1e-5, "{n} {wrap:?} row {row}, {k}: {error}");
                    }
                }
            }
        }
    }

    #[test]
    fn transforms_have_an_inverse() {
        for n in [1, 2, 5, 64, 97] {
            for wrap in [Wrap::Repeat, Wrap::Clamp] {
                let transform = Transform::new(n, wrap);
                // The test covers a pair of rows and a single row.
                for count in [2 * n, n] {
                    let given = &rows(n)[..count];
                    let mut found = given.to_vec();
                    transform.rows(&mut found, &mut transform.scratch(), true);
                    transform.rows(&mut found, &mut transform.scratch(), false);
                    assert!(given.iter().zip(&found).all(|(a, b)| (a - b).abs() < 2e-6), "{n} {wrap:?}");
                }
            }
        }
    }

    #[test]
    fn transposing_twice_changes_nothing() {
        let given: Vec<f32> = (0..37 * 65).map(|i| i as f32).collect();
        let (mut transposed, mut back) = (vec![0.0; given.len()], vec![0.0; given.len()]);
        transpose(&given, 37, &mut transposed);
        assert_eq!(transposed[3 * 65 + 11], given[11 * 37 + 3]);
        transpose(&transposed, 65, &mut back);
        assert_eq!(given, back);
    }
}
