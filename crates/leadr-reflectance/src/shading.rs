//! Recommended shading: one function for a light and one for an environment, each with diffuse and specular reflection.
//!
//! Both functions use the masking and shadowing of [`Shadowing::Correlated`] and the two-term diffuse closed form of [`visible::diffuse`].
//! The specular environment uses 16 probes ([`visible::shadowed_specular`]), and the diffuse environment uses a bent normal
//! ([`visible::shadowed_environment`]). The renderer does the same by default. For other methods, call the functions of these modules
//! directly. `leadr/shading.glsl` has the function for a light. In shaders, an environment needs texture lookups between the calls, as
//! `leadr/visible/shadowed_specular.glsl` explains.
//!
//! ```
//! use leadr_reflectance::prelude::*;
//!
//! // Bronze under a low sun: rougher along x than along y, and slightly tilted.
//! let surface = Surface {
//!     mean_slope: DVec2::new(0.1, 0.0),
//!     slope_covariance: DVec3::new(0.2, 0.02, 0.0),
//!     roughness: 0.15,
//!     albedo: DVec3::ZERO,
//!     f0: DVec3::new(0.72, 0.43, 0.2),
//! };
//! let viewer = DVec3::new(0.0, -0.6, 0.8);
//! let towards_the_sun = DVec3::new(0.8, 0.0, 0.6);
//! let irradiance = DVec3::new(20.0, 18.0, 15.0);
//! let radiance = irradiance * shading::light(&surface, viewer, towards_the_sun);
//! assert!(radiance.x > radiance.z && radiance.z > 0.0);
//! ```
//!
//! [`visible::diffuse`]: super::visible::diffuse
//! [`visible::shadowed_specular`]: super::visible::shadowed_specular
//! [`visible::shadowed_environment`]: super::visible::shadowed_environment

use super::facets::base_roughness::add_facet_roughness;
use super::frame::{Frame, from_frame};
use super::integrals::facet_specular::{facet_specular, facet_specular_light};
use super::integrals::sh::Sh9;
use super::masking::correlated::{direction_area, lit_fraction};
use super::masking::shadowing::Shadowing;
use super::slopes::grid::slope_cholesky;
use super::slopes::statistics::clamp_covariance;
use super::visible::diffuse::leadr_diffuse_light_visible;
use super::visible::fresnel::visible_fresnel;
use super::visible::shadowed_environment::{bent_normal, shadowed_diffuse_environment};
use super::visible::shadowed_specular::visible_specular_environment;
use super::visible::specular::probe_rule;
use glam::{DVec2, DVec3};

/// The number of terms in the diffuse closed form. Two terms give errors of 1.2e-3.
const DIFFUSE_TERMS: u32 = 2;

/// The number of probes for a specular environment.
const PROBES: u32 = 16;

/// A displaced surface under one pixel, in the tangent frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// The mean slope.
    pub mean_slope: DVec2,
    /// The covariance `(s_xx, s_yy, s_xy)` of the relief's slopes, without the base material's roughness. [`clamp_covariance`] clamps it.
    pub slope_covariance: DVec3,
    /// The Beckmann roughness `α` of the base material's specular term, at least 0.
    pub roughness: f64,
    /// The diffuse albedo: the re-emitted fraction of the light that enters the surface, in linear RGB from 0 to 1.
    pub albedo: DVec3,
    /// The reflectance at normal incidence, in linear RGB from 0 to 1.
    pub f0: DVec3,
}

impl Surface {
    /// Returns the slope covariances of the diffuse facets and of the visible specular microfacets.
    fn covariances(&self, wo: DVec3) -> [DVec3; 2] {
        let relief = clamp_covariance(self.slope_covariance);
        [relief, add_facet_roughness(relief, self.roughness, wo, self.mean_slope)]
    }
}

/// Returns the radiance towards `wo` under one light from `wi`, in linear RGB per unit of the light's irradiance on a plane that faces the
/// light. `wo` and `wi` are unit vectors in the tangent frame, pointing away from the surface.
///
/// The diffuse term is `albedo (1 − F)`, where `F` is the mean Fresnel reflectance of the visible facets, because reflected light does not
/// enter the surface. With an environment, the mean can also come from the probes of [`environment`], as in the renderer.
pub fn light(surface: &Surface, wo: DVec3, wi: DVec3) -> DVec3 {
    let (m, [relief, specular_s]) = (surface.mean_slope, surface.covariances(wo));
    let cholesky = slope_cholesky(relief);
    let [o, i] = [wo, wi].map(|w| direction_area(w, m, cholesky));
    let lit = lit_fraction(Shadowing::Correlated, &o, &i);
    let diffuse = lit * leadr_diffuse_light_visible(wo, wi, m, relief, false, DIFFUSE_TERMS);
    let f = facet_specular(wo, wi, surface.roughness, 0.0);
    let specular = facet_specular_light(Shadowing::Correlated, &o, &i, &f, m, cholesky, surface.f0);
    surface.albedo * (DVec3::ONE - visible_fresnel(wo, m, specular_s, surface.f0)) * diffuse + specular
}

