//! The mean and the covariance of the slopes under a pixel, from filtered moments (LEADR 4.1–4.2).

use crate::limits::{MAX_CORRELATION, MAX_GRADIENT_VARIANCE, MAX_SLOPE, MIN_VARIANCE, at_least, within};
use glam::{DMat2, DVec2, DVec3};

/// Returns the nearest usable covariance of slopes (rise over run), with variances in `[0, MAX_SLOPE²]` and
/// `|s_xy| ≤ MAX_CORRELATION √(s_xx s_yy)`. NaN values remain NaN.
pub fn clamp_covariance(s: DVec3) -> DVec3 {
    bounded_covariance(s, MAX_SLOPE * MAX_SLOPE)
}

/// Returns the nearest covariance with variances in `[0, largest]` and `|s_xy| ≤ MAX_CORRELATION √(s_xx s_yy)`. NaN values remain NaN.
pub fn bounded_covariance(s: DVec3, largest: f64) -> DVec3 {
    let (x, y) = (s.x.clamp(0.0, largest), s.y.clamp(0.0, largest));
    let c = MAX_CORRELATION * (x * y).sqrt();
    DVec3::new(x, y, within(s.z, c))
}

/// Applies [`clamp_covariance`] and raises the variances to at least [`MIN_VARIANCE`], as slope densities require.
pub(crate) fn widened_covariance(s: DVec3) -> DVec3 {
    clamp_covariance(with_least_variance(s))
}

/// Raises the variances to at least [`MIN_VARIANCE`]. The off-diagonal element is unchanged.
pub(crate) fn with_least_variance(s: DVec3) -> DVec3 {
    DVec3::new(at_least(s.x, MIN_VARIANCE), at_least(s.y, MIN_VARIANCE), s.z)
}

/// Returns `(√s_xx, √s_yy)`, the correlation `r` and `√(1 − r²)` of a slope density. The variances are clamped to
/// [`MIN_VARIANCE`]..[`MAX_SLOPE`]².
pub(crate) fn slope_scales(s: DVec3) -> (DVec2, f64, f64) {
    let deviation = |variance: f64| variance.clamp(MIN_VARIANCE, MAX_SLOPE * MAX_SLOPE).sqrt();
    let sigma = DVec2::new(deviation(s.x), deviation(s.y));
    let r = slope_correlation(sigma, s.z);
    (sigma, r, ((1.0 - r) * (1.0 + r)).sqrt())
}

/// Returns the correlation coefficient, with `|r| ≤ MAX_CORRELATION`, from the standard deviations and the covariance `s_xy`.
pub fn slope_correlation(sigma: DVec2, sxy: f64) -> f64 {
    (sxy / (sigma.x * sigma.y).max(1e-18)).clamp(-MAX_CORRELATION, MAX_CORRELATION)
}

/// Returns the covariance from the filtered moments `first = (E[x], E[y])` and `second = (E[xx], E[yy], E[xy])` (LEADR eq. 9).
///
/// With large means and small variances, the rounding error can exceed the result. The result is therefore clamped to be positive
/// semidefinite.
///
/// Moments may be in any unit, for instance per texture coordinate, where even flat relief has large values. [`scale_height`] and
/// [`map_covariance`](super::map::map_covariance) convert covariances to slopes and apply the bounds.
pub fn covariance_from_moments(first: DVec2, second: DVec3) -> DVec3 {
    let covariance = DVec3::new(
        (-first.x).mul_add(first.x, second.x),
        (-first.y).mul_add(first.y, second.y),
        (-first.x).mul_add(first.y, second.z),
    );
    bounded_covariance(covariance, MAX_GRADIENT_VARIANCE)
}

/// Returns `linear S linearᵀ`, the second moments `(xx, yy, xy)` of slopes that are transformed by `linear` (LEADR eq. 12).
pub fn map_second_moments(linear: DMat2, s: DVec3) -> DVec3 {
    let (u, v) = (linear.row(0), linear.row(1));
    let (along_u, along_v) = (covariance_times(s, u), covariance_times(s, v));
    DVec3::new(u.dot(along_u), v.dot(along_v), u.dot(along_v))
}

/// Returns `S v` for a symmetric matrix `(xx, yy, xy)`.
pub fn covariance_times(s: DVec3, v: DVec2) -> DVec2 {
    DVec2::new(s.x * v.x + s.z * v.y, s.z * v.x + s.y * v.y)
}

