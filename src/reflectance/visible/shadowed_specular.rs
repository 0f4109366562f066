//! Specular environments with the shadows that the surface casts on itself, for rules with few probes.
//!
//! A probe represents all directions in its solid angle `Ω`, not one. The lit fraction of a direction
//! ([`lit_fraction`]) depends on its height `a` above the mesosurface and falls to zero at the mesosurface's horizon.
//! That leaves a kink which few probes hit or miss by chance. So `a` is treated as a normal variable with the standard
//! deviation of a disc, and is averaged over the probe after clamping at 0:
//!
//! ```text
//! δ² = w Ω (1 + |m|²) / 4π      E[a⁺] = δ (t Φ + φ),   E[a⁺ a] / E[a⁺] = a + l δ Φ / (t Φ + φ)   at t = a/δ
//! ```
//!
//! The first mean determines the lit fraction. The second is the mean height of the lit part of the probe, which lies
//! higher than the probe's centre near the horizon; the environment is looked up there. Both need one exponential. `w`
//! ([`PART`]) accounts for a node representing a little more or less than its probe covers; `l` ([`LIFT`]) accounts for
//! the environment's lookup kernel being wider than a disc. Both are fitted together with the nodes.

use super::specular::{ProbeRule, VisibleProbe, visible_probe, visible_probes};
use crate::reflectance::facets::normal_distribution::normal_ramp;
use crate::reflectance::integrals::specular::{MirrorSample, Mirrors};
use crate::reflectance::masking::correlated::{DirectionArea, direction_area, lit_fraction};
use crate::reflectance::masking::shadowing::Shadowing;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// `w`: variance of the part that a node represents, in units of its probe's variance.
pub const PART: f64 = 1.231;
/// `l`: how far the lookup moves away from the horizon, in units of the lit part's own shift.
pub const LIFT: f64 = 1.809;

/// The lit part of a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitProbe {
    /// Its fraction, 0..1.
    pub lit: f64,
    /// Direction in which the environment is looked up for it, unit.
    pub wi: DVec3,
}

/// The lit part of a probe of a given solid angle around `wi`. `o`: the viewer's areas ([`direction_area`]); `m`,
/// `cholesky`: the mean slope and Cholesky factor used to compute them.
#[must_use]
pub fn lit_probe(
    shadowing: Shadowing,
    o: &DirectionArea,
    wi: DVec3,
    solid_angle: f64,
    m: DVec2,
    cholesky: DVec3,
) -> LitProbe {
    lit_probe_of([PART, LIFT], shadowing, o, wi, solid_angle, m, cholesky)
}

/// [`lit_probe`] with any `w` and `l`, for the study that fits them.
#[must_use]
pub(crate) fn lit_probe_of(
    [part, lift]: [f64; 2],
    shadowing: Shadowing,
    o: &DirectionArea,
    wi: DVec3,
    solid_angle: f64,
    m: DVec2,
    cholesky: DVec3,
) -> LitProbe {
    if shadowing == Shadowing::None {
        return LitProbe { lit: 1.0, wi };
    }
    let i = direction_area(wi, m, cholesky);
    let squared = 1.0 + m.length_squared();
    let deviation = (part / (4.0 * PI) * solid_angle * squared).clamp(1e-12, 1.0).sqrt();
    let n = normal_ramp((i.meso / deviation).max(-13.0));
    let above = deviation * n.ramp;
    let wide = DirectionArea { meso: above, visible: i.visible - i.meso.max(0.0) + above, ..i };
    let lift = lift * deviation * n.cdf / n.ramp / squared;
    LitProbe { lit: lit_fraction(shadowing, o, &wide), wi: (wi + DVec3::new(-m.x, -m.y, 1.0) * lift).normalize() }
}

/// Radiance towards `wo` under an environment, and the mean Fresnel reflectance of the visible facets, from the probes
/// of `rule`. `f0`: linear RGB reflectance at normal incidence. `radiance` is called for each probe.
#[must_use]
pub fn visible_specular_environment(
    shadowing: Shadowing,
    wo: DVec3,
    m: DVec2,
    s: DVec3,
    f0: DVec3,
    rule: ProbeRule<'_>,
    radiance: impl Fn(&VisibleProbe) -> DVec3,
) -> Mirrors {
    let probes = visible_probes(wo, m, s);
    let o = direction_area(wo, probes.m, probes.cholesky);
    let samples = rule.nodes(probes.wide).map(|node| {
        let probe = visible_probe(&probes, wo, &node);
        let LitProbe { lit, wi } = lit_probe(shadowing, &o, probe.wi, probe.solid_angle, probes.m, probes.cholesky);
        MirrorSample { weight: probe.weight, cosine: probe.cosine, lit, lookup: VisibleProbe { wi, ..probe } }
    });
    // The weights of a rule sum to one.
    Mirrors::sum(f0, samples, radiance)
}
