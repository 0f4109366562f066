//! Parametrisations of anisotropic roughness, and lossless conversions between these parametrisations (thesis 2.3, eq. 2.25–2.34).
//!
//! Distributions are evaluated from the roughness matrix `A = (a_xx, a_yy, a_xy)`. Slopes are `m + C s` with `C Cᵀ = A` and `s` from the
//! standard distribution. The matrix can be written as an [`Ellipse`] (radii and angle) or as a [`Bivariate`] (scales and correlation). A
//! Beckmann surface has the slope covariance `S = A / 2` (`α² = 2σ²`). A GGX surface has no finite covariance, only the roughness matrix.
//!
//! The sign of the angle follows eq. 2.31. The printed eq. 2.25 and 2.34 have the opposite sign. The major axis is at the angle `φ`
//! counter-clockwise in the slope plane, `A = R(φ) diag(α₁², α₂²) R(φ)ᵀ`, so a positive angle gives a positive correlation.

use glam::{DVec2, DVec3};

/// An anisotropic roughness, given as an ellipse in the slope plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// The radii `(α₁, α₂)`, each at least 0. Conversions to an ellipse give `α₁ ≥ α₂`.
    pub radii: DVec2,
    /// The angle from the x slope to the first axis, in radians. Conversions give an angle in `(−π/2, π/2]`, which is 0 for a circle.
    pub angle: f64,
}

/// An anisotropic roughness, given as two scales and a correlation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bivariate {
    /// The scales `(αx, αy)`, each at least 0.
    pub alpha: DVec2,
    /// The correlation `ρ`, from −1 to 1.
    pub rho: f64,
    /// The value of `√(1 − ρ²)`, from 0 to 1. It is stored because a `ρ` near 1 has too few digits for the minor radius of a thin ellipse.
    pub independence: f64,
}

impl Bivariate {
    /// Creates the roughness from two scales and a correlation from −1 to 1.
    pub fn new(alpha: DVec2, rho: f64) -> Self {
        Self { alpha, rho, independence: ((1.0 - rho) * (1.0 + rho)).max(0.0).sqrt() }
    }
}

/// Converts an ellipse to scales and a correlation by thesis eq. 2.29–2.31. The code avoids differences of squares, so it preserves a minor
/// radius of 1e-12 times the major radius.
pub fn bivariate_from_ellipse(e: &Ellipse) -> Bivariate {
    let (sin, cos) = e.angle.sin_cos();
    let alpha = DVec2::new((e.radii.x * cos).hypot(e.radii.y * sin), (e.radii.x * sin).hypot(e.radii.y * cos));
    let product = alpha.x * alpha.y;
    if product < 1e-300 {
        // One scale is zero, so the slopes are independent.
        return Bivariate { alpha, rho: 0.0, independence: 1.0 };
    }
    let difference = (e.radii.x - e.radii.y) * (e.radii.x + e.radii.y);
    Bivariate {
        alpha,
        rho: (difference * sin * cos / product).clamp(-1.0, 1.0),
        independence: (e.radii.x * e.radii.y / product).min(1.0),
    }
}

/// Converts scales and a correlation to an ellipse by thesis eq. 2.32–2.34, with the sign of the angle of eq. 2.31. The minor radius is `α₂ = αx αy √(1 − ρ²) / α₁`, which avoids a
/// difference.
pub fn ellipse_from_bivariate(b: &Bivariate) -> Ellipse {
    let product = b.alpha.x * b.alpha.y;
    let difference = (b.alpha.x - b.alpha.y) * (b.alpha.x + b.alpha.y);
    let twice = 2.0 * b.rho * product;
    let major = (0.5 * (b.alpha.length_squared() + difference.hypot(twice))).sqrt();
    Ellipse {
        radii: DVec2::new(major, (product * b.independence / major.max(1e-150)).min(major)),
        angle: 0.5 * angle_of(twice, difference),
    }
}

/// Returns `atan2(y, x)`, except that the result is 0 at the origin and π for `y = −0` and `x < 0`.
fn angle_of(y: f64, x: f64) -> f64 {
    if y == 0.0 { if x < 0.0 { std::f64::consts::PI } else { 0.0 } } else { y.atan2(x) }
}

