//! The diffuse reflection of environments with self-shadowing of the surface, by one irradiance lookup.
//!
//! The method is based on two exact facts:
//!
//! 1. The surface as a whole loses no light: all light that passes the mesosurface reaches some facet. Under any environment, the total
//!    irradiance on all facets therefore equals the irradiance on the flat mesosurface, which is one clamped cosine. Shadowed diffuse
//!    reflection is thus nearly an occlusion factor times one clamped cosine around a bent normal.
//! 2. The mean of the visible slopes has a closed form (Stein's lemma for the clamped facet areas):
//!
//!    ```text
//!    E_visible[slope] = m + Δ,   Δ = −S o.xy Φ(a/b) / A
//!    ```
//!
//! The occlusion `a₀` and the bent normal along `(−(m + c Δ), 1)` follow from these facts with fitted constants
//! (`docs/measurements/shadowing.md`):
//!
//! ```text
//! q = 1 + |m|²,  τ = ½ tr S / q,  δ = √det S / q,  G₁ = a/A,  μ² = a²/q
//! x  = 1.10 τ / (1 + 0.89 √(τ + 1.2 (τ − δ)))
//! a₀ = 1 − x/(1+x) (0.67 + 0.33 G₁) + 0.19 Δ·m/q              within 0..1
//! c  = (1 + 0.38 √τ (1 − μ²)²) / (1 + 2.25 τ / (√τ + 0.22))
//! ```
//!
//! Light that is blocked is lost, because interreflection between facets is not included.

use crate::facets::normal_distribution::clamped_lean;
use crate::frame::{Frame, from_frame};
use crate::integrals::sh::{Sh9, sh_irradiance};
use crate::masking::correlated::DirectionArea;
use crate::slopes::grid::normal_of_slope;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Returns `Δ`, the exact mean visible slope minus the mean slope. The shift is clamped to ±1e3, which only back-facing surfaces exceed.
pub fn visible_slope_shift(o: &DirectionArea, cholesky: DVec3) -> DVec2 {
    let tilt = clamped_lean((o.meso / o.spread.max(1e-12)).clamp(-1e6, 1e6));
    let along = o.whitened * (-tilt / o.spread.max(1e-12));
    DVec2::new(cholesky.x * along.x, cholesky.y * along.x + cholesky.z * along.y)
        .clamp(DVec2::splat(-1e3), DVec2::splat(1e3))
}

/// The response of a shadowed diffuse surface to an environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BentNormal {
    /// The unit normal for the irradiance lookup, in the tangent frame.
    pub normal: DVec3,
    /// The factor `a₀` of the irradiance, from 0 to 1.
    pub open: f64,
}

/// Returns the bent normal and the occlusion of a surface of mean slope `m` and covariance `C Cᵀ`. `o` is the
/// [`direction_area`](crate::masking::correlated::direction_area) of the viewer.
pub fn bent_normal(o: &DirectionArea, m: DVec2, cholesky: DVec3) -> BentNormal {
    let iq = 1.0 / (1.0 + m.length_squared());
    let tau = 0.5 * iq * cholesky.length_squared();
    let det = iq * cholesky.x * cholesky.z;
    let ao = o.meso.max(0.0);
    let g1 = ao / o.visible.max(1e-30);
    let shift = visible_slope_shift(o, cholesky);
    let x = 1.10 * tau / (1.0 + 0.89 * (tau + 1.2 * (tau - det).max(0.0)).sqrt());
    let open = 1.0 - x / (1.0 + x) * (0.67 + 0.33 * g1) + 0.19 * shift.dot(m) * iq;
    let (grazing, sigma) = (1.0 - ao * ao * iq, tau.sqrt());
    let bend = (1.0 + 0.38 * sigma * grazing * grazing) / (1.0 + 2.25 * tau / (sigma + 0.22));
    BentNormal { normal: normal_of_slope(m + bend * shift), open: open.clamp(0.0, 1.0) }
}

/// Returns the diffuse radiance under an environment with shadowing, per unit of albedo, at least 0. `c` and `f` are the radiance
/// coefficients and the tangent frame in the world. `rest` is the irradiance beyond order 2 at the bent normal, or 0.
///
/// A bent normal represents one clamped cosine (the module's first fact), so `rest` is added in full for any roughness.
pub fn shadowed_diffuse_environment(v: &BentNormal, f: &Frame, c: &Sh9, rest: DVec3) -> DVec3 {
    (sh_irradiance(c, from_frame(f, v.normal)) + rest).max(DVec3::ZERO) * (v.open / PI)
}
