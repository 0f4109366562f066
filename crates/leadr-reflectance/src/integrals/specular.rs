//! The specular reflection of a LEADR surface (LEADR eq. 16–19, 22).

use crate::facets::beckmann::beckmann_ndf;
use crate::facets::fresnel::fresnel_schlick;
use crate::facets::projected_area::face_viewer;
use crate::masking::correlated::{DirectionArea, direction_area, lit_fraction, masking_shadowing_factor};
use crate::masking::grooves::{groove_lit_fraction, groove_visible_area};
use crate::masking::shadowing::Shadowing;
use crate::masking::smith::masking_shadowing;
use crate::materials::microfacet::half_vector;
use crate::slopes::grid::{facet_area, grid_nodes, normal_of_slope, slope_at, slope_cholesky, slope_sample};
use glam::{DVec2, DVec3, Vec3Swizzles as _};

/// Returns the radiance towards `wo` under one light from `wi`, per unit of the light's irradiance on a plane that faces the light (LEADR
/// eq. 17). `f0` is the linear RGB reflectance at normal incidence.
pub fn leadr_specular_directional(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, f0: DVec3, shadowing: bool) -> DVec3 {
    specular_light(wo, wi, m, s, f0, masking_shadowing(wo, wi, m, s, shadowing))
}

/// Like [`leadr_specular_directional`], but with any [`Shadowing`] model. `o` and `i` are the surface's areas in the two directions
/// ([`crate::masking::correlated::direction_area`]). All lights share `o`, so callers compute it once per pixel.
pub fn leadr_specular_light(
    shadowing: Shadowing,
    o: &DirectionArea,
    i: &DirectionArea,
    wo: DVec3,
    wi: DVec3,
    m: DVec2,
    s: DVec3,
    f0: DVec3,
) -> DVec3 {
    specular_light(wo, wi, m, s, f0, masking_shadowing_factor(shadowing, o, i))
}

/// Returns `F D/4` times the masking-shadowing factor.
fn specular_light(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, f0: DVec3, factor: f64) -> DVec3 {
    let wh = half_vector(wo, wi);
    fresnel_schlick(f0, wi.dot(wh)) * (0.25 * beckmann_ndf(wh, m, s) * factor)
}

/// One node of the sum over an environment.
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentSample {
    /// The unit reflected direction (LEADR eq. 18).
    pub wi: DVec3,
    /// The micronormal of the facet.
    pub wn: DVec3,
    /// The visible area of the facet, `⟨wn, wo⟩ / (wn·wg)`.
    pub area: f64,
}

/// Returns the environment sample of the facet with this slope.
pub fn environment_sample_at(wo: DVec3, slope: DVec2) -> EnvironmentSample {
    let wn = normal_of_slope(slope);
    EnvironmentSample { wi: 2.0 * wn.dot(wo) * wn - wo, wn, area: facet_area(wo, slope) }
}

/// Returns the environment sample of the facet whose slope has the standard normal coordinates `p`.
pub fn environment_sample(wo: DVec3, p: DVec2, m: DVec2, s: DVec3) -> EnvironmentSample {
    environment_sample_at(wo, slope_sample(p, m, s))
}

/// The [`env_lod`] constant `½ log2(6 / 4π)`, which matches the sample's solid angle to the mean solid angle of a cube map texel.
pub const LOD_MATCHED: f64 = -0.5332;
/// The [`env_lod`] constant derived in the supplement (3.5).
pub const LOD_SUPPLEMENT: f64 = -1.48;
/// The [`env_lod`] constant that the supplement recommends against banding with 5×5 nodes.
pub const LOD_SUPPLEMENT_5: f64 = 0.5;
/// The [`env_lod`] constant that the supplement recommends with 32×32 nodes.
pub const LOD_SUPPLEMENT_32: f64 = -0.5;
/// The [`env_lod`] constant implied by `√(α/4π) textureSize` in the supplement's simplified Algorithm 1.
pub const LOD_ALGORITHM_1: f64 = -1.8257;

/// Returns the term of [`env_lod`] that all samples of a pixel share. `size` is the number of texels per edge of the cube map, and
/// `spacing` is the distance between samples in standard deviations. As in the paper, the larger standard deviation is used for both axes.
pub fn env_lod_base(s: DVec3, spacing: f64, size: f64, constant: f64) -> f64 {
    0.5 * (s.x.max(s.y) * spacing * spacing).max(1e-12).log2() + size.log2() + constant
}