/// Returns the roughness matrix `A` of an ellipse.
pub fn roughness_from_ellipse(e: &Ellipse) -> DVec3 {
    let (sin, cos) = e.angle.sin_cos();
    let (x, y) = (e.radii.x * e.radii.x, e.radii.y * e.radii.y);
    DVec3::new(
        x * cos * cos + y * sin * sin,
        x * sin * sin + y * cos * cos,
        (e.radii.x - e.radii.y) * (e.radii.x + e.radii.y) * sin * cos,
    )
}

/// Returns the roughness matrix `A = (αx², αy², ρ αx αy)`.
pub fn roughness_from_bivariate(b: &Bivariate) -> DVec3 {
    DVec3::new(b.alpha.x * b.alpha.x, b.alpha.y * b.alpha.y, b.rho * b.alpha.x * b.alpha.y)
}

/// Returns the scales and the correlation of `A`. A matrix that rounding has made indefinite is treated as fully correlated.
///
/// The determinant suffers from cancellation, so rounding loses a minor radius below 1e-8 times the major radius.
pub fn bivariate_from_roughness(a: DVec3) -> Bivariate {
    let alpha = DVec2::new(a.x.max(0.0).sqrt(), a.y.max(0.0).sqrt());
    let product = alpha.x * alpha.y;
    if product < 1e-300 {
        return Bivariate { alpha, rho: 0.0, independence: 1.0 };
    }
    let determinant = a.z.mul_add(-a.z, a.x * a.y) + a.x.mul_add(a.y, -(a.x * a.y));
    Bivariate {
        alpha,
        rho: (a.z / product).clamp(-1.0, 1.0),
        independence: (determinant.max(0.0).sqrt() / product).min(1.0),
    }
}

/// Returns the radii and the angle of `A`.
pub fn ellipse_from_roughness(a: DVec3) -> Ellipse {
    ellipse_from_bivariate(&bivariate_from_roughness(a))
}

/// Returns the slope covariance `S = A / 2` of a Beckmann surface with the roughness matrix `A` (`α² = 2σ²`).
pub fn covariance_from_roughness(a: DVec3) -> DVec3 {
    0.5 * a
}

