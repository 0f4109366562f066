//! Smith masking and shadowing of a noncentral Gaussian surface (LEADR eq. 13–15), without the poles of `Λ`.
//!
//! In projected areas, the paper's `(wm·wg / wm·wo) / (1 + Λo + Λi)` is `a_i / (a_i A_o + a_o (A_i − a_i))`. This form is symmetric and
//! shear-invariant. The value is finite for a mesosurface that faces away from the viewer, and 0 for a mesosurface that faces away from the
//! light. The thesis' noncentral form (eq. 2.13 with 3.3) is not shear-invariant and differs by up to a factor of 19.

use crate::facets::projected_area::{meso_area, rough_area, slope_spread, visible_area};
use crate::limits::{MIN_AREA, at_least};
use glam::{DVec2, DVec3};

/// Returns the exact `Λ(w)` of LEADR 4.3, without the printed fit. `Λ` is large but finite where the paper has `+∞` (`a ≤ 0`).
pub fn smith_lambda(w: DVec3, m: DVec2, s: DVec3) -> f64 {
    let a = meso_area(w, m);
    rough_area(a, slope_spread(w, s)) / a.max(MIN_AREA)
}

/// Returns the rational fit of `Λ` that LEADR 4.3 and its supplement (3.2) print, from Walter et al. 2007. `nu` is `a / (√2 b)`, with the
/// projected area `a` of the mesosurface and the deviation `b` of the slopes along the direction. `1 / (1 + Λ)` errs by at most .0035.
pub fn smith_lambda_fit(nu: f64) -> f64 {
    if nu < 1.6 { (1.0 - 1.259 * nu + 0.396 * nu * nu) / (3.535 * nu + 2.181 * nu * nu) } else { 0.0 }
}

/// Returns `1 / A(wo) = (wm·wg / wm·wo) / (1 + Λo)`, which is masking alone times the projected area of eq. 16.
pub fn masking(wo: DVec3, m: DVec2, s: DVec3) -> f64 {
    1.0 / at_least(visible_area(wo, m, s), MIN_AREA)
}

/// Returns `1 / (a_o (1 + Λo + Λi))`, which is height-correlated masking and shadowing times the projected area of eq. 16. A light below
/// the mesosurface gives 0. Without `shadowing`, the result equals [`masking`].
pub fn masking_shadowing(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, shadowing: bool) -> f64 {
    if !shadowing {
        return masking(wo, m, s);
    }
    let ao = meso_area(wo, m).max(0.0);
    let ai = meso_area(wi, m).max(0.0);
    let visible = at_least(visible_area(wo, m, s), MIN_AREA);
    ai / at_least(ai * visible + ao * rough_area(ai, slope_spread(wi, s)), 1e-30)
}

/// Computes [`shadowing_given_masking`] from view-dependent terms, which the caller computes once outside a loop: `ao = meso_area(wo, m)`
/// and `area_o = visible_area(wo, m, s)`.
pub fn shadowing_from_areas(ao: f64, area_o: f64, wi: DVec3, m: DVec2, s: DVec3) -> f64 {
    let ai = meso_area(wi, m).max(0.0);
    let lit = ai * at_least(area_o, MIN_AREA);
    lit / at_least(lit + ao.max(0.0) * rough_area(ai, slope_spread(wi, s)), 1e-30)
}

/// Returns `(1 + Λo) / (1 + Λo + Λi)`, the fraction of the visible facets that is lit, from 0 to 1. The fraction weights a sample (eq. 22)
/// or a light (eq. 20) in a sum that is already normalised for masking. The fraction is 1 without `shadowing`.
pub fn shadowing_given_masking(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, shadowing: bool) -> f64 {
    if shadowing { shadowing_from_areas(meso_area(wo, m), visible_area(wo, m, s), wi, m, s) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(theta: f64, phi: f64) -> DVec3 {
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    #[test]
    fn the_printed_fit_is_close() {
        let (m, s) = (DVec2::ZERO, DVec3::new(0.25, 0.25, 0.0));
        let mut worst = 0.0f64;
        for i in 1..900 {
            let w = direction(f64::from(i) * 0.1f64.to_radians(), 0.3);
            let nu = meso_area(w, m) / (2f64.sqrt() * slope_spread(w, s));
            worst = worst.max((1.0 / (1.0 + smith_lambda_fit(nu)) - 1.0 / (1.0 + smith_lambda(w, m, s))).abs());
        }
        println!("{worst}");
        assert!((0.002..0.0035).contains(&worst), "{worst}");
    }

    #[test]
    fn equals_the_papers_form_where_that_is_defined() {
        let (m, s) = (DVec2::new(0.3, -0.2), DVec3::new(0.3, 0.2, 0.1));
        for (to, ti) in [(0.1, 0.4), (0.9, 1.1), (1.2, 0.2)] {
            let (wo, wi) = (direction(to, 0.7), direction(ti, 3.0));
            let (ao, lo, li) = (meso_area(wo, m), smith_lambda(wo, m, s), smith_lambda(wi, m, s));
            assert!(ao > 0.0 && meso_area(wi, m) > 0.0);
            let paper = 1.0 / (ao * (1.0 + lo + li));
            assert!((masking_shadowing(wo, wi, m, s, true) / paper - 1.0).abs() < 1e-12);
            assert!((masking(wo, m, s) * ao * (1.0 + lo) - 1.0).abs() < 1e-12);
            let ratio = (1.0 + lo) / (1.0 + lo + li);
            assert!((shadowing_given_masking(wo, wi, m, s, true) / ratio - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn reciprocal_after_the_projected_area() {
        let (m, s) = (DVec2::new(-0.1, 0.25), DVec3::new(0.5, 0.1, -0.15));
        let (wo, wi) = (direction(1.1, 0.4), direction(0.6, 2.0));
        let there = masking_shadowing(wo, wi, m, s, true) * meso_area(wo, m);
        let back = masking_shadowing(wi, wo, m, s, true) * meso_area(wi, m);
        assert!((there / back - 1.0).abs() < 1e-12);
    }

    #[test]
    fn dark_below_the_mesosurface_and_continuous_there() {
        let (m, s) = (DVec2::new(0.0, 0.0), DVec3::new(0.2, 0.2, 0.0));
        let wo = direction(0.5, 0.0);
        assert_eq!(masking_shadowing(wo, direction(1.6, 1.0), m, s, true), 0.0);
        assert!(masking_shadowing(wo, direction(std::f64::consts::FRAC_PI_2 - 1e-4, 1.0), m, s, true) < 1e-3);
    }
}
