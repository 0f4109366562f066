//! Masking and shadowing with correlated view and light directions.
//!
//! Smith's height-correlated form `1 / (1 + Λ_o + Λ_i)` (LEADR eq. 13) assumes that, at a given height, the two directions are occluded
//! independently. With the viewer along the light this is wrong: all visible facets are lit. More generally, if two rays have the same
//! azimuth, only the lower one matters. Here
//!
//! ```text
//! G = 1 / (1 + max(Λ_o, Λ_i) + f min(Λ_o, Λ_i)),   0 ≤ f ≤ 1
//! ```
//!
//! `f = 0` for equal azimuths is exact at any two elevations, and `f → 1` (Smith) as the azimuths separate. The azimuth is measured in the
//! space where the surface is isotropic, `p = Cᵀ w.xy` with `C Cᵀ = S`. The cosine of the angle `φ` between the directions there is the
//! correlation of the slopes along them: `cos φ = oᵀ S i / (b_o b_i)`, `b = |p|`. With `q = tan(φ/2)`,
//!
//! ```text
//! simple:  f = q / (q + 0.26)
//! full:    f = t / (t + κ),   t = √(q² + r²) − r,   κ = 0.5 / (1 + 2 min Λ),   r = 0.3 (max Λ − min Λ) / (max Λ + min Λ)
//! ```
//!
//! The form is derived; the constants are fitted to ray casts (`docs/measurements/shadowing.md` describes the held-out data). The
//! directions decorrelate sooner with more occlusion (κ), and later for different elevations (r).
//!
//! For all constants, `G` is symmetric in the two directions. It lies between Smith's form and masking alone, so a white furnace gives at
//! most 1. It has no poles: the code uses products with `a_o a_i` instead of dividing by areas that may be 0.

use super::shadowing::Shadowing;
use crate::facets::projected_area::{meso_area, rough_area};
use crate::limits::{MIN_AREA, at_least};
use glam::{DVec2, DVec3};

/// Projected areas of a surface from one direction: computed once per pixel for the viewer, and once per light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionArea {
    /// `p = Cᵀ w.xy`, the horizontal part of the direction in the space with isotropic slopes.
    pub whitened: DVec2,
    /// `b = |p|`: standard deviation of the slope along the direction, times sin θ.
    pub spread: f64,
    /// `a`: projected area of the mesosurface per unit of macrosurface; negative if back-facing.
    pub meso: f64,
    /// `A`: visible projected area per unit of macrosurface.
    pub visible: f64,
}

/// `p = Cᵀ w.xy` from the lower Cholesky factor `(c_xx, c_yx, c_yy)` of the slopes' covariance
/// ([`crate::slopes::grid::slope_cholesky`]).
pub fn whitened_direction(w: DVec3, cholesky: DVec3) -> DVec2 {
    DVec2::new(cholesky.x * w.x + cholesky.y * w.y, cholesky.z * w.y)
}

/// The areas of a Gaussian surface of mean slope `m` from the direction `w`.
pub fn direction_area(w: DVec3, m: DVec2, cholesky: DVec3) -> DirectionArea {
    let whitened = whitened_direction(w, cholesky);
    let (spread, meso) = (whitened.length(), meso_area(w, m));
    DirectionArea { whitened, spread, meso, visible: meso.max(0.0) + rough_area(meso, spread) }
}

/// The module's `f`, from 0 for equal azimuths to 1. `less`, `more`: `a_o a_i` times the smaller and the larger `Λ`; `both`: `a_o a_i`.
/// Only their ratios matter; `simple` ignores them.
pub fn decorrelation(po: DVec2, pi: DVec2, both: f64, more: f64, less: f64, simple: bool) -> f64 {
    // sin φ and cos φ from products of the whitened directions; q = tan(φ/2) = sine / along.
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

/// `G / a_o`, in 0..1e6: the factor of `F D / 4` in `f_r cos θ_i`, and `1 / A_o` for [`Shadowing::None`]. With shadowing, 0 for a light on
/// or below the mesosurface. [`Shadowing::NormalMap`] gives 1: facets are weighted by their macrosurface area and have individual factors
/// ([`mapped_specular_light`](crate::visible::mapped::mapped_specular_light)).
pub fn masking_shadowing_factor(shadowing: Shadowing, o: &DirectionArea, i: &DirectionArea) -> f64 {
    if shadowing == Shadowing::NormalMap {
        return 1.0;
    }
    lit_fraction(shadowing, o, i) / at_least(o.visible, MIN_AREA)
}

/// `G A_o / a_o = G / G₁(o)`, 0..1: the lit fraction of the visible facets. It weights a light, or an environment sample in a sum already
/// normalised for masking.
pub fn lit_fraction(shadowing: Shadowing, o: &DirectionArea, i: &DirectionArea) -> f64 {
    if matches!(shadowing, Shadowing::None | Shadowing::NormalMap) {
        return 1.0;
    }
    // All values times a_o a_i: U, U Λ_o, U Λ_i.
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
