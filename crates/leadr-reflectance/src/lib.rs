//! The mathematics of LEADR mapping and microfacet theory, in `f64`. This crate is the reference for the shaders and
//! documents every equation. "LEADR" is the paper by Dupuy et al. (2013); "thesis" is Dupuy's thesis of 2015.
//!
//! Each file that a shader needs has an `f32` GLSL counterpart of the same name under `shaders-glsl/leadr`. Probes under
//! `shaders-glsl/probes` compare the two. Function names and argument order are the same in both.
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
//! Directions are unit vectors pointing away from the surface, in the macrosurface's tangent frame with z along the
//! displacement direction: `wo` points to the viewer, `wi` to the light, `wh` is the half vector and `wn` the
//! micronormal. A slope is `(-n.x / n.z, -n.y / n.z)`. `m` is the mean slope; `s` is the slope covariance as
//! `(s_xx, s_yy, s_xy)`; `a` is a roughness matrix of `α²` terms in the same order, with `α² = 2σ²` for Gaussian
//! slopes. Every function returns finite values for finite inputs: rough or smooth, front-facing or
//! back-facing. [`limits`] has the bounds that guarantee this.
//!
//! # 1 · What a material must provide
//!
//! A BRDF `f_r(wi, wo)` scatters `L_o = ∫ L_i f_r cos θ_i dwi`. [`materials::brdf::Brdf`] evaluates `f_r` and
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
//! * **D, the normal distribution.** `D(wn) = P22(slope of wn) / wn.z⁴`, from a slope density ([`facets::slope_distribution`]):
//!   Gaussian ([`facets::beckmann`]) or bivariate Student ([`facets::ggx`]), with any mean (noncentral, LEADR eq. 8–10)
//!   and any covariance or roughness matrix. [`facets::ellipse`] converts between radii and angle, scales and
//!   correlation, and moments.
//! * **G, masking and shadowing.** Both follow from two projected areas per unit of macrosurface: the
//!   mesosurface's and the visible microsurface's ([`facets::projected_area`], with [`facets::normal_distribution`];
//!   thesis eq. 2.14, LEADR eq. 14–15):
//!
//!   ```text
//!   a(w) = w.z − w.xy·m,   A(w) = ∫ max(0, w·(−x, −y, 1)) P22,   G₁ = cos θ / A,   1 + Λ = A / a
//!   ```
//!
//!   [`masking::variants`] expresses Smith, V-groove, normal-map and the thesis' noncentral form as factors `G / a_o`.
//!   It uses the limit where `a_o → 0` and never clamps `G₁`. LEADR's own form is [`masking::smith`].
//! * **F, the Fresnel term.** Ideal, Schlick, dielectric, conductor, or tabulated: [`facets::fresnel`].
//! * **Sampling.** Visible normals have the density `max(0, wo·wn) D(wn) / A(wo)` (thesis eq.
//!   2.15–2.17). [`facets::beckmann_sampling`] and [`facets::ggx_sampling`] sample it exactly for all parameters. The
//!   density of `wi` is `pdf(wi) = D / (4 A(wo))`, and the throughput is `F` times the lit fraction of the visible facets (eq. 2.23).
//!
//! # 3 · Slopes under a pixel
//!
//! `m` and `s` come from filtered moments of a height map, `s = E[x xᵀ] − E[x] E[x]ᵀ` ([`slopes::statistics`], LEADR
//! eq. 9). The deformed surface maps them from texture space to the tangent frame ([`slopes::map`], LEADR eq. 12).
//! [`slopes::moments`] has their algebra: layers, scales and shears. [`slopes::packing`] defines the texel formats
//! (LEAN, LEADR, CLEAN). [`slopes::geometric_antialiasing`] adds the rotation of the macrosurface within a
//! pixel, and [`slopes::rotation`] combines parts of a surface with different frames. Normal maps and gloss maps are filtered
//! by mean normal length instead ([`facets::shortened_normals`], [`facets::footprint_normals`], [`facets::gloss`];
//! Chan 2018) and layered by [`slopes::normal_blending`].
//!
//! # 4 · LEADR's integrals
//!
//! For specular facets of a Gaussian surface, `I = ∫ F(wo·wn) L(wi) ⟨wo, wn⟩ / (wn·wg) P22 dslope / A(wo)` (eq. 16–19), for
//! one light or for an environment sampled on a grid of slopes ([`integrals::specular`], [`slopes::grid`]). For diffuse
//! facets the light's cosine or the environment's order-2 harmonics replace specular reflection (eq. 20–23;
//! [`integrals::diffuse`], [`integrals::sh`], [`integrals::sh_projection`]). Three methods are more accurate than the
//! grid: closed forms of the visible slopes ([`visible::slopes`]), two exponential terms for diffuse facets
//! ([`visible::diffuse`]), and a few probes for specular facets ([`visible::specular`]). The laboratory's quadrature
//! studies measure them all. [`mod@integrals::reference`] computes the converged integrals by [`quadrature`]; [`frame`]
//! converts between frames.

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

/// The vector and matrix types of this crate's functions, so that callers need not match its `glam` version.
pub use glam::{DMat2, DMat3, DVec2, DVec3, DVec4};