/// Returns the level of detail of one sample. The solid angle of the sample is `J (spacing σ)²` with `J = 4 |wn·wo| wn.z³` (LEADR 5.2). The
/// level may be negative, and is finite for `J = 0` and `σ = 0`.
pub fn env_lod_at(base: f64, wo: DVec3, wn: DVec3) -> f64 {
    base + 0.5 * (4.0 * wn.dot(wo).abs() * wn.z.powi(3)).max(1e-12).log2()
}

/// Computes [`env_lod_base`] and [`env_lod_at`] together.
pub fn env_lod(wo: DVec3, wn: DVec3, s: DVec3, spacing: f64, size: f64, constant: f64) -> f64 {
    env_lod_at(env_lod_base(s, spacing, size, constant), wo, wn)
}

/// Sums over the visible specular facets. The sums become means when they are divided by the weight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpecularTerm {
    /// The reflected radiance, including the Fresnel term and shadowing.
    pub reflected: DVec3,
    /// The Fresnel reflectance of the facets.
    pub fresnel: DVec3,
    /// The total weight of the facets.
    pub weight: f64,
}

/// Returns the radiance towards `wo` under an environment, and the mean Fresnel reflectance of the visible facets. The function sums LEADR
/// eq. 22 (Algorithm 1) on an `n`×`n` grid of half extent `lambda`.
///
/// The sum is divided by the visible areas, which is the masking term (supplement, eq. 10). With `f0 = 1` and without shadowing, a constant
/// environment is returned exactly. `radiance` receives each sample direction in the tangent frame.
pub fn leadr_specular_environment(
    shadowing: Shadowing,
    wo: DVec3,
    m: DVec2,
    s: DVec3,
    f0: DVec3,
    n: u32,
    lambda: f64,
    radiance: impl Fn(&EnvironmentSample) -> DVec3,
) -> SpecularTerm {
    let m = face_viewer(wo, m, s, lambda);
    let cholesky = slope_cholesky(s);
    let o = direction_area(wo, m, cholesky);
    let mut sum = SpecularTerm::default();
    for node in grid_nodes(n, lambda) {
        let e = environment_sample_at(wo, slope_at(node.xy(), m, cholesky));
        let i = direction_area(e.wi, m, cholesky);
        let (lit, area) = if shadowing == Shadowing::VGroove {
            (groove_lit_fraction(e.area, e.area, o.meso, i.meso), groove_visible_area(e.area, o.meso))
        } else {
            (lit_fraction(shadowing, &o, &i), e.area)
        };
        let weight = node.z * area;
        let f = weight * fresnel_schlick(f0, wo.dot(e.wn));
        sum.reflected += f * lit * radiance(&e);
        sum.fresnel += f;
        sum.weight += weight;
    }
    let scale = 1.0 / sum.weight.max(1e-12);
    SpecularTerm { reflected: sum.reflected * scale, fresnel: sum.fresnel * scale, weight: 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lod_constants_match_their_names() {
        use std::f64::consts::PI;
        assert!((LOD_MATCHED - 0.5 * (6.0 / (4.0 * PI)).log2()).abs() < 1e-4);
        assert!((LOD_SUPPLEMENT - (2.0 * PI.powf(-1.5)).log2()).abs() < 1e-2);
        assert!((LOD_ALGORITHM_1 - 0.5 * (1.0 / (4.0 * PI)).log2()).abs() < 1e-4);
        // A sample that covers a sixth of the sphere needs the mip level with one texel per face.
        let s = DVec3::new(4.0 * PI / 6.0 / 4.0, 0.0, 0.0);
        assert!((env_lod(DVec3::Z, DVec3::Z, s, 1.0, 256.0, LOD_MATCHED) - 8.0).abs() < 1e-3);
    }

    #[test]
    fn a_constant_environment_is_returned_exactly() {
        for (wo, m) in [
            (DVec3::Z, DVec2::ZERO),
            (DVec3::new(0.99, 0.0, 0.02).normalize(), DVec2::new(2.0, -1.0)),
            (DVec3::new(0.6, 0.0, -0.8), DVec2::ZERO),
        ] {
            for s in [DVec3::ZERO, DVec3::new(0.5, 0.1, 0.2)] {
                for n in [1, 3, 5, 8] {
                    let lambda = crate::slopes::grid::grid_lambda(n);
                    let i =
                        leadr_specular_environment(Shadowing::None, wo, m, s, DVec3::ONE, n, lambda, |_| DVec3::ONE);
                    assert!((i.reflected - DVec3::ONE).length() < 1e-12, "{i:?} at {wo} {m} {s} {n}");
                }
            }
        }
    }
}
