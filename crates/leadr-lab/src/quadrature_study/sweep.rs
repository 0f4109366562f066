//! Measures how much the result changes per step when the viewer, the roughness or the azimuth changes slowly.

use super::diffuse::{Environment, grid_moments};
use super::light::grid_cosine;
use super::specular::{Lobes, Sharpness, grid_radiance, probe_radiance};
use super::surfaces::{Surface, spherical, surfaces};
use glam::DVec3;
use leadr_reflectance::integrals::specular::LOD_MATCHED;
use leadr_reflectance::random::Random;
use leadr_reflectance::visible::diffuse::{leadr_diffuse_light_visible, visible_diffuse_moments};
use leadr_reflectance::visible::specular::probe_rule;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// The quantity that a sweep changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// The polar angle of the viewer, from −80° to 80° through the displacement direction, in steps of 0.1°.
    Elevation,
    /// The azimuth of the viewer over 360°, at 1° from the displacement direction, in steps of 0.25°.
    Azimuth,
    /// The ratio of the two slope deviations, from 1/2 to 2 through isotropy, with correlation ±.02, in 1600 steps.
    Anisotropy,
    /// Both slope deviations, from .02 to 1.5, in 1600 steps.
    Roughness,
}

impl Path {
    /// All sweep paths.
    pub const ALL: [Self; 4] = [Self::Elevation, Self::Azimuth, Self::Anisotropy, Self::Roughness];

    /// Returns the name of the path.
    pub fn name(self) -> &'static str {
        match self {
            Self::Elevation => "elevation",
            Self::Azimuth => "azimuth",
            Self::Anisotropy => "anisotropy",
            Self::Roughness => "roughness",
        }
    }

    /// Returns the surfaces along the path from `base`.
    #[must_use]
    pub fn surfaces(self, base: &Surface) -> Vec<Surface> {
        let sigma = base.roughness().clamp(0.05, 1.0);
        let (ratio, m) = ((base.s.x / base.s.y).clamp(0.05, 20.0).sqrt(), 0.5 * base.m);
        let phi = base.wo.y.atan2(base.wo.x);
        let covariance = |x: f64, y: f64, r: f64| DVec3::new(x * x, y * y, r * x * y);
        let steps = |n: u32| (0..=n).map(move |i| f64::from(i) / f64::from(n));
        match self {
            Self::Elevation => steps(1600)
                .map(|t| Surface { wo: spherical((t - 0.5) * 160f64.to_radians(), phi), m, s: base.s })
                .collect(),
            Self::Azimuth => {
                steps(1440).map(|t| Surface { wo: spherical(1f64.to_radians(), t * TAU), m, s: base.s }).collect()
            }
            Self::Anisotropy => steps(1600)
                .map(|t| {
                    let k = 2f64.powf(t - 0.5);
                    let r = 0.02 * (3.0 * PI * t).sin();
                    Surface { wo: base.wo, m, s: covariance(sigma * k, sigma / k, r) }
                })
                .collect(),
            Self::Roughness => steps(1600)
                .map(|t| {
                    let sigma = 0.02 * 75f64.powf(t);
                    Surface { wo: base.wo, m, s: covariance(sigma * ratio.min(1.0), sigma / ratio.max(1.0), 0.3) }
                })
                .collect(),
        }
    }
}

/// The largest step and the largest second difference along paths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Steps {
    /// The largest change from one step to the next.
    pub step: f64,
    /// The largest difference between consecutive changes, which is visible as popping.
    pub bend: f64,
}

/// Measures the steps of `value` along `path`, from each of `n` surfaces. `value` also receives the index of the surface.
pub fn steps(path: Path, n: usize, seed: u64, value: impl Fn(usize, &Surface) -> f64 + Sync) -> Steps {
    let one = |(i, base): (usize, &Surface)| {
        let values: Vec<f64> = path.surfaces(base).iter().map(|s| value(i, s)).collect();
        Steps {
            step: values.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max),
            bend: values.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs()).fold(0.0, f64::max),
        }
    };
    let larger = |a: Steps, b: Steps| Steps { step: a.step.max(b.step), bend: a.bend.max(b.bend) };
    surfaces(n, seed).par_iter().enumerate().map(one).reduce(Steps::default, larger)
}

/// The steps of one rule along one path.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepRow {
    /// The name of the integral.
    pub integral: &'static str,
    /// The path of the sweep.
    pub path: Path,
    /// The name of the rule.
    pub rule: String,
    /// The largest steps, in units of the environment's mean radiance or of the light's irradiance.
    pub steps: Steps,
}

/// Measures the paper's 5×5 grid and the visible-slope rules along every path, for `n` surfaces each.
pub fn sweep_rows(n: usize) -> Vec<SweepRow> {
    const SEED: u64 = 5;
    let mut r = Random(SEED);
    let environments: Vec<Environment> = (0..n).map(|_| Environment::random(&mut r)).collect();
    let lights: Vec<DVec3> = (0..n).map(|_| spherical(r.range(0.0, 1.5), r.range(0.0, TAU))).collect();
    let mut lobes = |sharpness| -> Vec<Lobes> { (0..n).map(|_| Lobes::random(&mut r, sharpness)).collect() };
    let (smooth, sharp) = (lobes(Sharpness::Smooth), lobes(Sharpness::Sharp));
    let mut rows = Vec::new();
    for path in Path::ALL {
        let mut add = |integral, rule: String, steps| rows.push(SweepRow { integral, path, rule, steps });
        add("diffuse", "paper 5x5".into(), steps(path, n, SEED, |i, s| environments[i].radiance(&grid_moments(s, 5))));
        for terms in [2, 3] {
            let moments = |s: &Surface| visible_diffuse_moments(s.wo, s.m, s.s, terms);
            let swept = steps(path, n, SEED, |i, s| environments[i].radiance(&moments(s)));
            add("diffuse", format!("visible {terms} terms"), swept);
        }
        add("light", "paper 5x5".into(), steps(path, n, SEED, |i, s| grid_cosine(s, lights[i], 5)));
        for terms in [2, 3] {
            let cosine = |s: &Surface, wi| PI * leadr_diffuse_light_visible(s.wo, wi, s.m, s.s, false, terms);
            add("light", format!("visible {terms} terms"), steps(path, n, SEED, |i, s| cosine(s, lights[i])));
        }
        for (name, lobes) in [("smooth lobes", &smooth), ("sharp lobes", &sharp)] {
            let grid = steps(path, n, SEED, |i, s| grid_radiance(s, &lobes[i], 5, LOD_MATCHED));
            add(name, "paper 5x5".into(), grid);
            for probes in [5, 9, 16] {
                let swept = steps(path, n, SEED, |i, s| probe_radiance(s, &lobes[i], probe_rule(probes)));
                add(name, format!("rings of {probes}"), swept);
            }
        }
    }
    rows
}

/// Measures the largest second difference of the paper's 5×5 grid over all paths, with `constant` in the level of detail: in smooth lobes, then
/// in sharp ones. Bands that move over a surface have large second differences. Every path has `n` starts.
pub fn lod_bends(n: usize, constant: f64) -> [f64; 2] {
    const SEED: u64 = 5;
    [Sharpness::Smooth, Sharpness::Sharp].map(|sharpness| {
        let mut r = Random(SEED);
        let lobes: Vec<Lobes> = (0..n).map(|_| Lobes::random(&mut r, sharpness)).collect();
        let bend = |path| steps(path, n, SEED, |i, s| grid_radiance(s, &lobes[i], 5, constant)).bend;
        Path::ALL.into_iter().map(bend).fold(0.0, f64::max)
    })
}
