//! Environments with the shadows that the surface throws on itself, without sampling them away.
//!
//! # Diffuse: one irradiance lookup
//!
//! Two exact facts carry it.
//!
//! 1. Over the whole surface nothing is lost: what enters through the mesosurface falls on some facet. So the irradiance that all
//!    facets together receive under any environment is that of the flat mesosurface, one clamped cosine; and shadowed diffuse
//!    reflection is nearly an occlusion times one clamped cosine about a bent normal.
//! 2. The mean slope of what the viewer sees has a closed form (Stein's lemma for the clamped facet areas):
//!
//!    ```text
//!    E_visible[slope] = m + Δ,   Δ = −S o.xy Φ(a/b) / A
//!    ```
//!
//! From them, with fitted constants (`docs/shadowing.md`), the occlusion `a₀` and the bent normal along `(−(m + c Δ), 1)`:
//!
//! ```text
//! q = 1 + |m|²,  τ = ½ tr S / q,  δ = √det S / q,  G₁ = a/A,  μ² = a²/q
//! x  = 1.10 τ / (1 + 0.89 √(τ + 1.2 (τ − δ)))
//! a₀ = 1 − x/(1+x) (0.67 + 0.33 G₁) + 0.19 Δ·m/q              within 0..1
//! c  = 0.67 (1 + 0.6 (1 − μ²)) / (1 + 1.2 √τ)
//! ```
//!
//! Blocked light is black: what shadowed facets get from each other is not part of it.
//!
//! # Specular: the lit part of a probe
//!
//! A rule with few probes puts them on a line in the space of slopes; each stands for all slopes across the line as well. Those
//! whose reflection stays above the mesosurface are an interval of the coordinate across, exactly: the reflection of `o` by the
//! facet of slope `x`, `N = (−x, 1)`, has the mesosurface area `2 (o·N)(1 + x·m) − a_o |N|²` times `|N|⁻²`, a quadratic
//! polynomial in it. The shadowing of a probe is a mean over that interval, by the two points of its Gauss rule.

use super::correlated_masking::{DirectionArea, Visibility, direction_area, lit_fraction};
use super::frame::{Frame, from_frame};
use super::normal_distribution::{mills_ratio, normal_cdf, normal_pdf, tail_mean_ratio};
use super::sh::{Sh9, sh_irradiance};
use super::slope_grid::normal_of_slope;
use super::specular::environment_sample_at;
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::PI;

/// `Φ(t) / (t Φ(t) + φ(t))`: how far, in standard deviations, what is visible tilts towards the viewer. Tends to `1/t` and to
/// `−t` at the two ends. Arguments below −13 count as that, where all of the visible area is 1e-40.
#[must_use]
pub fn visible_tilt(t: f64) -> f64 {
    if t >= 0.0 {
        let cdf = normal_cdf(t);
        return cdf / (t * cdf + normal_pdf(t));
    }
    mills_ratio(-t.max(-13.0)) / tail_mean_ratio(-t.max(-13.0))
}

/// `Δ`: mean slope of what the viewer sees, minus the mean slope. Exact. Held within ±1e3, beyond which only the surface behind is seen.
#[must_use]
pub fn visible_slope_shift(o: &DirectionArea, cholesky: DVec3) -> DVec2 {
    let tilt = visible_tilt((o.meso / o.spread.max(1e-12)).clamp(-1e6, 1e6));
    let along = o.whitened * (-tilt / o.spread.max(1e-12));
    DVec2::new(cholesky.x * along.x, cholesky.y * along.x + cholesky.z * along.y)
        .clamp(DVec2::splat(-1e3), DVec2::splat(1e3))
}

/// What a shadowed diffuse surface shows of an environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BentNormal {
    /// Unit normal for which to look the irradiance up; tangent frame.
    pub normal: DVec3,
    /// `a₀`: factor of that irradiance, 0..1.
    pub open: f64,
}

