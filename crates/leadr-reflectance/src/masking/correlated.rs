//! Masking and shadowing with correlated view and light directions.
//!
//! Smith's height-correlated form `1 / (1 + Λ_o + Λ_i)` (LEADR eq. 13) assumes that, at a given height, the two directions are occluded
//! independently. The assumption is wrong if the viewer looks along the direction of the light, because all visible facets are then lit.
//! More generally, if two rays have the same azimuth, only the lower ray matters. This module uses
//!
//! ```text
//! G = 1 / (1 + max(Λ_o, Λ_i) + f min(Λ_o, Λ_i)),   0 ≤ f ≤ 1
//! ```
//!
//! `f = 0` for equal azimuths is exact at any two elevations, and `f → 1` (Smith) as the azimuths separate. The azimuth is measured in the
//! space where the surface is isotropic, `p = Cᵀ w.xy` with `C Cᵀ = S`. In that space, the cosine of the angle `φ` between the directions
//! is the correlation of the slopes along them: `cos φ = oᵀ S i / (b_o b_i)` with `b = |p|`. With `q = tan(φ/2)`, the two forms of `f` are
//!
//! ```text
//! simple:  f = q / (q + 0.26)
//! full:    f = t / (t + κ),   t = √(q² + r²) − r,   κ = 0.5 / (1 + 2 min Λ),   r = 0.3 (max Λ − min Λ) / (max Λ + min Λ)
//! ```
//!
//! The form of the equations is derived, and their constants are fitted to ray casts (`docs/measurements/shadowing.md` describes the
//! held-out data). The two directions decorrelate sooner if there is more occlusion (κ), and later if their elevations differ (r).
//!
//! For all values of the constants, `G` is symmetric in the two directions. `G` lies between Smith's form and the value for masking alone,
//! so a white furnace never gains energy. The code has no poles, because it multiplies by `a_o a_i` instead of dividing by areas that may
//! be 0.

use super::shadowing::Shadowing;
use crate::facets::projected_area::{meso_area, rough_area};
use crate::limits::{MIN_AREA, at_least};
use glam::{DVec2, DVec3};

/// The projected areas of a surface from one direction, computed once per pixel for the viewer and once per light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionArea {
    /// The vector `p = Cᵀ w.xy`, which is the horizontal part of the direction in the space with isotropic slopes.
    pub whitened: DVec2,
    /// The length `b = |p|`, which is the standard deviation of the slope along the direction, times sin θ.
    pub spread: f64,
    /// The projected area `a` of the mesosurface per unit of macrosurface, which is negative for a back-facing mesosurface.
    pub meso: f64,
    /// The visible projected area `A` per unit of macrosurface.
    pub visible: f64,
}

/// Returns `p = Cᵀ w.xy` from the lower Cholesky factor `(c_xx, c_yx, c_yy)` of the slope covariance
/// ([`crate::slopes::grid::slope_cholesky`]).
pub fn whitened_direction(w: DVec3, cholesky: DVec3) -> DVec2 {
    DVec2::new(cholesky.x * w.x + cholesky.y * w.y, cholesky.z * w.y)
}

/// Returns the areas of a Gaussian surface with the mean slope `m` from the direction `w`.
pub fn direction_area(w: DVec3, m: DVec2, cholesky: DVec3) -> DirectionArea {
    let whitened = whitened_direction(w, cholesky);
    let (spread, meso) = (whitened.length(), meso_area(w, m));
    DirectionArea { whitened, spread, meso, visible: meso.max(0.0) + rough_area(meso, spread) }
}

/// Returns the factor `f` of the module's formula, which rises from 0 for equal azimuths to 1. `both` is `a_o a_i`, and `less` and `more`
/// are `a_o a_i` times the smaller and the larger `Λ`. Only the ratios of these three matter, and the `simple` form ignores them.
pub fn decorrelation(po: DVec2, pi: DVec2, both: f64, more: f64, less: f64, simple: bool) -> f64 {
    // Products of the whitened directions give sin φ and cos φ. Then q = tan(φ/2) = sine / along.
    let scale = 1.0 / (po.length_squared() * pi.length_squared()).sqrt().max(1e-18);
    let cosine = po.dot(pi) * scale;
    let sine = (po.x * pi.y - po.y * pi.x).abs() * scale;
    let along = if cosine >= 0.0 { 1.0 + cosine } else { sine * sine / (1.0 - cosine) };
    if simple {
        return (sine + 1e-9) / (sine + 0.26 * along + 1e-9);
    }
    let late = 0.3 * (more - less) / (more + less).max(1e-30) * along;
    let t = sine * sine / ((sine * sine + late * late).sqrt() + late).max(1e-18);
    let half_width = 0.5 * both / (both + 2.0 * less).max(1e-30) * along;
    (t + 1e-9) / (t + half_width + 1e-9)
}

/// Returns `G / a_o`, from 0 to 1e6, which is the factor of `F D / 4` in `f_r cos θ_i`. [`Shadowing::None`] gives `1 / A_o`. With
/// shadowing, a light on or below the mesosurface gives 0. [`Shadowing::NormalMap`] gives 1, because facets are weighted by their
/// macrosurface area and have individual factors ([`mapped_specular_light`](crate::visible::mapped::mapped_specular_light)).
pub fn masking_shadowing_factor(shadowing: Shadowing, o: &DirectionArea, i: &DirectionArea) -> f64 {
    if shadowing == Shadowing::NormalMap {
        return 1.0;
    }
    lit_fraction(shadowing, o, i) / at_least(o.visible, MIN_AREA)
}

/// Returns `G A_o / a_o = G / G₁(o)`, the fraction of the visible facets that is lit, from 0 to 1. The fraction weights a light, or an
/// environment sample in a sum that is already normalised for masking. [`Shadowing::VGroove`] gives 1, because it shadows each facet by
/// itself ([`groove_lit_fraction`](super::grooves::groove_lit_fraction)).
pub fn lit_fraction(shadowing: Shadowing, o: &DirectionArea, i: &DirectionArea) -> f64 {
    if matches!(shadowing, Shadowing::None | Shadowing::NormalMap | Shadowing::VGroove) {
        return 1.0;
    }
    if shadowing == Shadowing::SmithSeparable {
        return i.meso.max(0.0) / at_least(i.visible, MIN_AREA);
    }
    // The code multiplies all terms by U = a_o a_i. It therefore uses U, U Λ_o and U Λ_i.
    let (ao, ai) = (o.meso.max(0.0), i.meso.max(0.0));
    let seen = ai * at_least(o.visible, MIN_AREA);
    let both = ao * ai;
    let (hidden_o, hidden_i) = (at_least(o.visible - ao, 0.0) * ai, at_least(i.visible - ai, 0.0) * ao);
    let (more, less) = (hidden_o.max(hidden_i), hidden_o.min(hidden_i));
    let f = match shadowing {
        Shadowing::Correlated => decorrelation(o.whitened, i.whitened, both, more, less, false),
        Shadowing::CorrelatedSimple => decorrelation(o.whitened, i.whitened, both, more, less, true),
        _ => 1.0,
    };
    seen / at_least(seen + at_least(hidden_i - hidden_o, 0.0) + f * less, 1e-30)
}
