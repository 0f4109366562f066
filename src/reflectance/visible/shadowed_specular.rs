//! Specular environments with the shadows that the surface casts on itself, for rules with few probes.
//!
//! A probe represents a part of the lobe, not one direction, and the lit fraction of a direction ([`lit_fraction`])
//! depends on its height above the mesosurface: it is concave, and falls to zero at the mesosurface's horizon. So the
//! part of the lobe, of variance `v`, is taken apart once more, into two directions: one deviation up and one down. With
//! the height as `x = cos θ` and `tan² δ = v`,
//!
//! ```text
//! x± = x cos² δ ± sin θ sin δ
//! ```
//!
//! (the second `cos δ` is what the width to the sides costs). The mean of the lit fractions there, weighted by
//! Schlick's term (what grazes is both brighter and more often hidden), is the probe's, and their difference, `bias = (lit₊ − lit₋)/(lit₊ + lit₋)`, tells where the lit part lies: the environment is looked up
//! in the direction tilted by `bias sin δ`, and the kernel's variance shrinks by half the share `bias²` that the tilt has of
//! the variance along it. `v` is the kernel's variance where lobes are narrow. Kernels of wide lobes overlap so much that a
//! node stands for less than its kernel.

use super::specular::{ProbeRule, VisibleProbe, visible_probe, visible_probes};
use crate::reflectance::integrals::specular::{MirrorSample, Mirrors};
use crate::reflectance::masking::correlated::{DirectionArea, direction_area, lit_fraction};
use crate::reflectance::masking::shadowing::Shadowing;
use glam::{DVec2, DVec3};

/// The lit part of a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitProbe {
    /// Its fraction, 0..1.
    pub lit: f64,
    /// Direction in which the environment is looked up for it, unit.
    pub wi: DVec3,
    /// Factor of that lookup's variance, 0.5..1.
    pub narrowing: f64,
}

/// The lit part of a probe around `wi` that stands for light of this variance; its two directions weigh by Schlick's term of `f0`. `o`: the viewer's areas ([`direction_area`]); `m`,
/// `cholesky`: the mean slope and Cholesky factor used to compute them.
#[must_use]
pub fn lit_probe(
    shadowing: Shadowing,
    o: &DirectionArea,
    wo: DVec3,
    f0: f64,
    wi: DVec3,
    variance: f64,
    m: DVec2,
    cholesky: DVec3,
) -> LitProbe {
    if shadowing == Shadowing::None {
        return LitProbe { lit: 1.0, wi, narrowing: 1.0 };
    }
    let up = DVec3::new(-m.x, -m.y, 1.0) / (1.0 + m.length_squared()).sqrt();
    let height = up.dot(wi);
    let side = (1.0 - height * height).max(0.0).sqrt();
    let per_side = 1.0 / side.max(1e-4);
    let cosine2 = 1.0 / (1.0 + variance);
    let sine = (variance * cosine2).sqrt();
    let lit_at = |sign: f64| {
        let h = height * cosine2 + sign * side * sine;
        let w = up * h + (wi - up * height) * (per_side * (1.0 - h * h).max(0.0).sqrt());
        let cosine = (0.5 + 0.5 * wo.dot(w)).clamp(0.0, 1.0).sqrt();
        let fresnel = f0 + (1.0 - f0) * (1.0 - cosine).powi(5);
        (fresnel, fresnel * lit_fraction(shadowing, o, &direction_area(w, m, cholesky)))
    };
    let [(f_high, high), (f_low, low)] = [1.0, -1.0].map(lit_at);
    let lit = (high + low) / (f_high + f_low).max(1e-6);
    let bias = (high - low) / (high + low).max(1e-6);
    LitProbe {
        lit,
        wi: (wi * cosine2.sqrt() + (up - wi * height) * (per_side * bias * sine)).normalize(),
        narrowing: 1.0 - 0.5 * bias * bias,
    }
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
    let probes = visible_probes(wo, m, s, rule.kernel);
    let o = direction_area(wo, probes.m, probes.cholesky);
    let samples = rule.nodes(probes.wide).map(|node| {
        let probe = visible_probe(&probes, wo, &node);
        let LitProbe { lit, wi, narrowing } =
            lit_probe(shadowing, &o, wo, f0.element_sum() / 3.0, probe.wi, probe.variance, probes.m, probes.cholesky);
        let lookup = VisibleProbe { wi, variance: narrowing * probe.variance, ..probe };
        MirrorSample { weight: probe.weight, cosine: probe.cosine, lit, lookup }
    });
    // The weights of a rule sum to one.
    Mirrors::sum(f0, samples, radiance)
}
