//! Floor 1 · pure mathematics of LEADR mapping and microfacet theory, in `f64`: the reference, and the documentation of
//! every equation. "LEADR" is the paper of Dupuy et al. 2013, "thesis" Dupuy's of 2015.
//!
//! Each file that a shader needs has a twin of the same name under `shaders-glsl/leadr` (what ships, `f32`) and is held
//! against it by a probe under `shaders-glsl/probes`. Same function names, same argument order.
//!
//! Start with [`shading`], which has one call for a light and one for an environment, and with [`prelude`]:
//!
//! ```
//! use leadr::reflectance::prelude::*;
//!
//! // The filtered moments of a height map's slopes: E[x], E[y] and E[xx], E[yy], E[xy].
//! let covariance = covariance_from_moments(DVec2::new(0.1, 0.0), DVec3::new(0.11, 0.04, 0.0));
//! // The same surface as a BRDF of ideal mirrors, seen from straight above and lit at 45 degrees.
//! let distribution = Beckmann::new(DVec2::new(0.1, 0.0), covariance);
//! let brdf = Microfacet { distribution, masking: Masking::SmithCorrelated, fresnel: Fresnel::Ideal };
//! let value = brdf.eval(DVec3::Z, DVec3::new(0.5f64.sqrt(), 0.0, 0.5f64.sqrt()));
//! assert!((covariance.x - 0.1).abs() < 1e-12 && value.x > 0.0);
//! ```
//!
//! # Conventions
//!
//! Directions are unit vectors pointing away from the surface, in the macro tangent frame with z the displacement
//! direction: `wo` viewer, `wi` light, `wh` half vector, `wn` micronormal. A slope is `(-n.x / n.z, -n.y / n.z)`. `m` is the
//! mean slope; `s` the slope covariance as `(s_xx, s_yy, s_xy)`; `a` a roughness matrix of `α²` terms in the same order,
//! `α² = 2σ²` for Gaussian slopes. Every function is finite for every finite input, rough or smooth, facing or not; the
//! floors that see to it are in [`limits`].
//!
//! # 1 · What a material is asked
//!
//! A BRDF `f_r(wi, wo)` scatters `L_o = ∫ L_i f_r cos θ_i dwi`. [`materials::brdf::Brdf`] evaluates `f_r` and `f_r cos θ_i`, draws `wi`
//! of a stated density, and gives the throughput `f_r cos θ_i / pdf`. The simplest is [`materials::lambert::Lambert`], `albedo / π`. The
//! pair of directions can be given as half and difference ([`materials::half_difference`], thesis eq. 1.8):
//!
//! ```text
//! wh = (wi + wo) / |wi + wo|,   wd = Rot_y(−θ_h) Rot_z(−φ_h) wi
//! ```
//!
//! # 2 · The microfacet BRDF
//!
//! A rough surface is made of mirrors too small to see ([`materials::microfacet::Microfacet`], thesis eq. 2.1):
//!
//! ```text
//! f_r = F D G / (4 cos θ_i cos θ_o)                     any slope distribution × any masking × any Fresnel term
//! ```
//!
//! * **D, the facets.** `D(wn) = P22(slope of wn) / wn.z⁴` from a density of slopes ([`facets::slope_distribution`]): Gaussian
//!   ([`facets::beckmann`]) or bivariate Student ([`facets::ggx`]), of any mean (noncentral, LEADR eq. 8–10) and any covariance or roughness
//!   matrix; [`facets::ellipse`] converts radii and angle, scales and correlation, and moments into each other.
//! * **G, what hides what.** Everything follows from two projected areas per unit of macrosurface, of the mesosurface and of
//!   all that is visible ([`facets::projected_area`], with [`facets::normal_distribution`]; thesis eq. 2.14, LEADR eq. 14–15):
//!
//!   ```text
//!   a(w) = w.z − w.xy·m,   A(w) = ∫ max(0, w·(−x, −y, 1)) P22,   G₁ = cos θ / A,   1 + Λ = A / a
//!   ```
//!
//!   Smith's masking and shadowing, the V-groove, the normal map, and the thesis' noncentral form are the factors `G / a_o` of
//!   [`masking::variants`], with the limits where `a_o → 0` and without clamps of `G₁`. LEADR's own is [`masking::smith`].
//! * **F, a facet.** Ideal, Schlick, dielectric, conductor, tabulated: [`facets::fresnel`].
//! * **Sampling.** The viewer sees normals of density `max(0, wo·wn) D(wn) / A(wo)` (thesis eq. 2.15–2.17), sampled exactly for
//!   every parameter by [`facets::beckmann_sampling`] and [`facets::ggx_sampling`]; then `pdf(wi) = D / (4 A(wo))`, and the throughput is `F`
//!   times the part that the light reaches (eq. 2.23).
//!
//! # 3 · Slopes under a pixel
//!
//! `m` and `s` come from filtered moments of a height map, `s = E[x xᵀ] − E[x] E[x]ᵀ` ([`slopes::statistics`], LEADR eq. 9), and
//! from texture space into the tangent frame by the deformed surface ([`slopes::map`], LEADR eq. 12). The algebra of the
//! moments, layers, scales and shears, is [`slopes::moments`]; how a texel stores them (LEAN, LEADR, CLEAN), [`slopes::packing`].
//! What the macrosurface itself turns under a pixel adds to them ([`slopes::geometric_antialiasing`]); parts of a surface with frames of
//! their own are joined in one ([`slopes::turn`]).
//!
//! # 4 · LEADR's integrals
//!
//! With the mirrors of a Gaussian surface, `I = ∫ F(wo·wn) L(wi) ⟨wo, wn⟩ / (wn·wg) P22 dslope / A(wo)` (eq. 16–19): one light or
//! an environment sampled on a grid of slopes ([`integrals::specular`], [`slopes::grid`]). Diffuse facets see the light's cosine or the
//! environment's order-2 harmonics instead (eq. 20–23; [`integrals::diffuse`], [`integrals::sh`], [`integrals::sh_projection`]). Better than the grid: closed forms
//! of the visible slopes ([`visible::slopes`]), two terms for diffuse facets ([`visible::diffuse`]), a few probes for
//! mirrors ([`visible::specular`]), all measured by the laboratory's quadrature studies. [`mod@integrals::reference`] has the
//! converged integrals, by [`quadrature`]; [`frame`] the frames in between.

pub mod facets;
pub mod frame;
pub mod integrals;
pub mod limits;
pub mod masking;
pub mod materials;
pub mod prelude;
pub mod quadrature;
pub mod random;
pub mod shading;
pub mod slopes;
pub mod visible;

/// The vectors and matrices of every function here, so that a program needs no `glam` of the same version.
pub use glam::{DMat2, DMat3, DVec2, DVec3, DVec4};
