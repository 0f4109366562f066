//! The visible slopes of a Gaussian surface, in closed form.
//!
//! Let `u` be the slope along the view azimuth in standard deviations, `u = wo.xy·(slope − m)/b`. A facet's projected area is then
//! `a − b u`. The visible slopes therefore have the density `max(0, a − b u) φ(u) / A` along `u`, and stay Gaussian across the view
//! azimuth. The moments of a clamped line times a normal density have closed forms. With `ν = a/b`, `Φ` and `φ` evaluated at `ν`, and
//! `H = ν Φ + φ`,
//!
//! ```text
//! E[u] = −Φ/H,   E[u²] = 1 + φ/H,   E[u³] = (ν φ − 3 Φ)/H,   E[u⁴] = 3 + (ν² + 5) φ/H
//! ```
//!
//! The formulas use `S wo.xy` instead of the azimuth, so normal incidence is not a special case.

use crate::facets::normal_distribution::{NormalRamp, normal_ramp};
use crate::facets::projected_area::{face_viewer, meso_area, spread_along};
use crate::slopes::statistics::{clamp_covariance, outer_square};
use glam::{DVec2, DVec3};

/// The limit of a back-facing mesosurface's area, in units of `slope_spread`. Beyond this limit, almost nothing is visible (0.8 % of
/// `slope_spread`), and `face_viewer` tilts the mesosurface back.
pub const VISIBLE_TAIL: f64 = 2.0;

/// Gaussian slopes that are weighted by their visibility to one viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleSlopes {
    /// The mean slope, tilted back if necessary.
    pub m: DVec2,
    /// The covariance of the slopes `(s_xx, s_yy, s_xy)`, clamped to the usable range.
    pub s: DVec3,
    /// The projected area `a(wo)` of the mesosurface.
    pub a: f64,
    /// The spread `b(wo)` of the slope along `wo`.
    pub b: f64,
    /// The positive visible area `A(wo)`.
    pub area: f64,
    /// The change of slope per unit of `u`.
    pub axis: DVec2,
    /// The negated mean of `u` over the visible facets, at least 0.
    pub shift: f64,
    /// The mean of the visible slopes.
    pub mean: DVec2,
    /// The covariance of the visible slopes.
    pub cov: DVec3,
    /// The positive projected area of the facet that has the mean visible slope.
    pub facet: f64,
    /// The variance of `u` over the visible facets, from 0 to 1.
    pub variance: f64,
    /// The third central moment of `u` over the visible facets, at most 0.
    pub third: f64,
    /// The fourth cumulant of `u` over the visible facets.
    pub fourth: f64,
}

/// The moments of the slope `u` over the visible facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleCumulants {
    /// The negated mean, at least 0.
    pub shift: f64,
    /// The variance, from 0 to 1.
    pub variance: f64,
    /// The third central moment, at most 0.
    pub third: f64,
    /// The fourth cumulant.
    pub fourth: f64,
}

/// Returns the moments of the density `max(0, nu − u) φ(u)`. `n` belongs to `nu`.
pub fn visible_cumulants(nu: f64, n: &NormalRamp) -> VisibleCumulants {
    let shift = n.cdf / n.ramp;
    let excess = n.pdf / n.ramp; // the second moment of u minus one
    let shift2 = shift * shift;
    let variance = (1.0 + excess - shift2).clamp(0.02, 1.0);
    let third = nu * excess - 3.0 * shift;
    let fourth = 3.0 + ((nu * nu).min(1e6) + 5.0) * excess;
    VisibleCumulants {
        shift,
        variance,
        third: (third + shift * (3.0 + 3.0 * excess - 2.0 * shift2)).min(0.0),
        fourth: fourth + 4.0 * shift * third + shift2 * (6.0 + 6.0 * excess - 3.0 * shift2) - 3.0 * variance * variance,
    }
}

/// Returns the projected area of a mesosurface that is tilted back to the limit [`VISIBLE_TAIL`]. `m` is the mean slope before the tilt.
pub fn tilted_area(wo: DVec3, m: DVec2, b: f64) -> f64 {
    meso_area(wo, m).max(1e-3 - VISIBLE_TAIL * b)
}

/// Returns the exact moments of the visible slopes. `wo` is a unit vector, and `m` and `s` may have any finite value.
pub fn visible_slopes(wo: DVec3, m: DVec2, s: DVec3) -> VisibleSlopes {
    let s = clamp_covariance(s);
    let (across, b) = spread_along(wo, s);
    let a = tilted_area(wo, m, b);
    let m = face_viewer(wo, m, s, 2.0 * VISIBLE_TAIL);
    let per_b = 1.0 / b.max(1e-18);
    let nu = a * per_b;
    let n = normal_ramp(nu);
    let axis = across * per_b;
    let u = visible_cumulants(nu, &n);
    VisibleSlopes {
        m,
        s,
        a,
        b,
        area: if b <= 1e-18 { a.max(0.0) } else { b * n.ramp },
        axis,
        shift: u.shift,
        mean: m - axis * u.shift,
        cov: s - (1.0 - u.variance) * outer_square(axis),
        facet: a + b * u.shift,
        variance: u.variance,
        third: u.third,
        fourth: u.fourth,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrals::reference::visible_mean;
    use glam::Vec3Swizzles as _;

    #[test]
    fn moments_are_the_integrals() {
        let s = DVec3::new(0.6, 0.05, 0.1);
        for (wo, m) in [
            (DVec3::Z, DVec2::new(0.2, -0.4)),
            (DVec3::new(0.3, 0.5, 0.7).normalize(), DVec2::new(0.2, -0.4)),
            (DVec3::new(0.8, -0.59, 0.1).normalize(), DVec2::new(0.5, 0.2)),
            (DVec3::new(0.6, 0.0, 0.8), DVec2::new(2.0, 0.0)),
        ] {
            let v = visible_slopes(wo, m, s);
            let mean = visible_mean(wo, m, s, 20, |t| t.extend(0.0));
            assert!((v.mean - mean.xy()).length() < 1e-9, "mean {} instead of {mean}", v.mean);
            let second = visible_mean(wo, m, s, 20, |t| {
                let d = t - v.mean;
                DVec3::new(d.x * d.x, d.y * d.y, d.x * d.y)
            });
            assert!((v.cov - second).length() < 1e-9, "covariance {} instead of {second}", v.cov);
            if v.b < 1e-9 {
                continue;
            }
            let power = |n| visible_mean(wo, m, s, 20, |t| DVec3::splat(((t - v.mean).dot(wo.xy()) / v.b).powi(n))).x;
            assert!((v.third - power(3)).abs() < 1e-8, "third {} instead of {}", v.third, power(3));
            let fourth = power(4) - 3.0 * power(2) * power(2);
            assert!((v.fourth - fourth).abs() < 1e-8, "fourth {} instead of {fourth}", v.fourth);
        }
    }

    #[test]
    fn regular_where_the_azimuth_is_not() {
        let (m, s) = (DVec2::new(0.1, 0.3), DVec3::new(0.5, 0.2, 0.1));
        let overhead = visible_slopes(DVec3::Z, m, s);
        assert_eq!((overhead.mean, overhead.cov), (m, s));
        for phi in 0..8 {
            let wo = DVec3::new(1e-6 * f64::from(phi).cos(), 1e-6 * f64::from(phi).sin(), 1.0);
            let v = visible_slopes(wo, m, s);
            assert!((v.mean - m).length() < 1e-6 && (v.cov - s).length() < 1e-6);
        }
    }
}
