//! The roughness of the base material on steep facets.
//!
//! The base material, of Beckmann roughness `α`, covers the *facets* of the relief. Its normals spread about every facet's normal in the
//! same way. The paper adds `α²/2` to the slope variances, as if the base lay on the macrosurface
//! ([`add_roughness`](crate::slopes::statistics::add_roughness)).
//!
//! **First-order transform (rms error 0.19).** To first order, a facet of slope `m` changes the base's slope variance `α²/2` to
//! `(1 + |m|²)(I + m mᵀ) α²/2`. The mean over a Gaussian relief has a closed form. With `A = S + μ μᵀ` the mean is
//! `(1 + tr A) I + A + tr(A) A + 2 A² − 2 |μ|² μ μᵀ`. This *variance* is correct, but most of it is in a long tail of steep microfacets
//! that reflect the ground or are hidden. A Gaussian of this variance is less accurate than the paper's form (rms 0.16).
//!
//! **Fitted form (rms error 0.04).** At normal incidence the true distribution is *narrower* than the paper's form, because the long tail
//! takes weight away from the flanks. At grazing angles the true distribution is wider, because each facet hides its own far side. The fit
//! is a closed form in values that a shader computes anyway. The reference casts rays, with shadowing, at Gaussian facets that have a
//! Beckmann base (`crates/leadr-reflectance/tests/reflectance/base_roughness.rs`). The fitted form depends on the view direction but not on
//! the light, so the specular term is not reciprocal. With the paper's form it is reciprocal.

use super::projected_area::{meso_area, slope_spread};
use glam::{DVec2, DVec3};

/// Returns the covariance of the specular microfacets visible from `wo` (unit, tangent frame) on a relief of mean slope `m` and covariance
/// `s = (xx, yy, xy)`. Each facet has a base of Beckmann roughness `alpha` (0 to 1) in its own frame.
///
/// The sum has three terms:
/// * The relief term is `s` divided by one plus `6 · α²/2 · cos²θ · v²/(v² + 0.05)`, where `v` is the mean of the variances in `s`.
/// * The base term is `α²/2` times `1 + 1.5 g²/(g + 1)`, where `g` is the slope deviation along `wo` divided by the projected area.
/// * The tilt term is the contribution of a facet with the mean slope (up to 2). It matters where the relief has nearly one slope.
///
/// All terms are continuous and positive definite for any argument. At `α = 0` the result is `s`, and without relief or tilt it is
/// `s + α²/2`.
pub fn add_facet_roughness(s: DVec3, alpha: f64, wo: DVec3, m: DVec2) -> DVec3 {
    let variance = 0.5 * alpha * alpha;
    let relief = 0.5 * (s.x + s.y);
    let facing = wo.z.max(0.0);
    let narrowed = 6.0 * variance * facing * facing * relief * relief / (relief * relief + 0.05);
    let grazing = slope_spread(wo, s) / wo.z.max(meso_area(wo, m)).max(0.1);
    let widened = 1.0 + 1.5 * grazing * grazing / (grazing + 1.0);
    let tilt = m * (2.0 / m.length_squared().max(1e-12).sqrt()).min(1.0);
    let square = tilt.length_squared();
    let flat = DVec3::new(1.0, 1.0, 0.0);
    let tilted = flat * square + (1.0 + square) * (tilt * tilt).extend(tilt.x * tilt.y);
    s / (1.0 + narrowed) + variance * (flat * widened + tilted * (0.02 / (relief + 0.02)))
}
