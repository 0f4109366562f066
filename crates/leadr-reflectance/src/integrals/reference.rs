//! Computes converged integrals over visible slopes. They are the reference for rules with few samples.
//!
//! The domain is whitened, `slope = m + C u` with `C Cᵀ = S`, and rotated so that the view azimuth is the first axis. The projected facet
//! area `a − b u₁` then depends on `u₁` only. The domain ends where this area is 0. The integrand therefore needs no clamp and is smooth.

use crate::facets::normal_distribution::normal_pdf;
use crate::facets::projected_area::{meso_area, slope_spread, visible_area};
use crate::limits::MIN_AREA;
use crate::masking::smith::shadowing_given_masking;
use crate::quadrature::composite_gauss;
use crate::slopes::grid::normal_of_slope;
use glam::{DMat2, DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::PI;

/// The extent of the domain along the view azimuth, in standard deviations. It is large because only the tail of the slopes is visible on a
/// back-facing mesosurface.
const EXTENT: f64 = 8.6;
/// The extent of the domain across the view azimuth, in standard deviations. The truncated mass is 1e-11.
const EXTENT_ACROSS: f64 = 6.8;
/// The number of points per panel of the composite rules.
const ORDER: usize = 8;

/// Returns the factor `C` such that `C Cᵀ = S`, and `Cᵀ wo.xy` lies along the first axis.
fn view_factor(wo: DVec3, s: DVec3) -> DMat2 {
    let sx = s.x.max(0.0).sqrt();
    let k = if sx > 0.0 { s.z / sx } else { 0.0 };
    let cholesky = DMat2::from_cols(DVec2::new(sx, k), DVec2::new(0.0, (s.y - k * k).max(0.0).sqrt()));
    let e = (cholesky.transpose() * wo.xy()).try_normalize().unwrap_or(DVec2::X);
    cholesky * DMat2::from_cols(e, DVec2::new(-e.y, e.x))
}

/// Computes the mean of `g` over the visible slopes, `∫ g(slope) ⟨wn,wo⟩/(wn·wg) P22 dslope / A(wo)`, with `panels`² panels of 8×8 points.
/// The covariance must be positive semidefinite. The result is 0 if no facet is visible.
pub fn visible_mean(wo: DVec3, m: DVec2, s: DVec3, panels: usize, g: impl Fn(DVec2) -> DVec3) -> DVec3 {
    visible_mean_panels(wo, m, s, [panels; 2], g)
}

/// Like [`visible_mean`], but with separate numbers of panels along the view azimuth and across it.
pub fn visible_mean_panels(wo: DVec3, m: DVec2, s: DVec3, panels: [usize; 2], g: impl Fn(DVec2) -> DVec3) -> DVec3 {
    let (a, b) = (meso_area(wo, m), slope_spread(wo, s));
    let top = if b > 0.0 { (a / b).min(EXTENT) } else { EXTENT };
    let factor = view_factor(wo, s);
    let inner: Vec<_> = composite_gauss(-EXTENT_ACROSS, EXTENT_ACROSS, panels[1], ORDER)
        .into_iter()
        .map(|(v, wv)| (v, wv * normal_pdf(v)))
        .collect();
    let mut sum = DVec3::ZERO;
    for (u, wu) in composite_gauss(-EXTENT, top, panels[0], ORDER) {
        let w = wu * normal_pdf(u) * (a - b * u).max(0.0);
        let row: DVec3 =
            inner.iter().map(|&(v, wv)| g(m + factor * DVec2::new(u, v)) * wv).fold(DVec3::ZERO, |a, b| a + b);
        sum += w * row;
    }
    sum / visible_area(wo, m, s).max(MIN_AREA)
}

/// Returns the standard deviations of the slopes along the first and the second axis of [`visible_mean_panels`].
pub fn visible_extents(wo: DVec3, s: DVec3) -> [f64; 2] {
    let factor = view_factor(wo, s);
    [factor.x_axis.length(), factor.y_axis.length()]
}

/// Computes the specular radiance under an environment by LEADR eq. 19 with `F = 1`. `radiance` is a function of the direction in the
/// tangent frame.
pub fn specular_environment(
    wo: DVec3,
    m: DVec2,
    s: DVec3,
    shadowing: bool,
    panels: usize,
    radiance: impl Fn(DVec3) -> DVec3,
) -> DVec3 {
    visible_mean(wo, m, s, panels, |slope| {
        let wn = normal_of_slope(slope);
        let wi = 2.0 * wn.dot(wo) * wn - wo;
        radiance(wi) * shadowing_given_masking(wo, wi, m, s, shadowing)
    })
}

/// Computes LEADR eq. 21 with the exact clamped cosine, for albedo 1 and one light of unit irradiance on a plane facing it. The domain
/// contains only slopes that face the light. `panels` is the number of panels per axis between the cuts of the domain.
pub fn diffuse_directional(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, shadowing: bool, panels: usize) -> f64 {
    let (a, b, ai) = (meso_area(wo, m), slope_spread(wo, s), meso_area(wi, m));
    let top = if b > 0.0 { (a / b).min(EXTENT) } else { EXTENT };
    let factor = view_factor(wo, s);
    let towards = factor.transpose() * wi.xy(); // wi·(−slope, 1) = ai − towards·u
    // The outer integrand has kinks where the border of the lit half-plane crosses the range of the inner integral.
    let mut cuts = vec![-EXTENT, top];
    if towards.x.abs() > 1e-300 {
        cuts.extend(
            [-EXTENT_ACROSS, EXTENT_ACROSS]
                .map(|v| ((ai - towards.y * v) / towards.x).clamp(-EXTENT, top.max(-EXTENT))),
        );
    }
    cuts.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    for pair in cuts.windows(2) {
        for (u, wu) in composite_gauss(pair[0], pair[1], panels, ORDER) {
            let lit = ai - towards.x * u;
            let border = if towards.y.abs() > 1e-300 { lit / towards.y } else { f64::INFINITY.copysign(lit) };
            let (low, high) = if towards.y > 0.0 || towards.y.abs() <= 1e-300 {
                (-EXTENT_ACROSS, border.clamp(-EXTENT_ACROSS, EXTENT_ACROSS))
            } else {
                (border.clamp(-EXTENT_ACROSS, EXTENT_ACROSS), EXTENT_ACROSS)
            };
            for (v, wv) in composite_gauss(low, high, panels, ORDER) {
                let slope = m + factor * DVec2::new(u, v);
                let cosine = (lit - towards.y * v).max(0.0) / (slope.length_squared() + 1.0).sqrt();
                sum += wu * wv * normal_pdf(u) * normal_pdf(v) * (a - b * u).max(0.0) * cosine;
            }
        }
    }
    let mean = sum / visible_area(wo, m, s).max(MIN_AREA);
    mean * shadowing_given_masking(wo, wi, m, s, shadowing) / PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_one_is_one() {
        // The cases are front-facing, grazing and back-facing mesosurfaces with strong anisotropy.
        let s = DVec3::new(0.6, 0.02, 0.08);
        for (wo, m) in [
            (DVec3::Z, DVec2::ZERO),
            (DVec3::new(0.8, -0.59, 0.1).normalize(), DVec2::new(0.5, 0.2)),
            (DVec3::new(0.6, 0.0, 0.8), DVec2::new(2.0, 0.0)),
        ] {
            let mean = visible_mean(wo, m, s, 20, |_| DVec3::ONE);
            assert!((mean.x - 1.0).abs() < 1e-9, "{mean} at {wo}");
        }
    }
}
