//! Measures the rules for diffuse facets under order-2 harmonics, by moments of the visible normals.

use super::Row;
use super::surfaces::{Surface, surfaces};
use glam::DVec3;
use leadr_reflectance::facets::projected_area::face_viewer;
use leadr_reflectance::integrals::diffuse::{NormalMoments, visible_normal_moments};
use leadr_reflectance::integrals::reference::visible_mean;
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::{grid_lambda, normal_of_slope};
use leadr_reflectance::visible::diffuse::visible_diffuse_moments;
use rayon::prelude::*;

/// The number of panels per axis of the converged integrals, which use 96² slopes.
const PANELS: usize = 12;

/// Random surfaces, with their converged moments and their environments.
pub struct DiffuseSet {
    surfaces: Vec<Surface>,
    truth: Vec<NormalMoments>,
    environments: Vec<Environment>,
}

/// The irradiance divided by π, as a function of the moments: `constant + linear·E[n] + (diag, off)·E[n nᵀ]`. The mean
/// radiance is 1.
#[derive(Clone, Copy, Debug)]
pub struct Environment {
    constant: f64,
    linear: DVec3,
    diag: DVec3,
    off: DVec3,
}

impl Environment {
    /// Returns one to six von Mises–Fisher lobes of concentration 1–1000 on a constant background.
    pub fn random(r: &mut Random) -> Self {
        let lobes = 1 + (r.unit() * 6.0) as usize;
        let ambient = r.range(0.0, 0.6) * if r.unit() < 0.7 { 1.0 } else { 0.0 };
        let weights: Vec<f64> = (0..lobes).map(|_| r.exponential()).collect();
        let sum: f64 = weights.iter().sum();
        let mut e = Self { constant: ambient, linear: DVec3::ZERO, diag: DVec3::ZERO, off: DVec3::ZERO };
        for weight in weights {
            let (d, k) = (r.on_sphere(), r.log(1.0, 1000.0));
            let first = 1.0 / k.tanh() - 1.0 / k;
            let second = 1.0 - 3.0 * first / k;
            let q = weight * (1.0 - ambient) / sum;
            // The lobe's irradiance is 1 + 2 A₁ c + 5/4 A₂ (3/2 c² − 1/2), c = n·d.
            e.constant += q * (1.0 - 0.625 * second);
            e.linear += q * 2.0 * first * d;
            e.diag += q * 1.875 * second * d * d;
            e.off += q * 3.75 * second * DVec3::new(d.y * d.z, d.x * d.z, d.x * d.y);
        }
        e
    }

    /// Computes the radiance of white facets with these moments.
    pub fn radiance(&self, v: &NormalMoments) -> f64 {
        self.constant + self.linear.dot(v.mean) + self.diag.dot(v.diag) + self.off.dot(v.off)
    }
}

/// Computes converged moments from `panels`² panels of 8×8 slopes.
pub fn converged_moments(surface: &Surface, panels: usize) -> NormalMoments {
    let Surface { wo, m, s } = *surface;
    let mean = |g: fn(DVec3) -> DVec3| visible_mean(wo, m, s, panels, |slope| g(normal_of_slope(slope)));
    NormalMoments {
        mean: mean(|n| n),
        diag: mean(|n| n * n),
        off: mean(|n| DVec3::new(n.y * n.z, n.x * n.z, n.x * n.y)),
    }
}

impl DiffuseSet {
    /// Returns `n` surfaces, each under `environments` environments.
    pub fn new(n: usize, environments: usize, seed: u64) -> Self {
        let surfaces = surfaces(n, seed);
        let truth = surfaces.par_iter().map(|s| converged_moments(s, PANELS)).collect();
        let mut r = Random(seed + 1);
        let environments = (0..environments).map(|_| Environment::random(&mut r)).collect();
        Self { surfaces, truth, environments }
    }

    /// Measures the errors of a moment rule, relative to the mean radiance.
    pub fn row(&self, name: &str, evaluations: u32, rule: impl Fn(&Surface) -> NormalMoments + Sync) -> Row {
        self.scaled_row(name, evaluations, |surface| (1.0, rule(surface)))
    }

    /// Measures the errors of a rule that returns moments, and a factor on their radiance.
    pub(super) fn scaled_row(
        &self,
        name: &str,
        evaluations: u32,
        rule: impl Fn(&Surface) -> (f64, NormalMoments) + Sync,
    ) -> Row {
        let errors: Vec<Vec<f64>> = self
            .surfaces
            .par_iter()
            .zip(&self.truth)
            .map(|(surface, truth)| {
                let (scale, v) = rule(surface);
                self.environments.iter().map(|e| scale * e.radiance(&v) - e.radiance(truth)).collect()
            })
            .collect();
        Row::new(name, evaluations, &self.surfaces, &errors)
    }

    /// Measures the mean normal alone, the paper's grids, and the rules of [`visible_diffuse`](leadr_reflectance::visible::diffuse).
    pub fn rows(&self) -> Vec<Row> {
        let grid = |n: u32| self.row(&format!("paper {n}x{n}"), n * n, |s| grid_moments(s, n));
        let terms = |n: u32| self.row(&format!("visible {n} terms"), n, |s| visible_diffuse_moments(s.wo, s.m, s.s, n));
        vec![grid(1), grid(3), grid(5), grid(7), grid(9), grid(16), grid(32), grid(64), grid(128), terms(2), terms(3)]
    }
}

/// Computes the moments by the paper's grid, as the renderer implements it.
pub fn grid_moments(surface: &Surface, n: u32) -> NormalMoments {
    let lambda = grid_lambda(n);
    let m = face_viewer(surface.wo, surface.m, surface.s, lambda);
    visible_normal_moments(surface.wo, m, surface.s, n, lambda)
}
