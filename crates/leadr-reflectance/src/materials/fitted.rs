//! A material that consists of facets over a diffuse base.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::brdf::{Brdf, BrdfSample, cosine_sample};
use super::microfacet::Microfacet;
use crate::facets::slope_distribution::SlopeDistribution;
use crate::facets::tabulated::Tabulated;

/// A material with the BRDF `f_r = F D G / (4 cos θ_i cos θ_o) + diffuse / π`. The facets of a fit are tabulated.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedBrdf<D = Tabulated> {
    /// The specular facets.
    pub facets: Microfacet<D>,
    /// The albedo of the diffuse base, in linear RGB.
    pub diffuse: DVec3,
}

impl<D> FittedBrdf<D> {
    /// Returns the probability of sampling the diffuse term, which is its fraction of the reflectance at normal incidence.
    fn diffuse_share(&self) -> f64 {
        let [diffuse, specular] = [self.diffuse, self.facets.fresnel.at(1.0)].map(|c| c.element_sum());
        if diffuse <= 0.0 { 0.0 } else { (diffuse / (diffuse + specular)).clamp(0.1, 1.0) }
    }
}

impl<D: SlopeDistribution> Brdf for FittedBrdf<D> {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let diffuse = if wo.z <= 0.0 { DVec3::ZERO } else { self.diffuse * (FRAC_1_PI * wi.z.max(0.0)) };
        diffuse + self.facets.eval_cos(wo, wi)
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        let share = self.diffuse_share();
        share * FRAC_1_PI * wi.z.max(0.0) + (1.0 - share) * self.facets.pdf(wo, wi)
    }

    fn sample(&self, wo: DVec3, u: DVec2) -> Option<BrdfSample> {
        let share = self.diffuse_share();
        let wi = if u.x < share {
            cosine_sample(DVec2::new(u.x / share, u.y))
        } else {
            self.facets.sample(wo, DVec2::new(((u.x - share) / (1.0 - share)).min(1.0 - 1e-16), u.y))?.wi
        };
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| BrdfSample { wi, pdf, throughput: self.eval_cos(wo, wi) / pdf })
    }
}
