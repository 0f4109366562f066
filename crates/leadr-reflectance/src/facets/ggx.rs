//! The noncentral GGX distribution with a full roughness matrix (thesis Table 2.II and eq. 3.2; IGSA supplement 1).
//!
//! Slopes are `m + C s` with `C Cᵀ = A = (a_xx, a_yy, a_xy)`. `s` has the standard density `1 / (π (1 + s²)²)`, the bivariate t
//! distribution with two degrees of freedom. `A` holds `α²` terms, because the variance of GGX slopes is infinite.
//!
//! The standard surface is a hemisphere (`D = 1/π`). A hemisphere viewed at `cos θ'` has the visible area `(1 + cos θ') / 2`, for viewers
//! above and below the horizon. With the mesosurface's projected area `a` and `b² = w.xyᵀ A w.xy`, the visible area is
//! `A(w) = (a + √(a² + b²)) / 2` for every sign of `a`.

use super::ellipse::{Bivariate, Ellipse, roughness_from_bivariate, roughness_from_ellipse};
use super::ggx_sampling::ggx_sample_visible;
use super::projected_area::{meso_area, slope_spread};
use super::slope_distribution::{SlopeDistribution, visible_density};
use crate::limits::MIN_AREA;
use crate::slopes::statistics::{slope_scales, widened_covariance};
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::PI;

/// Returns the slope density `P22(slope)` (thesis eq. 3.2). Diagonal elements are clamped to at least
/// [`MIN_VARIANCE`](crate::limits::MIN_VARIANCE).
pub fn ggx_p22(slope: DVec2, m: DVec2, a: DVec3) -> f64 {
    let (alpha, r, q) = slope_scales(a);
    let u = (slope - m) / alpha;
    let v = (u.y - r * u.x) / q;
    let g = 1.0 / (1.0 + u.x * u.x + v * v);
    g * g / (PI * alpha.x * alpha.y * q)
}

/// Returns the normal density `D(wh) = P22(slope of wh) / wh.z⁴` per unit of macrosurface and solid angle. The density is 0 for `wh.z ≤ 0`.
///
/// The formula `1 / (π √|A| (z² + d²)²)`, where `d` is the whitened `-wh.xy − wh.z m`, avoids the division by `wh.z`. The density does not
/// vanish towards the horizon.
pub fn ggx_ndf(wh: DVec3, m: DVec2, a: DVec3) -> f64 {
    if wh.z <= 0.0 {
        return 0.0;
    }
    let (alpha, r, q) = slope_scales(a);
    let u = (-wh.xy() - wh.z * m) / alpha;
    let v = (u.y - r * u.x) / q;
    let g = 1.0 / (wh.z * wh.z + u.x * u.x + v * v).max(1e-13);
    g * g / (PI * alpha.x * alpha.y * q)
}

/// Returns the area that only roughness makes visible, `A − max(a, 0) = b² / (2 (|a| + √(a² + b²)))`. The area equals `a Λ` for `a > 0`.
pub fn ggx_rough_area(a: f64, b: f64) -> f64 {
    0.5 * b * (b / (a.abs() + a.hypot(b)).max(1e-18))
}

/// Returns the visible projected area per unit of macrosurface, `A(w) = (a + √(a² + b²)) / 2`, computed without cancellation.
pub fn ggx_visible_area(w: DVec3, m: DVec2, a: DVec3) -> f64 {
    let meso = meso_area(w, m);
    meso.max(0.0) + ggx_rough_area(meso, slope_spread(w, a))
}

/// Returns `Λ(w) = (√(1 + b²/a²) − 1) / 2` (thesis Table 2.III). The result is large but finite where `Λ` is `+∞` (`a ≤ 0`).
pub fn ggx_lambda(w: DVec3, m: DVec2, a: DVec3) -> f64 {
    let meso = meso_area(w, m);
    ggx_rough_area(meso, slope_spread(w, a)) / meso.max(MIN_AREA)
}

/// Returns `1 / A(wo)`, which is masking without shadowing, times the projected area of LEADR eq. 16.
pub fn ggx_masking(wo: DVec3, m: DVec2, a: DVec3) -> f64 {
    1.0 / ggx_visible_area(wo, m, a).max(MIN_AREA)
}

/// Returns the height-correlated masking and shadowing `1 / (a_o (1 + Λo + Λi))`, LEADR eq. 13 with the `Λ` of GGX. The result is 0 for a
/// light below the mesosurface, and equals [`ggx_masking`] without `shadowing`.
pub fn ggx_masking_shadowing(wo: DVec3, wi: DVec3, m: DVec2, a: DVec3, shadowing: bool) -> f64 {
    if !shadowing {
        return ggx_masking(wo, m, a);
    }
    let ao = meso_area(wo, m).max(0.0);
    let ai = meso_area(wi, m).max(0.0);
    let visible = ggx_visible_area(wo, m, a).max(MIN_AREA);
    ai / (ai * visible + ao * ggx_rough_area(ai, slope_spread(wi, a))).max(1e-30)
}

/// Returns the density of visible normals per solid angle, `max(0, wo·wn) D(wn) / A(wo)`. The result is at most 1e37.
pub fn ggx_vndf(wo: DVec3, wn: DVec3, m: DVec2, a: DVec3) -> f64 {
    visible_density(wo, wn, ggx_ndf(wn, m, a), ggx_visible_area(wo, m, a))
}

