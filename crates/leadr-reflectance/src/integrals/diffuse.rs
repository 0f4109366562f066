//! The diffuse reflection of the visible facets (LEADR eq. 20–23, Algorithms 2 and 3), per unit of albedo.
//!
//! The functions sum over an `n`×`n` slope grid of half extent `lambda` and divide by the sum of the visible areas. This division is the
//! masking term (supplement, eq. 10). Section 3.6 of the supplement lacks the factor 1/π. Callers must first pass the mean slope through
//! `face_viewer`.

use super::sh::{Sh9, sh_irradiance_moments};
use crate::facets::projected_area::meso_area;
use crate::frame::Frame;
use crate::masking::grooves::{groove_lit_fraction, groove_visible_area};
use crate::masking::smith::shadowing_given_masking;
use crate::slopes::grid::{facet_area, grid_nodes, normal_of_slope, slope_at, slope_cholesky};
use glam::{DMat3, DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::PI;

/// The first and second moments of the visible normals in the tangent frame. Order-2 irradiance is linear in these moments, so a single
/// pass over the grid serves the environment and all lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMoments {
    /// The mean normal `E[n]`.
    pub mean: DVec3,
    /// The second moments `E[n.x²], E[n.y²], E[n.z²]`.
    pub diag: DVec3,
    /// The mixed moments `E[n.y n.z], E[n.x n.z], E[n.x n.y]`.
    pub off: DVec3,
}

/// Computes the moments of the visible normals on an `n`×`n` grid. All moments are zero if no node is visible.
pub fn visible_normal_moments(wo: DVec3, m: DVec2, s: DVec3, n: u32, lambda: f64) -> NormalMoments {
    moments_of_visible(|facet| facet, wo, m, s, n, lambda)
}

/// Like [`visible_normal_moments`], but for V-grooves ([`crate::masking::grooves`]).
pub fn groove_normal_moments(wo: DVec3, m: DVec2, s: DVec3, n: u32, lambda: f64) -> NormalMoments {
    let meso = meso_area(wo, m);
    moments_of_visible(|facet| groove_visible_area(facet, meso), wo, m, s, n, lambda)
}

/// Sums over the grid. `seen` returns the visible part of the projected area of a facet.
fn moments_of_visible(seen: impl Fn(f64) -> f64, wo: DVec3, m: DVec2, s: DVec3, n: u32, lambda: f64) -> NormalMoments {
    let mut sum = NormalMoments { mean: DVec3::ZERO, diag: DVec3::ZERO, off: DVec3::ZERO };
    let mut norm = 0.0;
    let cholesky = slope_cholesky(s);
    for node in grid_nodes(n, lambda) {
        let slope = slope_at(node.xy(), m, cholesky);
        let wn = normal_of_slope(slope);
        let w = node.z * seen(facet_area(wo, slope));
        sum.mean += w * wn;
        sum.diag += w * wn * wn;
        sum.off += w * wn.yzx() * wn.zxy();
        norm += w;
    }
    let scale = 1.0 / norm.max(1e-12);
    NormalMoments { mean: sum.mean * scale, diag: sum.diag * scale, off: sum.off * scale }
}

/// Returns the radiance under an environment, at least 0, with masking only (as in Algorithm 2). `c` holds the radiance coefficients in the
/// world frame, and `f` is the tangent frame in the world. `rest` is the irradiance beyond order 2 for these normals
/// ([`sh_rest_damping`](super::sh::sh_rest_damping)), or 0.
pub fn leadr_diffuse_environment(v: &NormalMoments, f: &Frame, c: &Sh9, rest: DVec3) -> DVec3 {
    let r = DMat3::from_cols(f.x, f.y, f.z);
    let t = DMat3::from_cols(
        DVec3::new(v.diag.x, v.off.z, v.off.y),
        DVec3::new(v.off.z, v.diag.y, v.off.x),
        DVec3::new(v.off.y, v.off.x, v.diag.z),
    );
    let q = r * t * r.transpose();
    let diag = DVec3::new(q.x_axis.x, q.y_axis.y, q.z_axis.z);
    let off = DVec3::new(q.z_axis.y, q.z_axis.x, q.y_axis.x);
    (sh_irradiance_moments(c, r * v.mean, diag, off) + rest).max(DVec3::ZERO) / PI
}

/// Returns the radiance, at least 0, under one light from `wi` (tangent frame) that has unit irradiance on a plane facing it. The result is
/// the irradiance of the light's order-2 harmonics (Algorithm 2) times the masking and shadowing (eq. 20). According to the paper the error
/// is up to 9 %.
pub fn leadr_diffuse_light_sh(v: &NormalMoments, wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, shadowing: bool) -> f64 {
    let second = (wi * wi).dot(v.diag) + 2.0 * (wi.yzx() * wi.zxy()).dot(v.off);
    let e = 0.09375 * v.diag.element_sum() + 0.5 * wi.dot(v.mean) + 0.46875 * second;
    shadowing_given_masking(wo, wi, m, s, shadowing) * e.max(0.0) / PI
}

