//! Measures the rules for specular facets under an environment of lobes.

use super::Row;
use super::surfaces::{Surface, surfaces};
use glam::DVec3;
use leadr_reflectance::facets::projected_area::face_viewer;
use leadr_reflectance::integrals::reference::{visible_extents, visible_mean_panels};
use leadr_reflectance::integrals::specular::{LOD_MATCHED, LOD_SUPPLEMENT_5, env_lod, leadr_specular_environment};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::{grid_lambda, grid_spacing, normal_of_slope};
use leadr_reflectance::visible::kernel::{kernel_lod, lookup_variance};
use leadr_reflectance::visible::shadowed_specular::visible_specular_environment;
use leadr_reflectance::visible::specular::{ProbeRule, VisibleProbe, probe_rule};
use rayon::prelude::*;
use std::f64::consts::PI;

/// The number of texels per edge of the prefiltered environment.
pub const SIZE: f64 = 128.0;
/// The number of box-filtered mip levels, and of levels that are blurred for probes.
const LEVELS: usize = 8;
const KERNELS: usize = 6;

/// The width of the lobes of an environment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sharpness {
    /// Concentrations of 2–20, as in skies and rooms.
    Smooth,
    /// Concentrations of 20–300 (3° of standard deviation), as for windows and lamps.
    Sharp,
}

impl Sharpness {
    pub(super) fn range(self) -> (f64, f64) {
        match self {
            Self::Smooth => (2.0, 20.0),
            Self::Sharp => (20.0, 300.0),
        }
    }
}

/// A von Mises–Fisher lobe, and its blurred form at every mip level.
#[derive(Clone, Debug)]
struct Lobe {
    direction: DVec3,
    /// The concentration and peak of the unblurred lobe, then of its blurred form at each mip level.
    levels: [(f64, f64); LEVELS + 1],
    /// The concentration and peak at each level that probes use.
    kernels: [(f64, f64); KERNELS],
}

/// Lobes on a constant background, with mean radiance 1. Lookups are trilinear in a box-filtered mip chain. Level `l` with
/// texels of size `h` adds a variance of `h²/4`.
#[derive(Clone, Debug)]
pub struct Lobes {
    ambient: f64,
    lobes: Vec<Lobe>,
}

/// Computes the mean cosine of a lobe with concentration `k`.
fn mean_cosine(k: f64) -> f64 {
    1.0 / k.tanh() - 1.0 / k
}

/// Computes the concentration of a lobe with mean cosine `a`, by Banerjee's estimate and Newton's method.
fn concentration(a: f64) -> f64 {
    let mut k = a * (3.0 - a * a) / (1.0 - a * a);
    for _ in 0..8 {
        let at = mean_cosine(k);
        k = (k - (at - a) / (1.0 - at * at - 2.0 * at / k)).max(1e-3);
    }
    k
}

impl Lobes {
    /// Returns one lobe on black.
    pub fn single(direction: DVec3, k: f64) -> Self {
        Self { ambient: 0.0, lobes: vec![Lobe::new(direction, k, 1.0)] }
    }

    /// Computes the concentration of a kernel of this variance.
    pub fn of_variance(variance: f64) -> f64 {
        if variance < 0.05 { 1.0 / variance + 0.5 } else { concentration((-variance).exp()) }
    }

    /// Returns six random lobes.
    pub fn random(r: &mut Random, sharpness: Sharpness) -> Self {
        let (low, high) = sharpness.range();
        let ambient = 0.3 * r.unit();
        let weights: [f64; 6] = std::array::from_fn(|_| r.exponential());
        let sum: f64 = weights.iter().sum();
        let lobes =
            weights.iter().map(|w| Lobe::new(r.on_sphere(), r.log(low, high), w * (1.0 - ambient) / sum)).collect();
        Self { ambient, lobes }
    }

    fn sum(&self, d: DVec3, of: impl Fn(&Lobe) -> (f64, f64)) -> f64 {
        let lobe = |l: &Lobe| {
            let (k, peak) = of(l);
            peak * (k * (l.direction.dot(d) - 1.0)).exp()
        };
        self.ambient + self.lobes.iter().map(lobe).sum::<f64>()
    }

    fn level(&self, d: DVec3, level: usize) -> f64 {
        self.sum(d, |l| l.levels[level])
    }

    /// Looks up the radiance through a kernel of this variance, as probes do.
    pub fn seen(&self, d: DVec3, variance: f64) -> f64 {
        let lod = kernel_lod(variance, SIZE).min((KERNELS - 1) as f64);
        let level = (lod as usize).min(KERNELS - 2);
        let f = lod - level as f64;
        (1.0 - f) * self.sum(d, |l| l.kernels[level]) + f * self.sum(d, |l| l.kernels[level + 1])
    }

    /// Computes the unfiltered radiance.
    pub fn radiance(&self, d: DVec3) -> f64 {
        self.level(d, 0)
    }

    /// Looks up the radiance with trilinear filtering.
    pub fn lookup(&self, d: DVec3, lod: f64) -> f64 {
        let lod = lod.clamp(0.0, (LEVELS - 1) as f64);
        let level = (lod as usize).min(LEVELS - 2);
        let f = lod - level as f64;
        (1.0 - f) * self.level(d, level + 1) + f * self.level(d, level + 2)
    }
}