/// Returns the moments `(E[x], E[y])` and `(E[xx], E[yy], E[xy])` of slopes with mean `m` and covariance `s` (LEADR eq. 9). The conversion
/// is the inverse of [`covariance_from_moments`](crate::slopes::statistics::covariance_from_moments), up to the rounding of `m²`.
pub fn moments_from_covariance(m: DVec2, s: DVec3) -> (DVec2, DVec3) {
    (m, DVec3::new(m.x.mul_add(m.x, s.x), m.y.mul_add(m.y, s.y), m.x.mul_add(m.y, s.z)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slopes::statistics::{clamp_covariance, covariance_from_moments};
    use std::f64::consts::FRAC_PI_2;

    fn close(a: f64, b: f64, tolerance: f64) -> bool {
        (a - b).abs() <= tolerance * a.abs().max(b.abs())
    }

    fn ellipses() -> Vec<Ellipse> {
        let mut all = Vec::new();
        for major in [1e-9, 0.3, 1.0, 20.0] {
            for ratio in [1.0, 0.999, 0.5, 1e-3, 1e-6, 1e-12, 0.0] {
                for angle in [-1.5, -FRAC_PI_2 / 2.0, -1e-3, -1e-10, 0.0, 1e-10, 0.4, FRAC_PI_2 / 2.0, 1.57, FRAC_PI_2]
                {
                    all.push(Ellipse { radii: DVec2::new(major, major * ratio), angle });
                }
            }
        }
        all
    }

    #[test]
    fn ellipse_to_bivariate_and_back_loses_nothing() {
        let mut worst = [0.0f64; 3];
        for e in ellipses() {
            let b = bivariate_from_ellipse(&e);
            let back = ellipse_from_bivariate(&b);
            let relative = |a: f64, b: f64| if a == b { 0.0 } else { (a - b).abs() / b.abs() };
            worst[0] = worst[0].max(relative(back.radii.x, e.radii.x));
            // A minor radius of zero comes back as a rounding error, unless the ellipse is axis-aligned.
            let minor = if e.radii.y > 0.0 { relative(back.radii.y, e.radii.y) } else { back.radii.y / e.radii.x };
            worst[1] = worst[1].max(minor);
            // The angle of a circle is undefined.
            let eccentric = 1.0 - e.radii.y / e.radii.x;
            let rotation = (back.angle - e.angle).rem_euclid(2.0 * FRAC_PI_2);
            worst[2] = worst[2].max(rotation.min(2.0 * FRAC_PI_2 - rotation) * eccentric);
        }
        println!("ellipse round trip: major {:.1e}, minor {:.1e}, angle {:.1e}", worst[0], worst[1], worst[2]);
        assert!(worst[0] < 1e-14 && worst[1] < 1e-14 && worst[2] < 1e-14, "{worst:?}");
    }

    #[test]
    fn bivariate_to_ellipse_and_back_loses_nothing() {
        for x in [0.0, 1e-6, 0.4, 3.0] {
            for y in [0.0, 0.1, 0.4] {
                for rho in [0.0, 0.5, -0.95, 1.0 - 1e-9, -1.0 + 1e-15, 1.0, -1.0] {
                    let b = Bivariate::new(DVec2::new(x, y), if x * y == 0.0 { 0.0 } else { rho });
                    let back = bivariate_from_ellipse(&ellipse_from_bivariate(&b));
                    // The angle cannot represent a scale below 1e-16 times the larger scale, so compare absolute errors.
                    let floor = 1e-15 * x.max(y);
                    assert!((back.alpha - b.alpha).abs().max_element() <= 1e-14 * x.max(y) + floor, "{b:?} {back:?}");
                    let (a, a_back) = (roughness_from_bivariate(&b), roughness_from_bivariate(&back));
                    assert!((a - a_back).abs().max_element() <= 4e-15 * (a.x + a.y), "{b:?} {back:?}");
                    if x.min(y) > 0.01 {
                        assert!((back.rho - b.rho).abs() < 1e-14);
                        assert!(close(back.independence, b.independence, 1e-14) || b.independence < 1e-15);
                    }
                }
            }
        }
    }

    /// Recomputing `independence` from `ρ` loses the minor radius of a thin ellipse.
    #[test]
    fn the_correlation_alone_is_lossy() {
        let e = Ellipse { radii: DVec2::new(1.0, 1e-10), angle: 0.7 };
        let b = bivariate_from_ellipse(&e);
        let naive = ellipse_from_bivariate(&Bivariate::new(b.alpha, b.rho));
        assert!(!close(naive.radii.y, e.radii.y, 1e-2));
        assert!(close(ellipse_from_bivariate(&b).radii.y, e.radii.y, 1e-14));
    }

    #[test]
    fn the_matrix_agrees_with_both() {
        for e in ellipses() {
            let (a, b) = (roughness_from_ellipse(&e), roughness_from_bivariate(&bivariate_from_ellipse(&e)));
            assert!((a - b).length() <= 1e-14 * a.length(), "{e:?}: {a} {b}");
            let back = ellipse_from_roughness(a);
            assert!(close(back.radii.x, e.radii.x, 1e-14), "{e:?} {back:?}");
            assert!((back.radii.y - e.radii.y).abs() <= 2e-8 * e.radii.x, "{e:?} {back:?}");
        }
        // A positive (counter-clockwise) angle gives a positive slope correlation.
        let tilted = Ellipse { radii: DVec2::new(1.0, 0.2), angle: 0.5 };
        assert!(bivariate_from_ellipse(&tilted).rho > 0.5);
        let tall = Ellipse { radii: DVec2::new(1.0, 0.2), angle: FRAC_PI_2 };
        assert!(bivariate_from_ellipse(&tall).alpha.y == 1.0);
    }

    #[test]
    fn moments_and_back() {
        let mut compared = 0;
        for m in [DVec2::ZERO, DVec2::new(0.5, -0.25), DVec2::new(8.0, 3.0)] {
            for e in ellipses().into_iter().filter(|e| e.radii.x < 2.0) {
                let s = covariance_from_roughness(roughness_from_ellipse(&e));
                let (first, second) = moments_from_covariance(m, s);
                let back = covariance_from_moments(first, second);
                let rounding = 4e-16 * (m.length_squared() + s.x + s.y);
                assert!((back - s).abs().truncate().max_element() <= rounding, "{m} {s}");
                // Beyond MAX_CORRELATION the inverse clamps the correlation.
                if clamp_covariance(s) == s && s.x.min(s.y) > 1e-3 {
                    compared += 1;
                    assert!((back.z - s.z).abs() <= rounding, "{m} {s}");
                }
            }
        }
        assert!(compared > 50);
    }
}
