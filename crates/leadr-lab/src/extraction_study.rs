//! Measures the accuracy and time of power iteration for known facets (thesis Table 4.I and Figure 4.5).

use std::f64::consts::TAU;
use std::time::Instant;

use glam::{DVec2, DVec3};
use serde::Serialize;

use leadr_reflectance::extraction::power_iteration::{Backscattering, extract_polar, extract_radial};
use leadr_reflectance::extraction::samples::direction;
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::radial_table::angle_at;
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;

/// Values below this fraction of the backscattering peak are ignored.
const DARK: f64 = 1e-3;
/// The number of angles at which fits are compared.
const ANGLES: u32 = 2000;

/// The settings and results of one extraction.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Extraction {
    /// The number of angles at which the material is evaluated.
    pub angles: usize,
    /// The number of azimuths at which the material is evaluated.
    pub azimuths: usize,
    /// The duration of the extraction in seconds.
    pub seconds: f64,
    /// The largest relative error of the backscattering, over angles where the backscattering is at least a thousandth of
    /// its peak.
    pub error: f64,
}

/// Computes the backscattering `f_r(o, o)` of ideal specular facets with Smith's masking (thesis eq. 4.3).
fn backscattering(slopes: &impl SlopeDistribution, o: DVec3) -> f64 {
    slopes.ndf(o) / (4.0 * o.z * slopes.visible_area(o))
}

fn worst(of: &impl SlopeDistribution, found: &impl SlopeDistribution, azimuths: u32) -> f64 {
    let peak = backscattering(of, DVec3::Z);
    let all = (0..ANGLES).flat_map(|i| (0..azimuths).map(move |k| (i, k)));
    let error = |(i, k)| {
        let o = direction(angle_at(f64::from(i) / f64::from(ANGLES)), TAU * f64::from(k) / f64::from(azimuths));
        let expected = backscattering(of, o);
        if expected > DARK * peak { (backscattering(found, o) / expected - 1.0).abs() } else { 0.0 }
    };
    all.map(error).fold(0.0, f64::max)
}

fn beckmann(x: f64, y: f64) -> Beckmann {
    Beckmann::new(DVec2::ZERO, 0.5 * DVec3::new(x * x, y * y, 0.0))
}

/// Recovers isotropic Beckmann slopes of roughness `alpha` from `angles` angles. Returns `None` if the extraction fails.
pub fn round(alpha: f64, angles: usize) -> Option<Extraction> {
    let slopes = beckmann(alpha, alpha);
    let at = |i: usize| backscattering(&slopes, direction(angle_at(i as f64 / angles as f64), 0.0));
    let samples: Vec<f64> = (0..angles).map(at).collect();
    let start = Instant::now();
    let found = extract_radial(&samples, Backscattering::Smith)?;
    let seconds = start.elapsed().as_secs_f64();
    Some(Extraction { angles, azimuths: 1, seconds, error: worst(&slopes, &found.slopes, 1) })
}

/// Recovers anisotropic Beckmann slopes of two roughnesses from `angles` angles and `azimuths` azimuths.
pub fn anisotropic(alpha: DVec2, angles: usize, azimuths: usize) -> Option<Extraction> {
    let slopes = beckmann(alpha.x, alpha.y);
    let at = |i: usize, k: usize| {
        backscattering(&slopes, direction(angle_at(i as f64 / angles as f64), TAU * k as f64 / azimuths as f64))
    };
    let rows: Vec<Vec<f64>> = (0..azimuths).map(|k| (0..angles).map(|i| at(i, k)).collect()).collect();
    let start = Instant::now();
    let found = extract_polar(&rows, Backscattering::Smith)?;
    let seconds = start.elapsed().as_secs_f64();
    Some(Extraction { angles, azimuths, seconds, error: worst(&slopes, &found.slopes, 17) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_angles_are_nearer() {
        let few = round(0.05, 24).unwrap();
        let many = round(0.05, 96).unwrap();
        assert!(many.error < 0.1 * few.error && few.error < 0.1, "{few:?} {many:?}");
        let anisotropic = anisotropic(DVec2::new(0.1, 0.3), 48, 48).unwrap();
        assert!(anisotropic.error < 0.01, "{anisotropic:?}");
    }
}
