//! Fits the constants of [`visible_diffuse`](leadr_reflectance::visible::diffuse) by nonlinear [`least_squares`] to the
//! radiance of random surfaces under random environments.
//!
//! The command is `cargo run --release --example 11_fit_diffuse_terms`.

use super::diffuse::{Environment, converged_moments};
use super::surfaces::{Surface, surfaces, wild_surfaces};
use crate::least_squares::least_squares;
use leadr_reflectance::integrals::diffuse::NormalMoments;
use leadr_reflectance::random::Random;
use leadr_reflectance::visible::diffuse::{Term, moments_by_terms};
use rayon::prelude::*;

/// The number of environments per surface.
const ENVIRONMENTS: usize = 16;
/// The number of panels per axis of the converged integrals.
const PANELS: usize = 12;

/// Random surfaces, with their converged moments and their environments.
pub struct Training {
    surfaces: Vec<Surface>,
    truth: Vec<NormalMoments>,
    environments: Vec<Environment>,
}

impl Training {
    /// Returns `tame` surfaces like those of the tables but with another seed, and `wild` surfaces with wider ranges.
    pub fn new(tame: usize, wild: usize, seed: u64) -> Self {
        let mut all = surfaces(tame, seed);
        all.extend(wild_surfaces(wild, seed + 1));
        let truth = all.par_iter().map(|s| converged_moments(s, PANELS)).collect();
        let mut r = Random(seed + 2);
        let environments = (0..ENVIRONMENTS).map(|_| Environment::random(&mut r)).collect();
        Self { surfaces: all, truth, environments }
    }

    /// Computes the radiance errors for every surface and environment. Errors are weighted by roughness.
    fn residuals(&self, terms: &[Term]) -> Vec<f64> {
        self.surfaces
            .par_iter()
            .zip(&self.truth)
            .flat_map_iter(|(surface, truth)| {
                let v = moments_by_terms(surface.wo, surface.m, surface.s, terms);
                // Smoother surfaces are more frequent in pictures, so errors of smooth surfaces have larger weights.
                let weight = 1.0 / (0.1 + surface.roughness()).sqrt();
                self.environments.iter().map(move |e| weight * (e.radiance(&v) - e.radiance(truth)))
            })
            .collect()
    }

    /// Computes the RMS of the weighted radiance errors.
    pub fn error(&self, terms: &[Term]) -> f64 {
        let r = self.residuals(terms);
        (r.iter().map(|e| e * e).sum::<f64>() / r.len() as f64).sqrt()
    }
}

/// Returns terms with geometrically spaced exponents, as the start of a fit. The terms are exact for a smooth surface.
pub fn plain_terms(n: usize) -> Vec<Term> {
    // With x = |N|², the integrals ∫ t^(−1/2) exp(−t x) dt and ∫ exp(−t x) dt give the inverses 1/|N| and 1/|N|².
    let ladder = (0..n).map(|i| 0.2 * 6f64.powi(i as i32));
    let whole: f64 = ladder.clone().map(|t| t.sqrt() * (-t).exp()).sum();
    ladder.map(|t| Term { exponent: [t, 0.0], first: [t.sqrt() / whole, 0.0], second: [t / 0.2, 0.0] }).collect()
}

/// Sets the last weight of `1/|N|`, so that the sum is 1 at `|N|² = 1` without spread. The terms are then exact for smooth
/// surfaces.
fn exact_when_smooth(mut terms: Vec<Term>) -> Vec<Term> {
    if let Some((last, others)) = terms.split_last_mut() {
        let rest: f64 = others.iter().map(|t| t.first[0] * (-t.exponent[0]).exp()).sum();
        last.first[0] = (1.0 - rest) * last.exponent[0].exp();
    }
    terms
}

/// Returns the free parameters. The last weight of `1/|N|` follows from [`exact_when_smooth`], and the first weight of `1/|N|²` sets an
/// arbitrary unit.
fn unknowns(terms: &[Term]) -> Vec<f64> {
    let last = terms.len() - 1;
    let mut p = Vec::new();
    for (i, t) in terms.iter().enumerate() {
        p.extend([t.exponent[0].ln(), t.exponent[1], t.first[1], t.second[1]]);
        if i != last {
            p.push(t.first[0]);
        }
        if i != 0 {
            p.push(t.second[0]);
        }
    }
    p
}

fn terms_of(p: &[f64], n: usize) -> Vec<Term> {
    let mut p = p.iter().copied();
    let mut next = || p.next().unwrap_or(0.0);
    let terms = (0..n)
        .map(|i| {
            let [t, t1, c1, d1] = [next(), next(), next(), next()];
            let c = if i + 1 == n { 0.0 } else { next() };
            let d = if i == 0 { 1.0 } else { next() };
            Term { exponent: [t.exp(), t1], first: [c, c1], second: [d, d1] }
        })
        .collect();
    exact_when_smooth(terms)
}

/// Fits terms to `training` by least squares. The search begins at `start` and takes at most `steps` Levenberg–Marquardt
/// steps.
pub fn fit_terms(training: &Training, start: &[Term], steps: u32) -> Vec<Term> {
    let n = start.len();
    terms_of(&least_squares(unknowns(start), steps, |p| training.residuals(&terms_of(p, n))), n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::visible::diffuse::visible_diffuse_terms;

    #[test]
    fn packing_keeps_the_terms() {
        for n in [2, 3] {
            let terms = visible_diffuse_terms(n);
            for (a, b) in terms.iter().zip(terms_of(&unknowns(terms), n as usize)) {
                let pairs = [a.exponent, a.first, a.second].into_iter().zip([b.exponent, b.first, b.second]);
                assert!(pairs.into_iter().all(|(a, b)| (0..2).all(|k| (a[k] - b[k]).abs() < 1e-6)), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn fit_from_a_plain_start_approaches_the_constants() {
        let training = Training::new(120, 80, 5);
        let start = plain_terms(2);
        let fitted = fit_terms(&training, &start, 20);
        let [before, after, ours] = [&start, &fitted, visible_diffuse_terms(2)].map(|t| training.error(t));
        // The fit to a few surfaces has smaller errors on these surfaces than the default constants, but not by much.
        assert!(after < 0.2 * before && after < ours && after > 0.5 * ours, "{before} {after} {ours}");
    }
}