/// Returns the radiance towards `wo` under an environment, in linear RGB. `wo` is a unit vector in the tangent frame, and `frame` is the
/// tangent frame in the world.
///
/// `radiance` looks up a prefiltered cube map for a world direction and a kernel variance per axis, in radians² (see
/// [`kernel_lod`](super::visible::kernel::kernel_lod)). `harmonics` are the environment's radiance coefficients in the world, from
/// [`sh_projection`](super::integrals::sh_projection).
///
/// ```
/// use leadr_reflectance::frame::frame_about;
/// use leadr_reflectance::integrals::sh_projection::project_function;
/// use leadr_reflectance::prelude::*;
///
/// // In a white room, a smooth white surface is white. A rough one is darker, because its facets shadow each other.
/// let room = |_: DVec3| DVec3::ONE;
/// let harmonics = project_function(16, room);
/// let shade = |variance: f64| {
///     let slope_covariance = DVec3::new(variance, variance, 0.0);
///     let surface =
///         Surface { mean_slope: DVec2::ZERO, slope_covariance, roughness: 0.1, albedo: DVec3::ONE, f0: DVec3::splat(0.04) };
///     let wo = DVec3::new(0.0, 0.6, 0.8);
///     shading::environment(&surface, wo, &frame_about(DVec3::Z), &harmonics, |wi, _| room(wi)).x
/// };
/// assert!((shade(0.0) - 1.0).abs() < 0.01);
/// assert!(shade(0.5) < 0.9);
/// ```
pub fn environment(
    surface: &Surface,
    wo: DVec3,
    frame: &Frame,
    harmonics: &Sh9,
    radiance: impl Fn(DVec3, f64) -> DVec3,
) -> DVec3 {
    let (m, [relief, specular_s]) = (surface.mean_slope, surface.covariances(wo));
    let rule = probe_rule(PROBES);
    let seen = visible_specular_environment(Shadowing::Correlated, wo, m, specular_s, surface.f0, rule, |probe| {
        radiance(from_frame(frame, probe.wi), probe.variance)
    });
    let cholesky = slope_cholesky(relief);
    let bent = bent_normal(&direction_area(wo, m, cholesky), m, cholesky);
    surface.albedo * (DVec3::ONE - seen.fresnel) * shadowed_diffuse_environment(&bent, frame, harmonics, DVec3::ZERO)
        + seen.reflected
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::frame_about;
    use crate::integrals::reference::diffuse_directional;
    use crate::integrals::sh_projection::project_function;
    use std::f64::consts::FRAC_1_PI;

    fn at(theta: f64, phi: f64) -> DVec3 {
        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    }

    const RELIEF: Surface = Surface {
        mean_slope: DVec2::new(0.2, -0.1),
        slope_covariance: DVec3::new(0.15, 0.05, 0.03),
        roughness: 0.2,
        albedo: DVec3::new(0.6, 0.5, 0.4),
        f0: DVec3::new(0.04, 0.05, 0.06),
    };

    /// A flat surface is Lambertian under a specular interface.
    #[test]
    fn a_flat_surface_is_lambertian() {
        let flat = Surface { mean_slope: DVec2::ZERO, slope_covariance: DVec3::ZERO, roughness: 0.0, ..RELIEF };
        let (wo, wi) = (at(0.3, 0.0), at(0.8, 1.0));
        let fresnel = crate::facets::fresnel::fresnel_schlick(flat.f0, wo.z);
        let expected = flat.albedo * (DVec3::ONE - fresnel) * (wi.z * FRAC_1_PI);
        assert!((light(&flat, wo, wi) / expected - DVec3::ONE).length() < 1e-3);
    }

    /// No facet is shadowed if the viewer looks along the light. Both terms then equal the terms with masking alone. The diffuse term
    /// differs by the error of its two exponentials.
    #[test]
    fn along_the_light_nothing_is_shadowed() {
        let wo = at(0.7, 0.4);
        let (m, s) = (RELIEF.mean_slope, RELIEF.slope_covariance);
        let [_, specular_s] = RELIEF.covariances(wo);
        let fresnel = visible_fresnel(wo, m, specular_s, RELIEF.f0);
        let diffuse = RELIEF.albedo * (DVec3::ONE - fresnel) * diffuse_directional(wo, wo, m, s, false, 8);
        let cholesky = slope_cholesky(s);
        let o = direction_area(wo, m, cholesky);
        let f = facet_specular(wo, wo, RELIEF.roughness, 0.0);
        let expected = diffuse + facet_specular_light(Shadowing::None, &o, &o, &f, m, cholesky, RELIEF.f0);
        assert!((light(&RELIEF, wo, wo) / expected - DVec3::ONE).length() < 4e-3);
        // Away from the light, some facets are shadowed.
        let matt = Surface { f0: DVec3::ZERO, ..RELIEF };
        let wi = at(1.45, 3.0);
        let unshadowed = matt.albedo * leadr_diffuse_light_visible(wo, wi, m, s, false, DIFFUSE_TERMS);
        let share = light(&matt, wo, wi).x / unshadowed.x;
        assert!((0.5..0.95).contains(&share), "{share}");
    }

    /// In a white room neither specular nor diffuse facets create energy.
    #[test]
    fn no_energy_is_made() {
        let room = project_function(16, |_| DVec3::ONE);
        for theta in [0.0, 0.6, 1.2, 1.5] {
            for covariance in [DVec3::ZERO, RELIEF.slope_covariance, DVec3::new(1.0, 0.4, -0.3)] {
                let surface = Surface { albedo: DVec3::ONE, slope_covariance: covariance, ..RELIEF };
                let frame = frame_about(DVec3::new(0.6, 0.0, 0.8));
                let shown = environment(&surface, at(theta, 0.9), &frame, &room, |_, _| DVec3::ONE);
                assert!(shown.min_element() > 0.3 && shown.max_element() < 1.0 + 1e-6, "{shown} at {theta}");
            }
        }
    }

    #[test]
    fn nan_covariances_show() {
        let wrong = Surface { slope_covariance: DVec3::splat(f64::NAN), ..RELIEF };
        assert!(light(&wrong, at(0.3, 0.0), at(0.5, 1.0)).is_nan());
    }
}
