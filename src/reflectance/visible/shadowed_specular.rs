//! Specular environments with the shadows that the surface throws on itself, for rules with few probes.
//!
//! A probe stands for all directions of its solid angle `Ω`, not for one. What is lit of them
//! ([`lit_fraction`]) is governed by their height `a` above the mesosurface, and falls
//! to nothing at its horizon: a corner that few probes miss or hit by chance. So `a` counts as a normal variable, of the
//! deviation that a disc has, and is averaged over the probe before it is cut at 0:
//!
//! ```text
//! δ² = w Ω (1 + |m|²) / 4π      E[a⁺] = δ (t Φ + φ),   E[a⁺ a] / E[a⁺] = a + l δ Φ / (t Φ + φ)   at t = a/δ
//! ```
//!
//! The first is what decides on the light; the second is how high, near the horizon, the lit part of the probe lies in the
//! mean, and there the environment is looked up. Both need one exponential. `w` ([`PART`]): a node stands for a little more or
//! less than its probe covers; `l` ([`LIFT`]): the environment is looked up with a kernel that is wider than a disc. Both are fitted
//! with the nodes.

use super::specular::{ProbeRule, VisibleProbe, visible_probe, visible_probes};
use crate::reflectance::facets::normal_distribution::normal_ramp;
use crate::reflectance::integrals::specular::{MirrorSample, Mirrors};
use crate::reflectance::masking::correlated::{DirectionArea, direction_area, lit_fraction};
use crate::reflectance::masking::shadowing::Shadowing;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// `w`: variance of the part that a node stands for, in units of its probe's.
pub const PART: f64 = 1.231;
/// `l`: how far the lookup moves away from the horizon, in units of that part's own shift.
pub const LIFT: f64 = 1.809;

/// What is lit of a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitProbe {
    /// Its part, 0..1.
    pub lit: f64,
    /// Where the environment is looked up for it, unit.
    pub wi: DVec3,
}

/// What is lit of the light of a solid angle about `wi`. `o`: the viewer's areas
/// ([`direction_area`]); `m`, `cholesky`: mean slope and Cholesky factor that these are of.
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

/// Radiance towards `wo` under an environment, and the mean Fresnel reflectance of the visible facets, by the probes of
/// `rule`. `f0`: linear RGB reflectance at normal incidence. `radiance` is asked for each probe.
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
