//! Shades a displaced GGX surface ([`DisplacedGgx`]) under lights and environments.
//!
//! For lights, the two lobes are evaluated exactly. For environments, the GGX lobe is a mixture of Gaussian surfaces: if `e` is
//! exponentially distributed, Gaussian slopes of covariance `A / 2e` have the GGX distribution. The slope grid and the probe rules then
//! apply to each Gaussian. Each Gaussian contributes in proportion to its visible area, so a constant environment is still returned
//! unchanged. Three values of `e` and their weights are chosen to minimise `∫ |P − P̂|` of the slope density. The remaining error is 0.044
//! out of at most 2.

use super::ggx_filtering::{DisplacedGgx, displaced_ggx_ndf, displaced_ggx_visible_area};
use crate::facets::fresnel::fresnel_schlick;
use crate::facets::projected_area::meso_area;
use crate::masking::correlated::{DirectionArea, masking_shadowing_factor, whitened_direction};
use crate::masking::shadowing::Shadowing;
use crate::materials::microfacet::half_vector;
use glam::{DVec2, DVec3};

/// One Gaussian surface of the mixture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianLobe {
    /// The fraction of the slopes in this surface. The weights of all surfaces sum to one.
    pub weight: f64,
    /// The slope covariance `(xx, yy, xy)`.
    pub s: DVec3,
}

/// The number of Gaussian surfaces that [`ggx_lobe`] returns.
pub const GGX_LOBES: usize = 4;

/// The pairs `(weight, e)` of the Gaussian surfaces that approximate GGX.
const MIXTURE: [(f64, f64); 3] = [(0.3424, 2.069), (0.4764, 0.5126), (0.1812, 0.0825)];

/// Returns the Beckmann lobe of `d` (`k = 0`), or one of the Gaussian surfaces that approximate its GGX lobe (`k > 0`).
///
/// # Panics
/// If `k` is not below [`GGX_LOBES`].
pub fn ggx_lobe(d: &DisplacedGgx, k: usize) -> GaussianLobe {
    if k == 0 {
        return GaussianLobe { weight: 1.0 - d.weight, s: 0.5 * d.roughness };
    }
    let (share, e) = MIXTURE[k - 1];
    GaussianLobe { weight: d.weight * share, s: d.roughness * (0.5 / e) }
}

/// Returns the projected areas of the surface along `w`. `cholesky` is the Cholesky factor of `roughness / 2`.
pub fn displaced_ggx_area(w: DVec3, m: DVec2, d: &DisplacedGgx, cholesky: DVec3) -> DirectionArea {
    let whitened = whitened_direction(w, cholesky);
    let visible = displaced_ggx_visible_area(w, m, d);
    DirectionArea { whitened, spread: whitened.length(), meso: meso_area(w, m), visible }
}

/// Returns the radiance towards `wo` under one light from `wi`, per unit of the light's irradiance on a plane that faces the light. `o` is
/// the [`displaced_ggx_area`] of `wo`.
pub fn displaced_ggx_light(
    shadowing: Shadowing,
    o: &DirectionArea,
    wo: DVec3,
    wi: DVec3,
    m: DVec2,
    d: &DisplacedGgx,
    cholesky: DVec3,
    f0: DVec3,
) -> DVec3 {
    let wh = half_vector(wo, wi);
    let lit = masking_shadowing_factor(shadowing, o, &displaced_ggx_area(wi, m, d, cholesky));
    fresnel_schlick(f0, wi.dot(wh)) * (0.25 * displaced_ggx_ndf(wh, m, d) * lit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::beckmann::beckmann_p22;
    use crate::integrals::ggx_filtering::{displaced_ggx, displaced_ggx_p22};
    use crate::quadrature::composite_gauss;
    use std::f64::consts::PI;

    fn isotropic(v: f64) -> DVec3 {
        DVec3::new(v, v, 0.0)
    }

    #[test]
    fn the_mixture_is_near_the_two_lobes() {
        for (alpha, sigma, bound) in [(0.3f64, 0.0f64, 0.046), (0.3, 0.2, 0.026), (0.1, 0.3, 0.004)] {
            let d = displaced_ggx(isotropic(alpha * alpha), isotropic(sigma * sigma));
            let lobes: Vec<GaussianLobe> = (0..GGX_LOBES).map(|k| ggx_lobe(&d, k)).collect();
            let total: f64 = lobes.iter().map(|l| l.weight).sum();
            assert!((total - 1.0).abs() < 1e-12);
            // Integrate over v = u / (1 + u), where u is r² divided by the roughness.
            let error: f64 = composite_gauss(0.0, 1.0 - 1e-9, 50, 8)
                .into_iter()
                .map(|(v, w)| {
                    let u = d.roughness.x * v / (1.0 - v);
                    let slope = DVec2::new(u.sqrt(), 0.0);
                    let sum: f64 = lobes.iter().map(|l| l.weight * beckmann_p22(slope, DVec2::ZERO, l.s)).sum();
                    let jacobian = PI * d.roughness.x / (1.0 - v).powi(2);
                    w * jacobian * (sum - displaced_ggx_p22(slope, DVec2::ZERO, &d)).abs()
                })
                .sum();
            println!("base {alpha}, bumps {sigma}: {error:.4}");
            assert!(error < bound && (sigma > 0.0 || error > 0.02), "{error}");
        }
    }
}
