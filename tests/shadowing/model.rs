//! The models under test, converged.
#![allow(dead_code, reason = "each test binary uses its own part")]

use glam::{DVec2, DVec3};
use leadr::reflectance::correlated_masking::{DirectionArea, Visibility, direction_area, lit_fraction};
use leadr::reflectance::quadrature::gauss_legendre;
use leadr::reflectance::reference::{diffuse_directional, visible_mean};
use leadr::reflectance::sh::{Sh9, sh_basis, sh_irradiance};
use leadr::reflectance::shadowed_environment::{bent_normal, shadowed_diffuse_environment};
use leadr::reflectance::slope_grid::{normal_of_slope, slope_cholesky};
use std::f64::consts::{PI, TAU};

/// Gaussian slopes of mean `m` and covariance `s`.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    pub m: DVec2,
    pub s: DVec3,
}

/// Direction at `theta` degrees from z, azimuth `phi` degrees.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    let (sin, cos) = theta.to_radians().sin_cos();
    let (y, x) = phi.to_radians().sin_cos();
    DVec3::new(sin * x, sin * y, cos)
}

/// Coefficients of a radiance of order 2, by a product rule that is exact for it.
pub fn order_two(radiance: impl Fn(DVec3) -> f64) -> Sh9 {
    let mut c = [DVec3::ZERO; 9];
    for (z, w) in gauss_legendre(8) {
        for k in 0..16 {
            let (sin, cos) = (TAU * f64::from(k) / 16.0).sin_cos();
            let r = (1.0 - z * z).sqrt();
            let d = DVec3::new(r * cos, r * sin, z);
            for (c, b) in c.iter_mut().zip(sh_basis(d)) {
                *c += DVec3::splat(w * TAU / 16.0 * b * radiance(d));
            }
        }
    }
    c
}

impl Surface {
    pub fn seen_from(&self, w: DVec3) -> DirectionArea {
        direction_area(w, self.m, slope_cholesky(self.s))
    }

    /// Albedo 1, a light of unit irradiance on a plane facing it: the clamped cosine's exact mean over what is visible, times what is lit.
    pub fn diffuse_light(&self, visibility: Visibility, wo: DVec3, wi: DVec3) -> f64 {
        diffuse_directional(wo, wi, self.m, self.s, false, 8)
            * lit_fraction(visibility, &self.seen_from(wo), &self.seen_from(wi))
    }

    /// The one lookup. The frame is the world.
    pub fn diffuse_environment(&self, wo: DVec3, sh: &Sh9) -> f64 {
        let v = bent_normal(&self.seen_from(wo), self.m, slope_cholesky(self.s));
        shadowed_diffuse_environment(&v, &world(), sh).x
    }

    /// Algorithm 2's, converged: masking alone.
    pub fn diffuse_environment_masked(&self, wo: DVec3, sh: &Sh9) -> f64 {
        visible_mean(wo, self.m, self.s, 10, |x| sh_irradiance(sh, normal_of_slope(x))).x / PI
    }

    /// LEADR eq. 19 of mirrors, converged.
    pub fn specular_environment(&self, visibility: Visibility, wo: DVec3, radiance: impl Fn(DVec3) -> f64) -> f64 {
        let (o, cholesky) = (self.seen_from(wo), slope_cholesky(self.s));
        visible_mean(wo, self.m, self.s, 10, |x| {
            let wn = normal_of_slope(x);
            let wi = 2.0 * wn.dot(wo) * wn - wo;
            DVec3::splat(radiance(wi) * lit_fraction(visibility, &o, &direction_area(wi, self.m, cholesky)))
        })
        .x
    }
}

fn world() -> leadr::reflectance::frame::Frame {
    leadr::reflectance::frame::Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z }
}