impl Lobe {
    fn new(direction: DVec3, k: f64, weight: f64) -> Self {
        let peak = |k: f64| (k, weight * 2.0 * k / (1.0 - (-2.0 * k).exp()));
        let levels = std::array::from_fn(|i| {
            if i == 0 {
                return peak(k);
            }
            let texel = (4.0 * PI / 6.0).sqrt() / SIZE * f64::powi(2.0, i as i32 - 1);
            peak(concentration(mean_cosine(k) * (-0.25 * texel * texel).exp()))
        });
        let blurred = |variance: f64| peak(concentration(mean_cosine(k) * (-variance).exp()));
        let kernels = std::array::from_fn(|i| blurred(lookup_variance(i as f64, SIZE)));
        Self { direction, levels, kernels }
    }
}

/// Computes the converged radiance of specular facets. `finest` is the concentration of the narrowest lobe.
pub fn converged_radiance(surface: &Surface, lobes: &Lobes, finest: f64) -> f64 {
    let Surface { wo, m, s } = *surface;
    let panels = visible_extents(wo, s).map(|e| (4.0 + 3.6 * finest.sqrt() * e).ceil() as usize);
    visible_mean_panels(wo, m, s, panels, |slope| {
        let wn = normal_of_slope(slope);
        DVec3::splat(lobes.radiance(2.0 * wn.dot(wo) * wn - wo))
    })
    .x
}

/// Random surfaces, each with one environment and the converged radiance.
pub struct SpecularSet {
    surfaces: Vec<Surface>,
    environments: Vec<Lobes>,
    truth: Vec<f64>,
}

impl SpecularSet {
    /// Returns `n` random surfaces and their environments.
    pub fn new(n: usize, sharpness: Sharpness, seed: u64) -> Self {
        let surfaces = surfaces(n, seed);
        let mut r = Random(seed + 3);
        let environments: Vec<Lobes> = (0..n).map(|_| Lobes::random(&mut r, sharpness)).collect();
        let truth = surfaces
            .par_iter()
            .zip(&environments)
            .map(|(s, lobes)| converged_radiance(s, lobes, sharpness.range().1))
            .collect();
        Self { surfaces, environments, truth }
    }

    /// Measures the errors of a rule, relative to the radiance where it exceeds the mean radiance of 1.
    pub fn row(&self, name: &str, evaluations: u32, rule: impl Fn(&Surface, &Lobes) -> f64 + Sync) -> Row {
        let errors: Vec<Vec<f64>> = self
            .surfaces
            .par_iter()
            .zip(&self.environments)
            .zip(&self.truth)
            .map(|((s, lobes), truth)| vec![(rule(s, lobes) - truth) / truth.max(1.0)])
            .collect();
        Row::new(name, evaluations, &self.surfaces, &errors)
    }

    /// Measures the paper's grid with a constant of the level of detail. `name` describes the constant.
    pub(super) fn grid_row(&self, n: u32, name: &str, constant: f64) -> Row {
        self.row(&format!("paper {n}x{n}{name}"), n * n, |s, lobes| grid_radiance(s, lobes, n, constant))
    }

    /// Measures the paper's grids and the rules with few probes. The grids use matched solid angles, or the supplement's
    /// level of detail where the supplement gives one.
    pub fn rows(&self) -> Vec<Row> {
        let grid = |n, name, constant| self.grid_row(n, name, constant);
        let probes = |n: u32| self.row(&format!("rings of {n}"), n, |s, lobes| probe_radiance(s, lobes, probe_rule(n)));
        vec![
            grid(1, "", LOD_MATCHED),
            grid(3, "", LOD_MATCHED),
            grid(5, ", supplement's LOD", LOD_SUPPLEMENT_5),
            grid(5, "", LOD_MATCHED),
            grid(7, "", LOD_MATCHED),
            grid(9, "", LOD_MATCHED),
            grid(16, "", LOD_MATCHED),
            grid(32, "", LOD_MATCHED),
            grid(64, "", LOD_MATCHED),
            grid(128, "", LOD_MATCHED),
            probes(5),
            probes(9),
            probes(16),
        ]
    }
}

/// Computes the radiance by the paper's grid, as the renderer implements it.
pub fn grid_radiance(surface: &Surface, lobes: &Lobes, n: u32, constant: f64) -> f64 {
    let Surface { wo, m, s } = *surface;
    let lambda = grid_lambda(n);
    let m = face_viewer(wo, m, s, lambda);
    let spacing = grid_spacing(n, lambda);
    leadr_specular_environment(Shadowing::None, wo, m, s, DVec3::ONE, n, lambda, |e| {
        DVec3::splat(lobes.lookup(e.wi, env_lod(wo, e.wn, s, spacing, SIZE, constant)))
    })
    .reflected
    .x
}

/// Computes the radiance by a rule with few probes.
pub fn probe_radiance(surface: &Surface, lobes: &Lobes, rule: ProbeRule<'_>) -> f64 {
    let Surface { wo, m, s } = *surface;
    let radiance = |p: &VisibleProbe| DVec3::splat(lobes.seen(p.wi, p.variance));
    visible_specular_environment(Shadowing::None, wo, m, s, DVec3::ONE, rule, radiance).reflected.x
}
