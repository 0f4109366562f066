//! The noncentral anisotropic Beckmann distribution: slopes are Gaussian (LEADR eq. 8–10).

use super::limits::{MAX_SLOPE, MIN_NORMAL_Z, MIN_VARIANCE};
use super::slope_statistics::slope_correlation;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// `P22(slope)`: density of slopes. Variances count as at least [`MIN_VARIANCE`].
#[must_use]
pub fn beckmann_p22(slope: DVec2, m: DVec2, s: DVec3) -> f64 {
    let deviation = |variance: f64| variance.clamp(MIN_VARIANCE, MAX_SLOPE * MAX_SLOPE).sqrt();
    let sigma = DVec2::new(deviation(s.x), deviation(s.y));
    let r = slope_correlation(sigma, s.z);
    // Whitened: x, then y given x. Loses less than the adjugate when the correlation is strong.
    let u = (slope - m) / sigma;
    let q = ((1.0 - r) * (1.0 + r)).sqrt();
    let v = (u.y - r * u.x) / q;
    (-0.5 * (u.x * u.x + v * v)).exp() / (2.0 * PI * sigma.x * sigma.y * q)
}

/// `D(wh) = P22(slope of wh) / wh.z⁴`: density of normals per unit of macrosurface and solid angle (LEADR eq. 10); 0 for
/// `wh.z ≤ 0`.
#[must_use]
pub fn beckmann_ndf(wh: DVec3, m: DVec2, s: DVec3) -> f64 {
    if wh.z <= 0.0 {
        return 0.0;
    }
    let z = wh.z.max(MIN_NORMAL_Z);
    beckmann_p22(DVec2::new(-wh.x / z, -wh.y / z), m, s) / (z * z * z * z)
}

#[cfg(test)]
mod tests {
    use super::super::quadrature::gauss_legendre;
    use super::*;

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
        // ∫ (wn·wg) D dω = 1.
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