/// Like [`leadr_diffuse_light_sh`], but integrates the clamped cosine of the light over the grid instead of the light's harmonics. Use this
/// function for the sun.
pub fn leadr_diffuse_light(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, shadowing: bool, n: u32, lambda: f64) -> f64 {
    let (mut sum, mut norm) = (0.0, 0.0);
    let cholesky = slope_cholesky(s);
    for node in grid_nodes(n, lambda) {
        let slope = slope_at(node.xy(), m, cholesky);
        let w = node.z * facet_area(wo, slope);
        sum += w * wi.dot(normal_of_slope(slope)).max(0.0);
        norm += w;
    }
    shadowing_given_masking(wo, wi, m, s, shadowing) * sum / norm.max(1e-12) / PI
}

/// Like [`leadr_diffuse_light`], but for V-grooves, which shadow each facet by itself ([`crate::masking::grooves`]).
pub fn groove_diffuse_light(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, n: u32, lambda: f64) -> f64 {
    let (mut sum, mut norm) = (0.0, 0.0);
    let cholesky = slope_cholesky(s);
    let (ao, ai) = (meso_area(wo, m), meso_area(wi, m));
    for node in grid_nodes(n, lambda) {
        let slope = slope_at(node.xy(), m, cholesky);
        let facet = facet_area(wo, slope);
        let w = node.z * groove_visible_area(facet, ao);
        let lit = groove_lit_fraction(facet, facet_area(wi, slope), ao, ai);
        sum += w * lit * wi.dot(normal_of_slope(slope)).max(0.0);
        norm += w;
    }
    sum / norm.max(1e-12) / PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{frame_about, from_frame};
    use crate::integrals::sh::{sh_add_light, sh_irradiance};
    use crate::slopes::grid::grid_node;
    use crate::slopes::grid::slope_sample;

    #[test]
    fn moments_replace_the_sum_over_nodes() {
        // Evaluate Algorithm 3 term by term as printed, in a tilted frame.
        let (wo, m, s) = (DVec3::new(0.6, 0.3, 0.74).normalize(), DVec2::new(0.2, -0.3), DVec3::new(0.3, 0.1, 0.05));
        let f = frame_about(DVec3::new(0.3, -0.7, 0.2).normalize());
        let mut c = [DVec3::splat(0.1); 9];
        c[0] = DVec3::new(3.0, 2.0, 1.0);
        sh_add_light(&mut c, DVec3::new(0.0, 0.6, 0.8), DVec3::new(0.5, 0.7, 0.9));
        let (mut sum, mut norm) = (DVec3::ZERO, 0.0);
        for j in 0..5 {
            for k in 0..5 {
                let node = grid_node(j, k, 5, 1.8);
                let slope = slope_sample(node.xy(), m, s);
                let w = node.z * facet_area(wo, slope);
                sum += w * sh_irradiance(&c, from_frame(&f, normal_of_slope(slope)));
                norm += w;
            }
        }
        let v = visible_normal_moments(wo, m, s, 5, 1.8);
        let difference = leadr_diffuse_environment(&v, &f, &c, DVec3::ZERO) - sum / norm / PI;
        assert!(difference.length() < 1e-14, "{difference}");
    }

    #[test]
    fn a_constant_environment_is_returned() {
        let mut c = [DVec3::ZERO; 9];
        c[0] = DVec3::splat((4.0 * PI).sqrt());
        let v = visible_normal_moments(DVec3::new(0.6, 0.0, 0.8), DVec2::ZERO, DVec3::new(1.0, 0.5, 0.2), 5, 1.8);
        let i = leadr_diffuse_environment(&v, &frame_about(DVec3::NEG_Z), &c, DVec3::ZERO);
        assert!((i - DVec3::ONE).length() < 1e-14);
    }

    #[test]
    fn a_flat_surface_is_lambertian() {
        let wi = DVec3::new(0.6, 0.0, 0.8);
        let i = leadr_diffuse_light(DVec3::new(0.0, 0.6, 0.8), wi, DVec2::ZERO, DVec3::ZERO, true, 5, 1.8);
        assert!((i - 0.8 / PI).abs() < 1e-15);
        let back = leadr_diffuse_light(DVec3::Z, -wi, DVec2::ZERO, DVec3::ZERO, false, 5, 1.8);
        assert_eq!(back, 0.0);
    }
}
