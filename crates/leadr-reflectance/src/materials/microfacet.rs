//! The microfacet BRDF with any slope distribution, masking and Fresnel term (thesis eq. 2.1, sampled by 2.17 and 2.23).

use super::brdf::{Brdf, BrdfSample};
use crate::facets::beckmann::beckmann_ndf;
use crate::facets::fresnel::Fresnel;
use crate::facets::ggx::{ggx_ndf, ggx_visible_area};
use crate::facets::projected_area::visible_area;
use crate::facets::slope_distribution::SlopeDistribution;
use crate::limits::MIN_AREA;
use crate::masking::variants::{Masking, attenuation, half_facet_area, masking_factor};
use crate::slopes::grid::{facet_area, normal_of_slope};
use glam::{DVec2, DVec3, Vec3Swizzles as _};

/// The BRDF for which `f_r cos θ_i = F D (G / a_o) / 4`. The default masking and Fresnel term give LEADR eq. 16 for ideal specular facets.
#[derive(Clone, Debug, PartialEq)]
pub struct Microfacet<D> {
    /// The slope density of the facets.
    pub distribution: D,
    /// The masking-shadowing model.
    pub masking: Masking,
    /// The Fresnel term of a facet.
    pub fresnel: Fresnel,
}

/// Returns the half vector of two unit directions, or zero for opposite directions.
pub fn half_vector(wo: DVec3, wi: DVec3) -> DVec3 {
    let h = wo + wi;
    h / h.length_squared().max(1e-20).sqrt()
}

/// Returns `D (G / a_o) / 4`. The result is finite, because the normal density of a smooth surface is clamped to 1e30.
pub fn microfacet_product(d: f64, factor: f64) -> f64 {
    0.25 * d.min(1e30) * factor
}

/// Returns `D (G / a_o) / 4`, which is `f_r cos θ_i` for ideal specular facets. The value is 0 unless the half vector is above the horizon.
pub fn microfacet_eval(masking: Masking, distribution: &impl SlopeDistribution, wo: DVec3, wi: DVec3) -> f64 {
    let (m, shape) = (distribution.mean_slope(), distribution.shape());
    specular(masking, wo, wi, m, shape, |wh| distribution.ndf(wh), |w| distribution.visible_area(w))
}

/// Computes [`microfacet_eval`] for Gaussian slopes of mean `m` and covariance `s`, as in the GLSL library.
pub fn microfacet_eval_beckmann(masking: Masking, wo: DVec3, wi: DVec3, m: DVec2, s: DVec3) -> f64 {
    specular(masking, wo, wi, m, s, |wh| beckmann_ndf(wh, m, s), |w| visible_area(w, m, s))
}

/// Computes [`microfacet_eval`] for GGX slopes of mean `m` and roughness matrix `a` (`α²` terms), as in the GLSL library.
pub fn microfacet_eval_ggx(masking: Masking, wo: DVec3, wi: DVec3, m: DVec2, a: DVec3) -> f64 {
    specular(masking, wo, wi, m, a, |wh| ggx_ndf(wh, m, a), |w| ggx_visible_area(w, m, a))
}

fn specular(
    masking: Masking,
    wo: DVec3,
    wi: DVec3,
    m: DVec2,
    shape: DVec3,
    ndf: impl Fn(DVec3) -> f64,
    area: impl Fn(DVec3) -> f64,
) -> f64 {
    let wh = half_vector(wo, wi);
    if wh.z <= 0.0 {
        return 0.0;
    }
    microfacet_product(ndf(wh), masking_factor(masking, wo, wi, wh, m, area(wo), area(wi), shape))
}

/// Returns the factor `q` in the density `D q / 4` with which a facet of projected area `facet` samples directions `wi`. The factor depends
/// on the visible part of the facet, that is on masking without shadowing.
///
/// * Smith: `1 / A_o`, which gives the density of visible normals (thesis eq. 2.17). The throughput is `G / G₁ F` (eq. 2.23).
/// * Normal map: `1 / f`, because facets are weighted by macrosurface area. The throughput is `F`.
/// * V-groove: `1 / f`, or `2 / f` where `f > 2 a_o`, because grooves are weighted by macrosurface area. If only one side of a groove is
///   visible, that side is used. The throughput is at most `2 F`.
fn sampling_factor(masking: Masking, distribution: &impl SlopeDistribution, wo: DVec3, facet: f64) -> f64 {
    let facet = facet.max(MIN_AREA);
    match masking.unshadowed() {
        Masking::NormalMap => 1.0 / facet,
        Masking::VGrooveUnshadowed if facet > 2.0 * distribution.meso_area(wo) => 2.0 / facet,
        Masking::VGrooveUnshadowed => 1.0 / facet,
        // Unlike the evaluation, this code does not clamp the area to MIN_AREA. Samples therefore follow the true density wherever a facet
        // is visible.
        _ => 1.0 / distribution.visible_area(wo).max(1e-30),
    }
}

/// Returns a visible normal with the density of [`sampling_factor`]. The normal may be back-facing or otherwise unusable.
fn sample_normal(masking: Masking, distribution: &impl SlopeDistribution, wo: DVec3, u: DVec2) -> DVec3 {
    match masking.unshadowed() {
        // A viewer at normal incidence weights facets by their macrosurface area, D(wn) wn.z.
        Masking::NormalMap => distribution.sample_visible(DVec3::Z, u),
        Masking::VGrooveUnshadowed => {
            let wn = distribution.sample_visible(DVec3::Z, u);
            let slope = -wn.xy() / wn.z.max(1e-12);
            // The areas of the two sides of a groove sum to 2 a_o. If one side is back-facing, only the other side is visible.
            if facet_area(wo, slope) > 0.0 { wn } else { normal_of_slope(2.0 * distribution.mean_slope() - slope) }
        }
        _ => distribution.sample_visible(wo, u),
    }
}

/// The V-groove forms require a distribution that is symmetric about its mean slope, as the distributions of this library are.
impl<D: SlopeDistribution> Brdf for Microfacet<D> {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let wh = half_vector(wo, wi);
        self.fresnel.at(wo.dot(wh)) * microfacet_eval(self.masking, &self.distribution, wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let wh = half_vector(wo, wi);
        if wh.z <= 0.0 {
            return 0.0;
        }
        0.25 * self.distribution.ndf(wh)
            * sampling_factor(self.masking, &self.distribution, wo, half_facet_area(wo, wi, wh))
    }

    fn sample(&self, wo: DVec3, u: DVec2) -> Option<BrdfSample> {
        let wn = sample_normal(self.masking, &self.distribution, wo, u);
        let cosine = wo.dot(wn);
        if wn.z <= 0.0 || cosine <= 0.0 {
            return None;
        }
        let wi = (2.0 * cosine * wn - wo).normalize();
        let q = sampling_factor(self.masking, &self.distribution, wo, cosine / wn.z.max(1e-12));
        let pdf = 0.25 * self.distribution.ndf(wn) * q;
        // This form avoids a quotient of densities, so the throughput is finite even for the smoothest surface.
        let throughput = self.fresnel.at(cosine) * (attenuation(self.masking, &self.distribution, wo, wi, wn) / q);
        (pdf > 0.0).then_some(BrdfSample { wi, pdf, throughput })
    }
}
