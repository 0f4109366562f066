//! Computes the highlights of a small area light.
//!
//! A facet reflects `wi` to `wo` if its slope is `s = −h.xy/h.z`, where `h = wo + wi`. The directions of the light deviate from `wi` by
//! `δ`, which is orthogonal to `wi` and has the variance `v` along each axis. The reflecting slopes then deviate by
//!
//! ```text
//! ds = −(δ.xy + s δ.z) / h.z                   E[δ δᵀ] = v (1 − wi wiᵀ)
//! E[ds dsᵀ] = v / h.z² (1 + s sᵀ − q qᵀ)       q = wi.xy + s wi.z
//! ```
//!
//! The formula is accurate to first order, but slopes grow without bound towards the horizon. Without a bound on `h.z`, half vectors just
//! above the horizon would be too frequent, so `h.z` is clamped to at least 16 standard deviations of the light.
//!
//! To average a Gaussian slope density at `s` over the light, add `E[ds dsᵀ]` to the covariance of the density. All other factors that
//! depend on `wi` (Fresnel, shadowing) are evaluated at the centre of the light.

use glam::{DVec2, DVec3};

/// The lower bound of the z component of `wo + wi`, in standard deviations of the light.
const LEAST_HALF_Z: f64 = 16.0;

/// Returns the covariance `(s_xx, s_yy, s_xy)` of the slopes that reflect a light to `wo`. Callers add it to the surface's slope
/// covariance. `variance` is the variance of the light's directions in radians², along each of two axes across `wi`.
pub fn light_slope_covariance(wo: DVec3, wi: DVec3, variance: f64) -> DVec3 {
    let h = wo + wi;
    let per = 1.0 / h.z.max(LEAST_HALF_Z * variance.sqrt()).max(1e-3);
    let s = -h.truncate() * per;
    let q = wi.truncate() + s * wi.z;
    let square = DVec2::ONE + s * s - q * q;
    DVec3::new(square.x, square.y, s.x * s.y - q.x * q.y) * (variance * per * per)
}

/// Returns the variance of half vectors per axis, averaged over two axes. In the plane of incidence, half vectors rotate half as far as the
/// light. Across this plane, they rotate by `1/(2 cosine)` of the light's rotation. `cosine` is the cosine between `wo` and the half
/// vector.
pub fn light_normal_variance(cosine: f64, variance: f64) -> f64 {
    0.125 * variance * (1.0 + 1.0 / (cosine * cosine).max(1e-3))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slope(wo: DVec3, wi: DVec3) -> DVec2 {
        let h = wo + wi;
        -h.truncate() / h.z
    }

    #[test]
    fn the_covariance_is_that_of_the_slopes_over_a_small_light() {
        for (wo, wi) in [
            (DVec3::new(0.3, -0.2, 0.9), DVec3::new(-0.5, 0.1, 0.7)),
            (DVec3::new(0.9, 0.1, 0.2), DVec3::new(-0.8, 0.4, 0.3)),
            (DVec3::new(0.0, 0.0, 1.0), DVec3::new(0.0, 0.0, 1.0)),
            (DVec3::new(0.7, 0.0, 0.5), DVec3::new(0.6, 0.6, -0.1)),
        ] {
            let (wo, wi) = (wo.normalize(), wi.normalize());
            let (x, y) = wi.any_orthonormal_pair();
            let deviation = 1e-4;
            // Four points at √2 standard deviations on the axes have the light's variance along each axis.
            let (mut sum, n) = (DVec3::ZERO, 64);
            for k in 0..n {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(n)).sin_cos();
                let d = slope(wo, wi + (x * cos + y * sin) * (deviation * 2f64.sqrt())) - slope(wo, wi);
                sum += DVec3::new(d.x * d.x, d.y * d.y, d.x * d.y) / f64::from(n);
            }
            let got = light_slope_covariance(wo, wi, deviation * deviation);
            assert!((got - sum).length() < 1e-3 * sum.length(), "{got} {sum}");
        }
    }

    #[test]
    fn half_vectors_rotate_by_half_at_normal_incidence() {
        assert!((light_normal_variance(1.0, 0.01) - 0.0025).abs() < 1e-15);
        assert!((light_slope_covariance(DVec3::Z, DVec3::Z, 0.01) - DVec3::new(0.0025, 0.0025, 0.0)).length() < 1e-15);
    }
}