/// A GGX surface with any mean slope and roughness matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    mean: DVec2,
    roughness: DVec3,
}

impl Ggx {
    /// Creates a surface from the mean slope and the roughness matrix `A = (a_xx, a_yy, a_xy)` of `α²` terms. The diagonal is clamped to
    /// [`MIN_VARIANCE`](crate::limits::MIN_VARIANCE)..[`MAX_SLOPE`](crate::limits::MAX_SLOPE)², and the correlation is clamped to
    /// ±[`MAX_CORRELATION`](crate::limits::MAX_CORRELATION).
    pub fn new(mean: DVec2, roughness: DVec3) -> Self {
        Self { mean, roughness: widened_covariance(roughness) }
    }

    /// Creates an isotropic surface of roughness `α`.
    pub fn isotropic(mean: DVec2, alpha: f64) -> Self {
        Self::new(mean, DVec3::new(alpha * alpha, alpha * alpha, 0.0))
    }

    /// Creates a surface from roughness radii and an angle.
    pub fn from_ellipse(mean: DVec2, ellipse: &Ellipse) -> Self {
        Self::new(mean, roughness_from_ellipse(ellipse))
    }

    /// Creates a surface from roughness scales and a correlation.
    pub fn from_bivariate(mean: DVec2, bivariate: &Bivariate) -> Self {
        Self::new(mean, roughness_from_bivariate(bivariate))
    }

    /// Returns the roughness matrix `(a_xx, a_yy, a_xy)`.
    pub fn roughness(&self) -> DVec3 {
        self.roughness
    }
}

impl SlopeDistribution for Ggx {
    fn p22(&self, slope: DVec2) -> f64 {
        ggx_p22(slope, self.mean, self.roughness)
    }

    fn ndf(&self, wn: DVec3) -> f64 {
        ggx_ndf(wn, self.mean, self.roughness)
    }

    fn mean_slope(&self) -> DVec2 {
        self.mean
    }

    fn shape(&self) -> DVec3 {
        self.roughness
    }

    fn visible_area(&self, w: DVec3) -> f64 {
        ggx_visible_area(w, self.mean, self.roughness)
    }

    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec3 {
        ggx_sample_visible(wo, u, self.mean, self.roughness)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::composite_gauss;

    /// Integrates the standard density in polar coordinates about the mean, `s = tan t (cos p, sin p)`.
    fn area_by_quadrature(w: DVec3, m: DVec2, a: DVec3) -> f64 {
        let c = crate::slopes::grid::slope_cholesky(a);
        let along = DVec2::new(c.x * w.x + c.y * w.y, c.z * w.y);
        let (meso, b) = (meso_area(w, m), along.length());
        // The area is the mean of max(0, meso − b x), where x has the marginal density 1 / (2 (1 + x²)^1.5). Substituting x = tan t gives ½
        // ∫ max(0, meso cos t − b sin t) dt.
        let top = meso.atan2(b);
        composite_gauss(-0.5 * PI, top, 4, 16)
            .into_iter()
            .map(|(t, weight)| 0.5 * weight * (meso * t.cos() - b * t.sin()))
            .sum()
    }

    #[test]
    fn visible_area_by_quadrature() {
        let mut away = 0;
        for a in [DVec3::new(0.04, 0.04, 0.0), DVec3::new(1.0, 0.2, 0.4), DVec3::new(9.0, 0.01, -0.299)] {
            for m in [DVec2::ZERO, DVec2::new(0.8, -0.3), DVec2::new(3.0, 2.0)] {
                for degrees in [0.0f64, 30.0, 60.0, 85.0, 89.9, 100.0, 150.0] {
                    let (sin, cos) = degrees.to_radians().sin_cos();
                    let w = DVec3::new(0.8 * sin, 0.6 * sin, cos);
                    away += u32::from(meso_area(w, m) < 0.0);
                    let (got, want) = (ggx_visible_area(w, m, a), area_by_quadrature(w, m, a));
                    assert!((got - want).abs() <= 1e-12 * want.abs() + 1e-14, "{got} {want} at {w} {m} {a}");
                }
            }
        }
        assert!(away > 10);
    }

    #[test]
    fn ndf_is_p22_over_the_fourth_power() {
        let (m, a) = (DVec2::new(0.3, -1.0), DVec3::new(0.5, 0.1, 0.15));
        for wn in [DVec3::new(0.1, 0.3, 0.9), DVec3::new(-0.7, 0.6, 0.05)].map(DVec3::normalize) {
            let want = ggx_p22(-wn.xy() / wn.z, m, a) / wn.z.powi(4);
            assert!((ggx_ndf(wn, m, a) / want - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn finite_everywhere() {
        for a in [DVec3::ZERO, DVec3::new(1e-30, 4.0, 9.0), DVec3::splat(1e30)] {
            for w in [DVec3::ZERO, DVec3::X, DVec3::NEG_Z, DVec3::new(1.0, 0.0, 1e-30), DVec3::Z] {
                for m in [DVec2::ZERO, DVec2::new(1e6, -1e6)] {
                    assert!(ggx_ndf(w, m, a).is_finite() && ggx_visible_area(w, m, a).is_finite());
                    assert!(ggx_masking_shadowing(w, DVec3::X, m, a, true).is_finite());
                    assert!(ggx_lambda(w, m, a).is_finite() && ggx_vndf(DVec3::X, w, m, a).is_finite());
                }
            }
        }
    }
}
