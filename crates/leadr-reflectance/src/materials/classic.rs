//! Methods that are older than LEADR: Blinn-Phong lobes around mipmapped normals, Toksvig's roughness from the mean normal length, and a
//! single environment lookup per lobe.
//!
//! # Blinn-Phong
//!
//! The lobe `D(wh) = (e + 2) / 2π cosᵉ` is a density of normals per solid angle, whose projected areas sum to one. Near its peak, the lobe
//! is a Gaussian of slopes with variance `1 / (e + 2)` per axis. A Beckmann lobe has the variance `α²/2`, so `e = 2/α² − 2` (Walter et al.
//! 2007).
//!
//! # Toksvig
//!
//! The filtered normal `n̄` gets shorter as the normals under a pixel vary more. Toksvig (2005) uses `(1 − |n̄|) / |n̄|` as the variance
//! `v` of these normals, and widens the lobe to the exponent `e / (1 + e v)`. Maps in this project store slope moments instead of normals,
//! because bumps are rescaled and surfaces deform. The length of the mean normal is therefore computed from the moments.
//! [`normal_variance`] is the variance of normals around the normal of the mean slope, to first order. For Gaussian slopes with variance
//! `v` per axis around the frame's axis, the length is exactly
//!
//! ```text
//! |n̄| = E[1/√(1 + |x|²)] = ∫₀^∞ e^(−u) / √(1 + 2vu) du = t M(t),   t = 1/√v,  M: Mills' ratio
//! ```
//!
//! [`toksvig_variance`] computes `1 − t M` without the cancellation that 8-bit normal maps suffer.

use crate::facets::normal_distribution::tail_mean_ratio;
use crate::limits::MIN_AREA;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Returns the exponent, from 0 to 1e6, of the Blinn-Phong lobe that is equivalent to a Beckmann roughness.
pub fn blinn_phong_exponent(alpha: f64) -> f64 {
    (2.0 / (alpha * alpha).max(MIN_AREA) - 2.0).clamp(0.0, 1e6)
}

/// Returns the slope variance per axis at the peak of a lobe.
pub fn blinn_phong_variance(exponent: f64) -> f64 {
    1.0 / (exponent + 2.0)
}

/// Returns the density of normals per solid angle. `cosine` is the cosine of the angle to the lobe's axis.
pub fn blinn_phong_ndf(cosine: f64, exponent: f64) -> f64 {
    if cosine <= 0.0 { 0.0 } else { (exponent + 2.0) / (2.0 * PI) * cosine.powf(exponent) }
}

/// Returns the variance of unit normals around the normal of the mean slope `m`, per axis of its tangent plane, to first order in the slope
/// covariance `s`. The variance is half the trace of `S G`, where `G = (I − m mᵀ/q)/q` with `q = 1 + |m|²` is the metric of normals over
/// slopes.
pub fn normal_variance(m: DVec2, s: DVec3) -> f64 {
    let per = 1.0 / (1.0 + m.length_squared());
    let along = s.x * m.x * m.x + s.y * m.y * m.y + 2.0 * s.z * m.x * m.y;
    (0.5 * per * (s.x + s.y - per * along)).max(0.0)
}

/// Returns Toksvig's variance `(1 − |n̄|) / |n̄|` for normals of this variance.
pub fn toksvig_variance(variance: f64) -> f64 {
    let shortening = tail_mean_ratio(1.0 / variance.max(1e-12).sqrt());
    shortening / (1.0 - shortening).max(1e-6)
}

/// Returns the exponent of the filtered lobe.
pub fn toksvig_exponent(exponent: f64, variance: f64) -> f64 {
    exponent / (1.0 + exponent * variance)
}

/// Returns the level of detail of a lobe's single environment lookup. `variance` is the normal variance per axis, and `size` is the number
/// of texels per edge of the cube map. Reflected directions rotate twice as far as normals. A bilinear lookup in a box-filtered level with
/// texels of width `h` has the variance `h²/4`.
pub fn lobe_lod(variance: f64, size: f64) -> f64 {
    0.5 * (4.0 * variance).max(1e-12).log2() + size.log2() + 0.467
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::composite_gauss;
    use crate::slopes::grid::{normal_of_slope, slope_at, slope_cholesky};

    fn filtered_normal(m: DVec2, s: DVec3) -> DVec3 {
        let cholesky = slope_cholesky(s);
        let rule: Vec<(f64, f64)> = composite_gauss(-9.0, 9.0, 4, 16);
        let (mut sum, mut norm) = (DVec3::ZERO, 0.0);
        for &(x, wx) in &rule {
            for &(y, wy) in &rule {
                let w = wx * wy * (-0.5 * (x * x + y * y)).exp();
                sum += w * normal_of_slope(slope_at(DVec2::new(x, y), m, cholesky));
                norm += w;
            }
        }
        sum / norm
    }

    #[test]
    fn the_projected_normals_of_a_lobe_sum_to_one() {
        for exponent in [0.0, 10.0, 1000.0] {
            let sum: f64 = composite_gauss(0.0, 1.0, 400, 8)
                .into_iter()
                .map(|(c, w)| w * 2.0 * PI * c * blinn_phong_ndf(c, exponent))
                .sum();
            assert!((sum - 1.0).abs() < 1e-9, "{exponent}: {sum}");
        }
    }

    #[test]
    fn a_lobe_has_the_peak_of_its_beckmann_lobe() {
        for alpha in [0.05, 0.2, 0.5] {
            let peak = blinn_phong_ndf(1.0, blinn_phong_exponent(alpha));
            assert!((peak * PI * alpha * alpha - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_length_of_a_filtered_normal_is_exact_about_the_axis() {
        for v in [1e-3, 0.05, 0.3, 1.0] {
            let length = filtered_normal(DVec2::ZERO, DVec3::new(v, v, 0.0)).length();
            let error = toksvig_variance(v) - (1.0 - length) / length;
            assert!(error.abs() < 2e-6, "{v}: {error}");
        }
    }

    /// For tilted mean slopes the variance is approximate. The test bounds its relative error.
    #[test]
    fn tilted_and_anisotropic_normals_are_near() {
        let mut worst = 0.0f64;
        for m in [DVec2::ZERO, DVec2::new(0.3, 0.1), DVec2::new(-0.2, 0.8)] {
            for s in [DVec3::new(0.04, 0.04, 0.0), DVec3::new(0.1, 0.01, 0.02), DVec3::new(0.25, 0.04, 0.0)] {
                let length = filtered_normal(m, s).length();
                let exact = (1.0 - length) / length;
                worst = worst.max((toksvig_variance(normal_variance(m, s)) / exact - 1.0).abs());
            }
        }
        println!("Toksvig's variance: largest error {:.1} %", 100.0 * worst);
        assert!(worst < 0.06 && worst > 0.01, "{worst}");
    }
}