/// Bent normal and occlusion of a surface of mean slope `m` and covariance `C Cᵀ` seen from `o` (its [`direction_area`]).
#[must_use]
pub fn bent_normal(o: &DirectionArea, m: DVec2, cholesky: DVec3) -> BentNormal {
    let iq = 1.0 / (1.0 + m.length_squared());
    let tau = 0.5 * iq * cholesky.length_squared();
    let det = iq * cholesky.x * cholesky.z;
    let ao = o.meso.max(0.0);
    let g1 = ao / o.visible.max(1e-30);
    let shift = visible_slope_shift(o, cholesky);
    let x = 1.10 * tau / (1.0 + 0.89 * (tau + 1.2 * (tau - det).max(0.0)).sqrt());
    let open = 1.0 - x / (1.0 + x) * (0.67 + 0.33 * g1) + 0.19 * shift.dot(m) * iq;
    let bend = 0.67 * (1.0 + 0.6 * (1.0 - ao * ao * iq)) / (1.0 + 1.2 * tau.sqrt());
    BentNormal { normal: normal_of_slope(m + bend * shift), open: open.clamp(0.0, 1.0) }
}

/// Diffuse radiance under an environment, with shadows, per unit of albedo. `c`: radiance coefficients in the world; `f`: the tangent
/// frame in the world. Not below 0.
#[must_use]
pub fn shadowed_diffuse_environment(v: &BentNormal, f: &Frame, c: &Sh9) -> DVec3 {
    sh_irradiance(c, from_frame(f, v.normal)).max(DVec3::ZERO) * (v.open / PI)
}

/// The interval of `y` where `a2 y² + b2 y + c2 > 0`, within ±8; empty (`low ≥ high`) if nowhere. Of a parabola that opens upwards its tangent
/// line at 0.
#[must_use]
pub fn positive_interval(a2: f64, b2: f64, c2: f64) -> DVec2 {
    let a2 = a2.min(0.0);
    let discriminant = b2 * b2 - 4.0 * a2 * c2;
    if discriminant <= 0.0 {
        // Constant: the sign of c2 decides.
        return if c2 > 0.0 { DVec2::new(-8.0, 8.0) } else { DVec2::splat(8.0) };
    }
    // Both roots without cancellation; the one that a2 = 0 sends to infinity ends at ±8.
    let side = if b2 < 0.0 { -1.0 } else { 1.0 };
    let k = b2 + side * discriminant.sqrt();
    let near = (-2.0 * c2 / k).clamp(-8.0, 8.0);
    let far = if -a2 * 16.0 > k.abs() { -0.5 * k / a2 } else { 8.0 * side };
    DVec2::new(near.min(far), near.max(far))
}

/// Part of a probe that the environment reaches, 0..1: a factor of its weight in a sum that is normalised for masking. The probe at
/// `slope` stands for all slopes `slope + y across`, `y ~ N(0, 1)`; `across` 0: for itself alone.
///
/// Where a rule's probes are blurred, and moved together for it, this wants the slopes that they stand for: spread over the full extent
/// of what is visible. The radiance is fetched where the rule has its probe.
#[must_use]
pub fn lit_probe(
    visibility: Visibility,
    o: &DirectionArea,
    wo: DVec3,
    slope: DVec2,
    across: DVec2,
    m: DVec2,
    cholesky: DVec3,
) -> f64 {
    if visibility == Visibility::Masking {
        return 1.0;
    }
    // (o·N)(y) = v + dv y and 1 + x·m = k + dk y.
    let (v, dv) = (wo.z - wo.xy().dot(slope), -wo.xy().dot(across));
    let (k, dk) = (1.0 + slope.dot(m), across.dot(m));
    let ao = o.meso.max(0.0);
    let interval = positive_interval(
        2.0 * dv * dk - ao * across.length_squared(),
        2.0 * (v * dk + dv * k - ao * slope.dot(across)),
        2.0 * v * k - ao * (1.0 + slope.length_squared()),
    );
    if interval.x >= interval.y {
        return 0.0;
    }
    // Mass, mean and standard deviation of the normal density over it, from the side where the tail is small.
    let side = if interval.x + interval.y > 0.0 { -1.0 } else { 1.0 };
    let (low, high) = if side < 0.0 { (-interval.y, -interval.x) } else { (interval.x, interval.y) };
    let (pl, ph) = (normal_pdf(low), normal_pdf(high));
    let mass = (normal_cdf(high) - normal_cdf(low)).max(1e-6);
    let mean = ((pl - ph) / mass).clamp(low, high);
    let variance = (1.0 + (low * pl - high * ph) / mass - mean * mean).clamp(0.0, 1.0);
    let sd = variance.sqrt().min(0.288_675 * (high - low));
    let lit = [mean - sd, mean + sd].map(|y| {
        let wi = environment_sample_at(wo, slope + side * y * across).wi;
        lit_fraction(visibility, o, &direction_area(wi, m, cholesky))
    });
    0.5 * mass * (lit[0] + lit[1])
}
