//! Occlusion by larger bumps, which form a horizon around a point on the relief.
//!
//! Slope statistics under a pixel model the shadowing between its facets. Bumps larger than the pixel shadow the whole pixel, each from one
//! side. For a unit vector `v` of the tangent plane, the tangent of the horizon's elevation is
//!
//! ```text
//! T(v) = m·v + e(v),   e(v) = max(0, l·v + √(vᵀ Q v))
//! ```
//!
//! The excess `e` is never negative, because directions below the plane of the mean slope `m` are always occluded. The lean `l` points to
//! the side where the ground rises more. The spread `Q` is the rise that opposite sides share, across and along a valley. A slope `s` that
//! descends to the point from one side only has exactly `l = s/2`, `Q = s sᵀ/4`. The form is homogeneous, so `l` transforms like a mean
//! slope and `Q` like a covariance when the coordinates rotate and stretch. Scaling the heights by a factor multiplies `l` by this factor
//! and `Q` by its square. `leadr_maps` fits the form to heights per mip level. Each level contains only bumps larger than its texels, so no
//! bump is counted again in the slope statistics.
//!
//! `l` and `Q` are relative to the plane of the mean slope, which the statistics already include. A light is weighted by the fraction of
//! its part above this plane that is unoccluded.

use crate::frame::{Frame, from_frame};
use crate::integrals::sh::{Sh9, sh_radiance};
use crate::slopes::grid::normal_of_slope;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// The excess of a horizon over the plane of the mean slope.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Horizon {
    /// The lean `l`, as a slope.
    pub lean: DVec2,
    /// The spread `Q` as `xx, yy, xy`, in squared slopes.
    pub spread: DVec3,
}

/// Returns `e(v)`, the height of the horizon above the plane of the mean slope at the distance `|v|`. The height is at least 0.
pub fn horizon_excess(v: DVec2, h: &Horizon) -> f64 {
    let square = v.x * v.x * h.spread.x + v.y * v.y * h.spread.y + 2.0 * v.x * v.y * h.spread.z;
    (h.lean.dot(v) + square.max(0.0).sqrt()).max(0.0)
}

/// Returns the same horizon with its excess scaled by `factor`.
pub fn raised_horizon(h: &Horizon, factor: f64) -> Horizon {
    Horizon { lean: h.lean * factor, spread: h.spread * (factor * factor) }
}

/// The deviation of the true horizon's tangent from its smooth form, relative to the excess.
pub const HORIZON_RAGGED: f64 = 0.13;

/// Returns the part of a light lobe about `wi` that is above the horizon, divided by the part above the plane of the mean slope `m`. The
/// result is from 0 to 1. `deviation` is the standard deviation of the lobe's directions along one axis, in radians. The lobe's height
/// above the horizon has a parabolic distribution (Epanechnikov kernel), whose integral is the cubic of `smoothstep`.
pub fn horizon_visibility(wi: DVec3, m: DVec2, h: &Horizon, deviation: f64) -> f64 {
    let flat = wi.truncate();
    let plane = wi.z - flat.dot(m);
    let excess = horizon_excess(flat, h);
    // The change of the height per angle is 1 + T², squared here.
    let high = flat.dot(m) + excess;
    let per_angle = 1.0 + high * high / flat.length_squared().max(1e-12);
    let ragged = HORIZON_RAGGED * excess;
    let width = 5.0f64.sqrt() * (deviation * deviation * per_angle + ragged * ragged + 1e-12).sqrt();
    smoothstep(width, plane - excess) / smoothstep(width, plane).max(1e-3)
}

/// Returns a cubic step that rises from 0 at `-width` to 1 at `width`.
fn smoothstep(width: f64, x: f64) -> f64 {
    let t = (0.5 + 0.5 * x / width).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The number of pairs of opposite azimuths in [`horizon_hidden`].
pub const HORIZON_AXES: u32 = 4;

/// Integrals over the directions between the plane of the mean slope and the horizon.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hidden {
    /// The vector `(1/π) ∫ w dw` over these directions. Its dot product with a normal is the irradiance of these directions under a white
    /// sky, divided by `π`.
    pub weight: DVec3,
    /// The solid angle of these directions divided by π, from 0 to 2.
    pub angle: f64,
}

/// Integrates the hidden directions. For one azimuth, the integrals between elevations of tangents `T₀ ≤ T₁` are
///
/// ```text
/// w:  ½ (θ − T₀/(1+T₀²) + T₁/(1+T₁²)) along v,   ½ (1/(1+T₀²) − 1/(1+T₁²)) along z,   θ = atan T₁ − atan T₀
/// dw: T₁/√(1+T₁²) − T₀/√(1+T₀²)
/// ```
pub fn horizon_hidden(m: DVec2, h: &Horizon) -> Hidden {
    let mut hidden = Hidden::default();
    for k in 0..2 * HORIZON_AXES {
        let azimuth = PI * (f64::from(k) + 0.5) / f64::from(HORIZON_AXES);
        let v = DVec2::new(azimuth.cos(), azimuth.sin());
        let (low, excess) = (m.dot(v), horizon_excess(v, h));
        let high = low + excess;
        let (per_low, per_high) = (1.0 / (1.0 + low * low), 1.0 / (1.0 + high * high));
        let between = excess.atan2(1.0 + low * high);
        hidden.weight += (v * (between - low * per_low + high * per_high)).extend(per_low - per_high);
        hidden.angle += 2.0 * (high * per_high.sqrt() - low * per_low.sqrt());
    }
    let each = 0.5 / f64::from(HORIZON_AXES);
    Hidden { weight: hidden.weight * each, angle: hidden.angle * each }
}

