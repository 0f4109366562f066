//! The noncentral anisotropic Beckmann distribution, with Gaussian slopes (LEADR eq. 8–10).

use super::beckmann_sampling::beckmann_sample_visible;
use super::ellipse::{
    Bivariate, Ellipse, covariance_from_roughness, moments_from_covariance, roughness_from_bivariate,
    roughness_from_ellipse,
};
use super::projected_area::visible_area;
use super::slope_distribution::{SlopeDistribution, visible_density};
use crate::limits::MIN_NORMAL_Z;
use crate::slopes::statistics::{covariance_from_moments, slope_scales, widened_covariance};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Returns the slope density `P22(slope)`. Variances are clamped to at least [`MIN_VARIANCE`](crate::limits::MIN_VARIANCE).
pub fn beckmann_p22(slope: DVec2, m: DVec2, s: DVec3) -> f64 {
    let (sigma, r, q) = slope_scales(s);
    // For a strong correlation, whitening x and then y given x is more precise than using the adjugate matrix.
    let u = (slope - m) / sigma;
    let v = (u.y - r * u.x) / q;
    (-0.5 * (u.x * u.x + v * v)).exp() / (2.0 * PI * sigma.x * sigma.y * q)
}

/// Returns the normal density `D(wh) = P22(slope of wh) / wh.z⁴` per unit of macrosurface and solid angle (LEADR eq. 10). The density is 0
/// for `wh.z ≤ 0`.
pub fn beckmann_ndf(wh: DVec3, m: DVec2, s: DVec3) -> f64 {
    if wh.z <= 0.0 {
        return 0.0;
    }
    let z = wh.z.max(MIN_NORMAL_Z);
    beckmann_p22(DVec2::new(-wh.x / z, -wh.y / z), m, s) / (z * z * z * z)
}

/// Returns the density of visible normals per solid angle, `max(0, wo·wn) D(wn) / A(wo)`. The result is at most 1e37.
pub fn beckmann_vndf(wo: DVec3, wn: DVec3, m: DVec2, s: DVec3) -> f64 {
    visible_density(wo, wn, beckmann_ndf(wn, m, s), visible_area(wo, m, s))
}

/// A Beckmann surface with Gaussian slopes of any mean and covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beckmann {
    mean: DVec2,
    covariance: DVec3,
}

impl Beckmann {
    /// Creates a surface from the mean slope and the covariance `(s_xx, s_yy, s_xy)`. Variances are clamped to
    /// [`MIN_VARIANCE`](crate::limits::MIN_VARIANCE)..[`MAX_SLOPE`](crate::limits::MAX_SLOPE)², and the correlation is clamped to
    /// ±[`MAX_CORRELATION`](crate::limits::MAX_CORRELATION).
    pub fn new(mean: DVec2, covariance: DVec3) -> Self {
        Self { mean, covariance: widened_covariance(covariance) }
    }

    /// Creates an isotropic surface of roughness `α` (`α² = 2σ²`).
    pub fn isotropic(mean: DVec2, alpha: f64) -> Self {
        Self::new(mean, DVec3::new(0.5 * alpha * alpha, 0.5 * alpha * alpha, 0.0))
    }

    /// Creates a surface from roughness radii and an angle.
    pub fn from_ellipse(mean: DVec2, ellipse: &Ellipse) -> Self {
        Self::new(mean, covariance_from_roughness(roughness_from_ellipse(ellipse)))
    }

    /// Creates a surface from roughness scales and a correlation.
    pub fn from_bivariate(mean: DVec2, bivariate: &Bivariate) -> Self {
        Self::new(mean, covariance_from_roughness(roughness_from_bivariate(bivariate)))
    }

    /// Creates a surface from the slope moments `(E[x], E[y])` and `(E[xx], E[yy], E[xy])`.
    pub fn from_moments(first: DVec2, second: DVec3) -> Self {
        Self::new(first, covariance_from_moments(first, second))
    }

    /// Returns the slope moments `(E[x], E[y])` and `(E[xx], E[yy], E[xy])`.
    pub fn moments(&self) -> (DVec2, DVec3) {
        moments_from_covariance(self.mean, self.covariance)
    }

    /// Returns the slope covariance `(s_xx, s_yy, s_xy)`.
    pub fn covariance(&self) -> DVec3 {
        self.covariance
    }
}

impl SlopeDistribution for Beckmann {
    fn p22(&self, slope: DVec2) -> f64 {
        beckmann_p22(slope, self.mean, self.covariance)
    }

    fn ndf(&self, wn: DVec3) -> f64 {
        beckmann_ndf(wn, self.mean, self.covariance)
    }

    fn mean_slope(&self) -> DVec2 {
        self.mean
    }

    fn shape(&self) -> DVec3 {
        self.covariance
    }

    fn visible_area(&self, w: DVec3) -> f64 {
        visible_area(w, self.mean, self.covariance)
    }

    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec3 {
        beckmann_sample_visible(wo, u, self.mean, self.covariance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre;

    #[test]
    fn p22_has_its_moments() {
        let (m, s) = (DVec2::new(0.4, -0.3), DVec3::new(0.3, 0.08, 0.11));
        let nodes = gauss_legendre(120);
        let mut sums = [0.0; 6];
        for &(u, wu) in &nodes {
            for &(v, wv) in &nodes {
                let p = DVec2::new(m.x + 5.0 * u, m.y + 3.0 * v);
                let w = 15.0 * wu * wv * beckmann_p22(p, m, s);
                let d = p - m;
                for (sum, f) in sums.iter_mut().zip([1.0, d.x, d.y, d.x * d.x, d.y * d.y, d.x * d.y]) {
                    *sum += w * f;
                }
            }
        }
        for (sum, expected) in sums.into_iter().zip([1.0, 0.0, 0.0, s.x, s.y, s.z]) {
            assert!((sum - expected).abs() < 1e-9, "{sums:?}");
        }
    }

    #[test]
    fn ndf_projects_to_one() {
        // Check the normalisation ∫ (wn·wg) D dω = 1.
        let (m, s) = (DVec2::new(0.2, 0.1), DVec3::new(0.2, 0.3, -0.1));
        let mut sum = 0.0;
        for (u, w) in gauss_legendre(400) {
            let z = 0.5 + 0.5 * u;
            for i in 0..200 {
                let (sin, cos) = (2.0 * PI * f64::from(i) / 200.0).sin_cos();
                let r = (1.0 - z * z).sqrt();
                sum += 0.5 * w * 2.0 * PI / 200.0 * z * beckmann_ndf(DVec3::new(r * cos, r * sin, z), m, s);
            }
        }
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    }

    #[test]
    fn finite_everywhere() {
        for s in [DVec3::ZERO, DVec3::new(1e-30, 4.0, 9.0), DVec3::splat(1e30)] {
            for wh in [DVec3::ZERO, DVec3::X, DVec3::NEG_Z, DVec3::new(1.0, 0.0, 1e-30), DVec3::Z] {
                assert!(beckmann_ndf(wh, DVec2::ZERO, s).is_finite());
            }
        }
    }
}
