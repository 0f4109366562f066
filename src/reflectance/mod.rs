//! Floor 1 · pure mathematics of LEADR mapping and microfacet theory, in `f64`: the reference, and the documentation of
//! every equation. "LEADR" is the paper of Dupuy et al. 2013, "thesis" Dupuy's of 2015.
//!
//! Each file that a shader needs has a twin of the same name under `shaders-glsl/leadr` (what ships, `f32`) and is held
//! against it by a probe under `shaders-glsl/probes`. Same function names, same argument order.
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
//! A BRDF `f_r(wi, wo)` scatters `L_o = ∫ L_i f_r cos θ_i dwi`. [`brdf::Brdf`] evaluates `f_r` and `f_r cos θ_i`, draws `wi`
//! of a stated density, and gives the throughput `f_r cos θ_i / pdf`. The simplest is [`lambert::Lambert`], `albedo / π`. The
//! pair of directions can be given as half and difference ([`half_difference`], thesis eq. 1.8):
//!
//! ```text
//! wh = (wi + wo) / |wi + wo|,   wd = Rot_y(−θ_h) Rot_z(−φ_h) wi
//! ```
//!
//! # 2 · The microfacet BRDF
//!
//! A rough surface is made of mirrors too small to see ([`microfacet::Microfacet`], thesis eq. 2.1):
//!
//! ```text
//! f_r = F D G / (4 cos θ_i cos θ_o)                     any slope distribution × any masking × any Fresnel term
//! ```
//!
//! * **D, the facets.** `D(wn) = P22(slope of wn) / wn.z⁴` from a density of slopes ([`slope_distribution`]): Gaussian
//!   ([`beckmann`]) or bivariate Student ([`ggx`]), of any mean (noncentral, LEADR eq. 8–10) and any covariance or roughness
//!   matrix; [`ellipse`] converts radii and angle, scales and correlation, and moments into each other.
//! * **G, what hides what.** Everything follows from two projected areas per unit of macrosurface, of the mesosurface and of
//!   all that is visible ([`projected_area`], with [`normal_distribution`]; thesis eq. 2.14, LEADR eq. 14–15):
//!
//!   ```text
//!   a(w) = w.z − w.xy·m,   A(w) = ∫ max(0, w·(−x, −y, 1)) P22,   G₁ = cos θ / A,   1 + Λ = A / a
//!   ```
//!
//!   Smith's masking and shadowing, the V-groove, the normal map, and the thesis' noncentral form are the factors `G / a_o` of
//!   [`masking_variants`], with the limits where `a_o → 0` and without clamps of `G₁`. LEADR's own is [`masking`].
//! * **F, a facet.** Ideal, Schlick, dielectric, conductor, tabulated: [`fresnel`].
//! * **Sampling.** The viewer sees normals of density `max(0, wo·wn) D(wn) / A(wo)` (thesis eq. 2.15–2.17), sampled exactly for
//!   every parameter by [`beckmann_sampling`] and [`ggx_sampling`]; then `pdf(wi) = D / (4 A(wo))`, and the throughput is `F`
//!   times the part that the light reaches (eq. 2.23).
//!
//! # 3 · Slopes under a pixel
//!
//! `m` and `s` come from filtered moments of a height map, `s = E[x xᵀ] − E[x] E[x]ᵀ` ([`slope_statistics`], LEADR eq. 9), and
//! from texture space into the tangent frame by the deformed surface ([`slope_map`], LEADR eq. 12). The algebra of the
//! moments, layers, scales and shears, is [`slope_moments`]; how a texel stores them (LEAN, LEADR, CLEAN), [`slope_packing`].
//! What the macrosurface itself turns under a pixel adds to them ([`geometric_antialiasing`]); parts of a surface with frames of
//! their own are joined in one ([`slope_turn`]).
//!
//! # 4 · LEADR's integrals
//!
//! With the mirrors of a Gaussian surface, `I = ∫ F(wo·wn) L(wi) ⟨wo, wn⟩ / (wn·wg) P22 dslope / A(wo)` (eq. 16–19): one light or
//! an environment sampled on a grid of slopes ([`specular`], [`slope_grid`]). Diffuse facets see the light's cosine or the
//! environment's order-2 harmonics instead (eq. 20–23; [`diffuse`], [`sh`], [`sh_projection`]). Better than the grid: closed forms
//! of the visible slopes ([`visible_slopes`]), two terms for diffuse facets ([`visible_diffuse`]), a few probes for
//! mirrors ([`visible_specular`]), all measured by [`quadrature_study`]. [`mod@reference`] has the
//! converged integrals, by [`quadrature`]; [`frame`] the frames in between.

pub mod beckmann;
pub mod beckmann_sampling;
pub mod brdf;
pub mod classic;
pub mod correlated_masking;
pub mod diffuse;
pub mod ellipse;
pub mod frame;
pub mod fresnel;
pub mod geometric_antialiasing;
pub mod ggx;
pub mod ggx_filtering;
pub mod ggx_lobes;
pub mod ggx_sampling;
pub mod half_difference;
pub mod lambert;
pub mod limits;
pub mod masking;
pub mod masking_variants;
pub mod microfacet;
pub mod normal_distribution;
pub mod projected_area;
pub mod quadrature;
pub mod quadrature_study;
pub mod reference;
pub mod sh;
pub mod sh_projection;
pub mod shadowed_environment;
pub mod shadowed_reference;
pub mod shadowed_specular;
pub mod slope_distribution;
pub mod slope_grid;
pub mod slope_map;
pub mod slope_moments;
pub mod slope_packing;
pub mod slope_statistics;
pub mod slope_turn;
pub mod specular;
pub mod visible_diffuse;
pub mod visible_fresnel;
pub mod visible_slopes;
pub mod visible_specular;
