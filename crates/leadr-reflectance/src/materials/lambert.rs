//! The ideal diffuse reflector (thesis eq. 1.9).

use super::brdf::Brdf;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// The BRDF `f_r = albedo / π`, which is 0 unless both directions are above the horizon. Cosine sampling is exact for this BRDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// The albedo in linear RGB, from 0 to 1.
    pub albedo: DVec3,
}

impl Brdf for Lambert {
    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if wo.z <= 0.0 || wi.z <= 0.0 { DVec3::ZERO } else { self.albedo * (FRAC_1_PI * wi.z) }
    }
}
