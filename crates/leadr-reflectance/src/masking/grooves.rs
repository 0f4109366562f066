//! Symmetric V-grooves, which hide a part of each facet (Torrance and Sparrow 1967; thesis Table 2.IV).
//!
//! A facet and its mirror image about the mesonormal form a groove with edges on the mesosurface. Let `f` be the projected area of the facet
//! towards a direction, and `a` that of the mesosurface, both per unit of macrosurface ([`crate::facets::projected_area`]). Both sides
//! together have the area `2a`, so a facet shows `min(f, 2a)`. The hidden part is always the bottom of the groove. A facet is therefore
//! visible from one direction and lit from another in the fraction `min(1, 2 a_o / f_o, 2 a_i / f_i)`.
//!
//! For every distribution that is symmetric about the mean slope, the visible areas `min(f, 2a)` have the mean `a`.

use crate::limits::MIN_AREA;

/// The smallest projected area of the mesosurface. Below it, facets would appear at once instead of gradually, which 32 bits cannot resolve.
const LEAST_MESO: f64 = 1e-3;

/// Returns the visible area of a facet, `min(f, 2a)`. A mesosurface that is edge-on or faces away counts as nearly edge-on.
pub fn groove_visible_area(facet: f64, meso: f64) -> f64 {
    facet.max(0.0).min(2.0 * meso.max(LEAST_MESO))
}

/// Returns the fraction of the visible part of a facet that is lit, from 0 to 1. `facet_o` and `facet_i` are the projected areas of the
/// facet towards viewer and light, and `meso_o` and `meso_i` those of the mesosurface.
pub fn groove_lit_fraction(facet_o: f64, facet_i: f64, meso_o: f64, meso_i: f64) -> f64 {
    let seen = groove_visible_area(facet_o, meso_o);
    let lit = 2.0 * meso_i.max(0.0) * facet_o.max(0.0);
    (lit / (facet_i.max(0.0) * seen).max(1e-30)).min(1.0)
}

/// Returns `G / a_o = min(f, 2 a_o, 2 a_i) / (f a_o)` of the facet that reflects the light, which is the factor of `F D / 4` in
/// `f_r cos θ_i`. At `a_o = 0` it is the limit, `2/f`. `ao` and `ai` are at least 0.
pub fn groove_factor(facet: f64, ao: f64, ai: f64) -> f64 {
    ai / (ai * ao.max(0.5 * facet).max(MIN_AREA)).max(0.5 * facet * ao).max(1e-30)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::projected_area::meso_area;
    use crate::integrals::diffuse::{groove_diffuse_light, groove_normal_moments};
    use crate::integrals::specular::leadr_specular_environment;
    use crate::masking::shadowing::Shadowing;
    use crate::slopes::grid::{facet_area, grid_nodes, slope_at, slope_cholesky};
    use glam::{DVec2, DVec3, Vec3Swizzles as _};
    use std::f64::consts::PI;

    const M: DVec2 = DVec2::new(0.3, -0.2);
    const S: DVec3 = DVec3::new(0.3, 0.2, 0.05);

    #[test]
    fn visible_areas_add_up_to_the_mesosurface() {
        for wo in [DVec3::Z, DVec3::new(0.8, 0.1, 0.6), DVec3::new(-0.9, 0.3, 0.2)].map(DVec3::normalize) {
            let (mut sum, mut all) = (0.0, 0.0);
            let meso = meso_area(wo, M);
            for node in grid_nodes(128, 4.6) {
                sum += node.z * groove_visible_area(facet_area(wo, slope_at(node.xy(), M, slope_cholesky(S))), meso);
                all += node.z;
            }
            assert!((sum / all - meso).abs() < 1e-3 * meso, "{} instead of {meso}", sum / all);
        }
    }

    /// Weights on visible areas and lit fractions are the factor of the microfacet equation times the area of the facet.
    #[test]
    fn fractions_are_the_factor_for_the_reflecting_facet() {
        for (facet, ao, ai) in [(0.7, 0.2, 0.9), (0.7, 0.9, 0.2), (0.3, 0.2, 0.25), (1.4, 0.4, 0.4), (0.5, 0.01, 0.8)] {
            let parts = groove_visible_area(facet, ao) * groove_lit_fraction(facet, facet, ao, ai) / ao;
            assert!((parts - facet * groove_factor(facet, ao, ai)).abs() < 1e-12, "{parts} at {facet} {ao} {ai}");
        }
    }

    /// Ideal facets under a constant environment reflect the mean of the light's factor over half vectors.
    #[test]
    fn environments_are_integrals_of_lights() {
        let wo = DVec3::new(0.7, -0.2, 0.5).normalize();
        let (n, lambda) = (128, 4.6);
        let found = leadr_specular_environment(Shadowing::VGroove, wo, M, S, DVec3::ONE, n, lambda, |_| DVec3::ONE);
        let (mut sum, mut all) = (0.0, 0.0);
        for node in grid_nodes(n, lambda) {
            let slope = slope_at(node.xy(), M, slope_cholesky(S));
            let facet = facet_area(wo, slope);
            let wn = crate::slopes::grid::normal_of_slope(slope);
            let wi = 2.0 * wn.dot(wo) * wn - wo;
            if facet > 0.0 {
                let (ao, ai) = (meso_area(wo, M), meso_area(wi, M).max(0.0));
                sum += node.z * facet * groove_factor(facet, ao, ai);
            }
            all += node.z;
        }
        let want = sum / all;
        assert!((found.reflected.x - want).abs() < 2e-3 && want < 0.99, "{} instead of {want}", found.reflected.x);
    }

    #[test]
    fn diffuse_grooves_lose_only_shadowed_light() {
        let wo = DVec3::new(0.6, 0.3, 0.7).normalize();
        // Light from the viewer: all that is visible is lit, and the sum is that of the visible normals.
        let v = groove_normal_moments(wo, M, S, 32, 3.0);
        let lit = groove_diffuse_light(wo, wo, M, S, 32, 3.0);
        assert!((lit - v.mean.dot(wo) / PI).abs() < 1e-12, "{lit}");
        // Light from the other side is partly hidden.
        let wi = DVec3::new(-0.9, -0.3, 0.4).normalize();
        let open = v.mean.dot(wi) / PI;
        let shadowed = groove_diffuse_light(wo, wi, M, S, 32, 3.0);
        assert!(shadowed > 0.0 && shadowed < open.max(0.3), "{shadowed} {open}");
        // A smooth surface is Lambertian.
        let flat = groove_diffuse_light(wo, wi, DVec2::ZERO, DVec3::ZERO, 5, 1.8);
        assert!((flat - wi.z / PI).abs() < 1e-12, "{flat}");
    }
}
