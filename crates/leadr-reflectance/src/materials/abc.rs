//! The microfacet BRDF of Löw, Kronander, Ynnerman and Unger (2012), known as ABC: V-groove facets over a diffuse base.
//!
//! ```text
//! f_r = k_d / π + F D G / (π cos θ_i cos θ_o),   D = A (1 + B (1 − cos θ_h))^(−C)
//! ```
//!
//! `F` is the reflectance of a dielectric and `G` the masking and shadowing of V-grooves. `D` is not normalised.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::brdf::Brdf;
use super::microfacet::half_vector;
use crate::facets::fresnel::fresnel_dielectric;
use crate::facets::parametric_curve::ParametricCurve;

/// The parameters of the BRDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Abc {
    /// The albedo `k_d` of the diffuse base, in linear RGB, at least 0.
    pub diffuse: DVec3,
    /// The scale `A`, in linear RGB, at least 0.
    pub a: DVec3,
    /// The inverse width `B`, above 0.
    pub b: f64,
    /// The exponent `C`.
    pub c: f64,
    /// The refractive index, above 1.
    pub index: f64,
}

impl Abc {
    /// Returns `F D G / (π cos θ_o)` for `A` = 1. The value is 0 unless both directions are above the horizon.
    pub fn specular(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let wh = half_vector(wo, wi);
        let cosine = 0.5 * (wo + wi).length();
        let masking = (2.0 * wh.z * wo.z.min(wi.z) / cosine).min(1.0);
        let density = ParametricCurve::Abc { b: self.b, c: self.c }.ln_density(wh.z.clamp(-1.0, 1.0).acos()).exp();
        FRAC_1_PI * fresnel_dielectric(cosine, self.index) * density * masking / wo.z
    }
}

impl Brdf for Abc {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        let diffuse = if wo.z <= 0.0 { DVec3::ZERO } else { self.diffuse * (FRAC_1_PI * wi.z.max(0.0)) };
        diffuse + self.a * self.specular(wo, wi)
    }
}
