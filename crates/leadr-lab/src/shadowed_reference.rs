//! Computes converged integrals over visible slopes under any [`Shadowing`] model, as the reference for quadrature rules and ray casts.

use glam::{DVec2, DVec3};
use leadr_reflectance::integrals::reference::{diffuse_directional, visible_mean};
use leadr_reflectance::integrals::sh::{Sh9, sh_irradiance};
use leadr_reflectance::integrals::specular::environment_sample_at;
use leadr_reflectance::masking::correlated::{DirectionArea, direction_area, lit_fraction};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::slopes::grid::{normal_of_slope, slope_cholesky};
use std::f64::consts::PI;

/// A surface with Gaussian slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The mean slope.
    pub m: DVec2,
    /// The slope covariance, which is positive semidefinite.
    pub s: DVec3,
}

impl Surface {
    /// Computes the area terms of the surface for one direction.
    pub fn area(&self, w: DVec3) -> DirectionArea {
        direction_area(w, self.m, slope_cholesky(self.s))
    }

    /// Evaluates LEADR eq. 21 with albedo 1 for one light, whose irradiance is 1 on a plane that faces the light. The result
    /// is the mean clamped cosine over the visible facets, multiplied by the lit fraction. `panels` has the meaning of
    /// [`diffuse_directional`].
    pub fn diffuse_light(&self, shadowing: Shadowing, wo: DVec3, wi: DVec3, panels: usize) -> f64 {
        diffuse_directional(wo, wi, self.m, self.s, false, panels)
            * lit_fraction(shadowing, &self.area(wo), &self.area(wi))
    }

    /// Evaluates LEADR eq. 21 with albedo 1 under an environment, without shadowing (Algorithm 2). `c` are the coefficients
    /// in the tangent frame.
    pub fn diffuse_environment_masked(&self, wo: DVec3, c: &Sh9, panels: usize) -> DVec3 {
        visible_mean(wo, self.m, self.s, panels, |x| sh_irradiance(c, normal_of_slope(x))) / PI
    }

    /// Evaluates LEADR eq. 19 for ideal specular facets. One pass gives the results for masking only, [`Shadowing::Smith`]
    /// and [`Shadowing::Correlated`].
    pub fn specular_environment(&self, wo: DVec3, panels: usize, radiance: impl Fn(DVec3) -> f64) -> DVec3 {
        let (o, cholesky) = (self.area(wo), slope_cholesky(self.s));
        visible_mean(wo, self.m, self.s, panels, |x| {
            let wi = environment_sample_at(wo, x).wi;
            let i = direction_area(wi, self.m, cholesky);
            let lit = |shadowing| lit_fraction(shadowing, &o, &i);
            radiance(wi) * DVec3::new(1.0, lit(Shadowing::Smith), lit(Shadowing::Correlated))
        })
    }
}
