//! The mathematics of LEADR mapping and microfacet theory, in `f64`. This crate is the reference for the shaders and documents every
//! equation. "LEADR" means the paper by Dupuy et al. (2013), and "thesis" means Dupuy's thesis of 2015.
//!
//! Each module that the shaders need has an `f32` GLSL counterpart of the same name under `shaders-glsl/leadr`. Probe shaders under
//! `shaders-glsl/probes` compare the results of the two versions. Function names and the order of arguments are the same in both languages.
//!
//! Start with [`shading`], which has one function for a light and one for an environment, and with [`prelude`]:
//!
//! ```
//! use leadr_reflectance::prelude::*;
//!
//! // The filtered moments of a height map's slopes: E[x], E[y] and E[xx], E[yy], E[xy].
//! let covariance = covariance_from_moments(DVec2::new(0.1, 0.0), DVec3::new(0.11, 0.04, 0.0));
//! // The same surface as a BRDF of ideal specular facets, viewed at normal incidence and lit at 45 degrees.
//! let distribution = Beckmann::new(DVec2::new(0.1, 0.0), covariance);
//! let brdf = Microfacet { distribution, masking: Masking::SmithCorrelated, fresnel: Fresnel::Ideal };
//! let value = brdf.eval(DVec3::Z, DVec3::new(0.5f64.sqrt(), 0.0, 0.5f64.sqrt()));
//! assert!((covariance.x - 0.1).abs() < 1e-12 && value.x > 0.0);
//! ```
//!
//! # Conventions
//!
//! Directions are unit vectors pointing away from the surface, in the tangent frame of the macrosurface with z along the displacement
//! direction: `wo` points to the viewer, `wi` points to the light, `wh` is the half vector, and `wn` is the micronormal. A slope is
//! `(-n.x / n.z, -n.y / n.z)`. `m` is the mean slope, and `s` is the slope covariance as `(s_xx, s_yy, s_xy)`. `a` is a roughness matrix of
//! `α²` terms in the same order, with `α² = 2σ²` for Gaussian slopes. Every function returns finite values for finite inputs, whether the
//! surface is rough or smooth, front-facing or back-facing. The bounds in [`limits`] guarantee this.
//!
//! # 1 · What a material must provide
//!
//! A BRDF `f_r(wi, wo)` gives the reflected radiance `L_o = ∫ L_i f_r cos θ_i dwi`. [`materials::brdf::Brdf`] evaluates `f_r` and
//! `f_r cos θ_i`, samples `wi`, and returns the density and the throughput `f_r cos θ_i / pdf`. The simplest BRDF is
//! [`materials::lambert::Lambert`], `albedo / π`. Half and difference vectors are another parametrisation of `wi` and `wo`
//! ([`materials::half_difference`], thesis eq. 1.8):
//!
//! ```text
//! wh = (wi + wo) / |wi + wo|,   wd = Rot_y(−θ_h) Rot_z(−φ_h) wi
//! ```
//!
//! # 2 · The microfacet BRDF
//!
//! A rough surface consists of microscopic specular facets ([`materials::microfacet::Microfacet`], thesis eq. 2.1):
//!
//! ```text
//! f_r = F D G / (4 cos θ_i cos θ_o)                     any slope distribution × any masking × any Fresnel term
//! ```
//!
//! * **D, the normal distribution.** A slope density P22 gives `D(wn) = P22(slope of wn) / wn.z⁴` ([`facets::slope_distribution`]). The
//!   density is Gaussian ([`facets::beckmann`]) or bivariate Student ([`facets::ggx`]), with any mean (noncentral, LEADR eq. 8–10) and any
//!   covariance or roughness matrix. [`facets::ellipse`] converts between radii and angle, scales and correlation, and moments.
//! * **G, masking and shadowing.** G follows from two projected areas per unit of macrosurface: the mesosurface's area `a` and the
//!   microsurface's visible area `A` ([`facets::projected_area`], with [`facets::normal_distribution`]; thesis eq. 2.14, LEADR eq. 14–15):
//!
//!   ```text
//!   a(w) = w.z − w.xy·m,   A(w) = ∫ max(0, w·(−x, −y, 1)) P22,   G₁ = cos θ / A,   1 + Λ = A / a
//!   ```
//!
//!   [`masking::variants`] writes the Smith, V-groove, normal-map and thesis forms as factors `G / a_o`. They use the limit where `a_o → 0`
//!   and never clamp `G₁`. The form of the LEADR paper is in [`masking::smith`].
//! * **F, the Fresnel term.** [`facets::fresnel`] has ideal, Schlick, dielectric, conductor and tabulated Fresnel terms.
//! * **Sampling.** Visible normals have the density `max(0, wo·wn) D(wn) / A(wo)` (thesis eq. 2.15–2.17). [`facets::beckmann_sampling`] and
//!   [`facets::ggx_sampling`] sample this density exactly for all parameters. The density of `wi` is `pdf(wi) = D / (4 A(wo))`, and the
//!   throughput is `F` times the lit fraction of the visible facets (eq. 2.23).
//!
//! # 3 · Slopes under a pixel
//!
//! The mean slope `m` and the covariance `s` come from filtered moments of a height map, `s = E[x xᵀ] − E[x] E[x]ᵀ`
//! ([`slopes::statistics`], LEADR eq. 9). [`slopes::map`] transforms both from texture space to the tangent frame of the deformed surface
//! (LEADR eq. 12). [`slopes::moments`] has the algebra of moments for layers, scales and shears. [`slopes::packing`] defines the texel
//! formats (LEAN, LEADR, CLEAN). [`slopes::geometric_antialiasing`] adds the rotation of the macrosurface within a pixel, and
//! [`slopes::rotation`] combines surface parts with different frames. Normal maps and gloss maps are filtered by mean normal length instead
//! ([`facets::shortened_normals`], [`facets::footprint_normals`], [`facets::gloss`]; Chan 2018) and layered by [`slopes::normal_blending`].
//!
//! # 4 · LEADR's integrals
//!
//! For specular facets of a Gaussian surface, `I = ∫ F(wo·wn) L(wi) ⟨wo, wn⟩ / (wn·wg) P22 dslope / A(wo)` (eq. 16–19), for one light or
//! for an environment sampled on a grid of slopes ([`integrals::specular`], [`slopes::grid`]). For diffuse facets, the cosine of the light
//! or the order-2 harmonics of the environment replace specular reflection (eq. 20–23; [`integrals::diffuse`], [`integrals::sh`],
//! [`integrals::sh_projection`]). Three methods are more accurate than the grid: closed forms of the visible slopes ([`visible::slopes`]),
//! two exponential terms for diffuse facets ([`visible::diffuse`]), and a few probes for specular facets ([`visible::specular`]). The
//! quadrature studies of `leadr-lab` measure them all. [`mod@integrals::reference`] computes the converged integrals by [`quadrature`], and
//! [`frame`] converts between frames.

pub mod color;
pub mod extraction;
pub mod facets;
pub mod frame;
pub mod integrals;
pub mod limits;
pub mod masking;
pub mod materials;
pub mod prelude;
pub mod quadrature;
pub mod random;
mod roots;
pub mod shading;
pub mod slopes;
pub mod visible;

/// Re-exports the vector and matrix types of this crate's functions, so that callers need not match its `glam` version.
pub use glam::{DMat2, DMat3, DVec2, DVec3, DVec4};
