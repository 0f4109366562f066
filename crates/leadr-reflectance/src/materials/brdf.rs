//! The renderer's interface to a material (thesis 1.4). It provides evaluation, sampling, and the sampling density.

use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_4};

/// A light direction drawn by [`Brdf::sample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrdfSample {
    /// The unit direction towards the light.
    pub wi: DVec3,
    /// The positive density of `wi` per steradian, as [`Brdf::pdf`] returns it.
    pub pdf: f64,
    /// The factor `f_r cos θ_i / pdf` for the radiance from `wi`, in linear RGB. The factor is finite even where `pdf` is large.
    pub throughput: DVec3,
}

/// A bidirectional reflectance distribution function. Directions are unit vectors in the tangent frame, with z up.
pub trait Brdf {
    /// Returns `f_r(wi, wo) cos θ_i`, in linear RGB per steradian. This is the radiance towards `wo` under a light from `wi`, per unit of
    /// irradiance on a plane that faces the light. The value is 0 if no light is reflected, and finite for every pair of directions.
    ///
    /// Tilted facets of a rough surface can be visible and lit from below the macrosurface's horizon. The value is then positive while
    /// [`Brdf::eval`] is 0.
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3;

    /// Returns `f_r(wi, wo)` per steradian, which is [`Brdf::eval_cos`] divided by `wi.z`, or 0 for a light on or below the horizon.
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if wi.z <= 0.0 { DVec3::ZERO } else { self.eval_cos(wo, wi) / wi.z.max(1e-30) }
    }

    /// Returns the density per steradian with which [`Brdf::sample`] draws `wi` for `wo`. The default is the cosine divided by π.
    ///
    /// The density integrates to at most one. The remainder is the probability that there is no sample.
    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z <= 0.0 { 0.0 } else { wi.z.max(0.0) * FRAC_1_PI }
    }

    /// Returns a light direction for `u` in `[0, 1)²`, importance sampled by [`Brdf::eval_cos`]. `None` means that no facet is visible from
    /// `wo`. It counts as a sample of weight 0.
    fn sample(&self, wo: DVec3, u: DVec2) -> Option<BrdfSample> {
        let wi = cosine_sample(u);
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| BrdfSample { wi, pdf, throughput: self.eval_cos(wo, wi) / pdf })
    }
}

/// Returns a direction of density `cos θ / π` for `u` in `[0, 1)²` (concentric map of Shirley and Chiu, lifted to the hemisphere).
pub fn cosine_sample(u: DVec2) -> DVec3 {
    let p = 2.0 * u - DVec2::ONE;
    let (r, phi) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * p.y / p.x)
    } else if p.y != 0.0 {
        (p.y, FRAC_PI_4 * (2.0 - p.x / p.y))
    } else {
        (0.0, 0.0)
    };
    let (sin, cos) = phi.sin_cos();
    DVec3::new(r * cos, r * sin, ((1.0 - r) * (1.0 + r)).max(0.0).sqrt())
}
