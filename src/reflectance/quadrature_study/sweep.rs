//! Slow sweeps of a viewer, a roughness, an azimuth: how far the result moves from step to step.

use super::surfaces::{Surface, spherical, surfaces};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// What a sweep changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// The viewer's polar angle, −80° to 80° through the displacement direction, in steps of 0.1°.
    Elevation,
    /// The viewer's azimuth once around, at 1° from the displacement direction, in steps of 0.25°.
    Azimuth,
    /// The ratio of the deviations from 1/2 to 2 through isotropy, correlation ±.02, in 1600 steps.
    Anisotropy,
    /// Both deviations from .02 to 1.5, in 1600 steps.
    Roughness,
}

impl Path {
    /// All paths.
    pub const ALL: [Self; 4] = [Self::Elevation, Self::Azimuth, Self::Anisotropy, Self::Roughness];

    /// Name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Elevation => "elevation",
            Self::Azimuth => "azimuth",
            Self::Anisotropy => "anisotropy",
            Self::Roughness => "roughness",
        }
    }

    /// The surfaces along the path that starts from `base`.
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
    /// Largest change from one step to the next.
    pub step: f64,
    /// Largest change of that change: what an eye sees as a pop.
    pub bend: f64,
}

/// The steps of `value` along `path`, from each of `n` surfaces; `value` gets the number of the surface too.
#[must_use]
pub fn steps(path: Path, n: usize, seed: u64, value: impl Fn(usize, &Surface) -> f64) -> Steps {
    let mut worst = Steps::default();
    for (i, base) in surfaces(n, seed).iter().enumerate() {
        let values: Vec<f64> = path.surfaces(base).iter().map(|s| value(i, s)).collect();
        worst.step = values.windows(2).map(|w| (w[1] - w[0]).abs()).fold(worst.step, f64::max);
        worst.bend = values.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs()).fold(worst.bend, f64::max);
    }
    worst
}