/// Returns `v vᵀ` as `(xx, yy, xy)`.
pub(crate) fn outer_square(v: DVec2) -> DVec3 {
    DVec3::new(v.x * v.x, v.y * v.y, v.x * v.y)
}

/// Returns the covariance after scaling heights by `eta`. The mean slopes also scale by `eta` (LEADR 4.2, Height Scaling).
pub fn scale_height(s: DVec3, eta: f64) -> DVec3 {
    s * (eta * eta)
}

/// Adds the slopes of a base material of Beckmann roughness `alpha` (`α² = 2σ²` converts α to σ).
///
/// Means and covariances of independent layers add. In terms of moments, `E[Z²] = E[X²] + E[Y²] + 2 E[X] E[Y]`.
pub fn add_roughness(s: DVec3, alpha: f64) -> DVec3 {
    s + DVec3::new(0.5 * alpha * alpha, 0.5 * alpha * alpha, 0.0)
}

/// Adds the variance of the macrosurface slope over the pixel. `dx` and `dy` are the slope's differences to the neighbouring pixels.
///
/// A Gaussian pixel filter of variance 0.25 weights the differences, which are then transformed to slope space (Tokuyoshi & Kaplanyan
/// 2019). Their bound `α² ≤ 0.18` of an isotropic kernel becomes `s_xx + s_yy ≤ 0.18` for this matrix. The bound prevents creases and
/// silhouettes, where differences are meaningless, from becoming matt.
pub fn add_macro_curvature(s: DVec3, dx: DVec2, dy: DVec2) -> DVec3 {
    let bound = DVec2::splat(1e3);
    let (dx, dy) = (dx.clamp(-bound, bound), dy.clamp(-bound, bound));
    let kernel = 0.25 * DVec3::new(dx.x * dx.x + dy.x * dy.x, dx.y * dx.y + dy.y * dy.y, dx.x * dx.y + dy.x * dy.y);
    s + kernel * (0.18 / (kernel.x + kernel.y).max(1e-12)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_two_slopes() {
        // Half of the area has the slope (1, 2), and half has the slope (3, −2). The mean is (2, 0), the variances are 1 and 4, and the
        // covariance is −2.
        let (first, second) = (DVec2::new(2.0, 0.0), DVec3::new(5.0, 4.0, -2.0));
        let s = covariance_from_moments(first, second);
        assert_eq!((s.x, s.y), (1.0, 4.0));
        assert_eq!(s.z, -2.0 * MAX_CORRELATION);
    }

    #[test]
    fn rounding_never_leaves_an_indefinite_matrix() {
        // The moments of a constant steep slope are rounded to 32 bits.
        for i in 0..1000 {
            let m = DVec2::new(3.0 + 0.1 * f64::from(i), -7.0 + 0.03 * f64::from(i));
            let f = |v: f64| f64::from(v as f32);
            let s = covariance_from_moments(
                DVec2::new(f(m.x), f(m.y)),
                DVec3::new(f(m.x * m.x), f(m.y * m.y), f(m.x * m.y)),
            );
            assert!(s.x >= 0.0 && s.y >= 0.0 && s.x * s.y - s.z * s.z >= 0.0, "{s} at {m}");
            assert!(s.x < 1e-6 * m.x * m.x);
        }
    }

    #[test]
    fn units_do_not_matter() {
        // Relief on a map 1 km wide has slopes of up to 3000 m per unit texture coordinate, which are slopes of 3 m per metre.
        let (first, second) = (DVec2::new(500.0, -800.0), DVec3::new(1.6e6, 2.2e6, 0.9e6));
        for eta in [1.0, 1e-3, 2f64.powi(-20)] {
            let before = covariance_from_moments(first * eta, second * (eta * eta));
            let after = scale_height(covariance_from_moments(first, second), eta);
            assert!((before - after).length() < 1e-12 * after.length(), "{before} {after}");
        }
        assert_eq!(covariance_from_moments(first, second).x, 1.6e6 - 500.0 * 500.0);
    }

    #[test]
    fn curvature_is_bounded() {
        let s = add_macro_curvature(DVec3::ZERO, DVec2::new(0.2, 0.0), DVec2::new(0.0, 0.4));
        assert!((s - DVec3::new(0.01, 0.04, 0.0)).length() < 1e-15);
        let s = add_macro_curvature(DVec3::ZERO, DVec2::new(1e9, 1e9), DVec2::new(-5.0, 3.0));
        assert!((s.x + s.y - 0.18).abs() < 1e-12 && s.x * s.y >= s.z * s.z);
    }
}