/// Returns the diffuse radiance `whole` of an environment, per unit of albedo, minus the radiance from the hidden directions. The radiance
/// of their mean direction approximates all of them. `open`, from 0 to 1, is the fraction of the facets that face any hidden direction. `c`
/// and `f` are the radiance coefficients and the tangent frame in the world. The result is at least half of its value under a uniform
/// environment, because order-2 harmonics ring, and a pit that sees some sky is never black.
pub fn diffuse_past_horizon(whole: DVec3, open: f64, hidden: &Hidden, m: DVec2, f: &Frame, c: &Sh9) -> DVec3 {
    // The mean of unit directions lies inside the unit sphere.
    let mean = hidden.weight / hidden.angle.max(1e-6);
    let share = hidden.weight.dot(normal_of_slope(m)).clamp(0.0, 1.0);
    let lost = open * share * sh_radiance(c, from_frame(f, mean)).max(DVec3::ZERO);
    (whole - lost).max(0.5 * (1.0 - share) * whole.max(DVec3::ZERO))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ridge(slope: DVec2) -> Horizon {
        let s = slope * 0.5;
        Horizon { lean: s, spread: DVec3::new(s.x * s.x, s.y * s.y, s.x * s.y) }
    }

    #[test]
    fn one_sided_slopes_are_exact() {
        let s = DVec2::new(0.6, -0.9);
        for k in 0..32 {
            let v = DVec2::from_angle(0.2 * f64::from(k));
            assert!((horizon_excess(v, &ridge(s)) - s.dot(v).max(0.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn light_above_the_horizon_passes_and_below_does_not() {
        let (m, h) = (DVec2::new(0.2, 0.0), ridge(DVec2::new(1.0, 0.0)));
        let from = |tangent: f64| DVec3::new(1.0, 0.0, tangent).normalize();
        // The horizon has the tangent 1.2, and its true shape deviates by an eighth of the excess.
        assert_eq!(horizon_visibility(from(2.5), m, &h, 0.01), 1.0);
        assert_eq!(horizon_visibility(from(0.5), m, &h, 0.01), 0.0);
        assert!((horizon_visibility(from(1.2), m, &h, 0.01) - 0.5).abs() < 1e-9);
        // On the other side of the ridge, or without bumps, only the plane occludes. The function ignores this occlusion.
        assert_eq!(horizon_visibility(DVec3::new(-0.9, 0.0, 0.1), m, &h, 0.2), 1.0);
        assert_eq!(horizon_visibility(from(0.21), m, &Horizon::default(), 0.2), 1.0);
    }

    #[test]
    fn hidden_directions_agree_with_an_integral() {
        for (m, h) in [
            (DVec2::ZERO, Horizon { lean: DVec2::ZERO, spread: DVec3::new(0.5, 0.5, 0.0) }),
            (DVec2::new(0.4, -0.3), Horizon { lean: DVec2::new(0.1, 0.2), spread: DVec3::new(0.3, 0.1, 0.1) }),
            (DVec2::new(-0.8, 0.1), ridge(DVec2::new(0.5, 0.5))),
        ] {
            let (mut sum, mut angle, n) = (DVec3::ZERO, 0.0, 400);
            for i in 0..n {
                let v = DVec2::from_angle(2.0 * PI * (f64::from(i) + 0.5) / f64::from(n));
                let tangents = m.dot(v)..m.dot(v) + horizon_excess(v, &h);
                for j in 0..n {
                    let elevation = PI * ((f64::from(j) + 0.5) / f64::from(n) - 0.5);
                    if tangents.contains(&elevation.tan()) {
                        let part = elevation.cos() * 2.0 * PI / f64::from(n * n);
                        sum += (v * elevation.cos()).extend(elevation.sin()) * part;
                        angle += part;
                    }
                }
            }
            let hidden = horizon_hidden(m, &h);
            assert!((hidden.weight - sum).length() < 0.02, "{m}: {hidden:?} for {sum}");
            assert!((hidden.angle - angle).abs() < 0.02, "{m}: {hidden:?} for {angle}");
            // A white environment of radiance 1 loses the hidden fraction. A dark environment with a bright horizon keeps at least half of
            // the unhidden fraction.
            let mut c = [DVec3::ZERO; 9];
            c[0] = DVec3::splat((4.0 * PI).sqrt());
            let frame = crate::frame::frame_about(DVec3::Z);
            let left = 1.0 - hidden.weight.dot(normal_of_slope(m));
            let past = |whole: f64| diffuse_past_horizon(DVec3::splat(whole), 1.0, &hidden, m, &frame, &c).x;
            assert!((past(1.0) - left).abs() < 1e-9);
            assert!((past(0.1) - 0.05 * left).abs() < 1e-9);
        }
    }
}
