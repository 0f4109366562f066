//! Specular environments with the shadows that the surface casts on itself, for rules with few probes.
//!
//! Probes are placed for the slopes that mirror lit directions ([`lit_slopes`](super::lit_slopes)), and each counts by the share that it has of all visible
//! facets. It represents a part of the lobe, not one direction, and the lit fraction of a direction
//! ([`lit_fraction`]) depends on its height above the mesosurface: it is concave, and falls to zero at the mesosurface's horizon, where
//! shares are largest. So the part of the lobe is taken apart once more, into two directions: one deviation up from what its facet
//! mirrors and one down, where the variance `v` is a share of the part's ([`lit_spread`](super::specular::VisibleProbes::lit_spread)). With the height as `x = cos θ` and `tan² δ = v`,
//!
//! ```text
//! x± = x cos² δ ± sin θ sin δ
//! ```
//!
//! (the second `cos δ` is what the width to the sides costs). Each has its own lit fraction, share and Fresnel term: what
//! grazes is both brighter and more often hidden. The mean of their products is the probe's, and their difference,
//! `bias = (lit₊ − lit₋)/(lit₊ + lit₋)`, tells where the lit part lies: the environment is looked up in the direction
//! tilted by `bias sin δ`, and the kernel's variance shrinks by half the share `bias²` that the tilt has of the variance
//! along it. Bumps larger than the pixel hide the two directions in the same way, each by its own height over their horizon
//! ([`horizon_visibility`]); for the whole probe at once, a lobe that is cut by a horizon would be too bright.

use super::horizon::{Horizon, horizon_visibility, raised_horizon};
use super::lit_slopes::lit_share;
use super::specular::{ProbeRule, VisibleProbe, VisibleProbes, visible_probe, visible_probes};
use crate::facets::fresnel::{grazing_reflectance, schlick_weight};
use crate::integrals::specular::Mirrors;
use crate::masking::correlated::{DirectionArea, direction_area, lit_fraction};
use crate::masking::shadowing::Shadowing;
use glam::{DVec2, DVec3, Vec3Swizzles as _};

/// Excess of the horizon before mirrors over that before the whole surface. Those that the viewer sees reflect lower parts of the
/// surroundings than its facets do on average, where the true horizon is jagged and hides more. Fitted to pictures
/// (`docs/theory.md`, section 10).
pub const MIRROR_HORIZON: f64 = 1.2;

/// Largest logarithm of a share. Only directions next to the horizon, where nothing is lit, come near it.
const MOST_SHARE: f64 = 4.0;

/// Part of the deviation of a probe's light that is left to each of the two directions that it is taken apart into.
const HALF_DEVIATION: f64 = 0.5;

/// The lit part of a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitProbe {
    /// Its fraction, times its share of the visible facets in place of the probe's weight.
    pub lit: f64,
    /// The same weighted by Schlick's term, without the reflectance at normal incidence.
    pub grazing: f64,
    /// Direction in which the environment is looked up for it, unit.
    pub wi: DVec3,
    /// Factor of that lookup's variance, 0.5..1.
    pub narrowing: f64,
}

/// The lit part of a probe. `o`: the viewer's areas ([`direction_area`]) of `probes.m` and `probes.cholesky`; `f0`: mean
/// reflectance at normal incidence, which weighs the two directions' lookup; `horizon`: of bumps larger than the pixel.
pub fn lit_probe(
    shadowing: Shadowing,
    probes: &VisibleProbes,
    o: &DirectionArea,
    wo: DVec3,
    f0: f64,
    p: &VisibleProbe,
    horizon: Option<&Horizon>,
) -> LitProbe {
    if shadowing == Shadowing::None && horizon.is_none() {
        return LitProbe { lit: 1.0, grazing: schlick_weight(p.cosine), wi: p.wi, narrowing: 1.0 };
    }
    let horizon = horizon.map(|h| raised_horizon(h, MIRROR_HORIZON));
    let m = probes.m;
    let up = DVec3::new(-m.x, -m.y, 1.0) / (1.0 + m.length_squared()).sqrt();
    let height = up.dot(p.mirror);
    let side = (1.0 - height * height).max(0.0).sqrt();
    let per_side = 1.0 / side.max(1e-4);
    let spread = probes.lit_spread * p.variance;
    let cosine2 = 1.0 / (1.0 + spread);
    let sine = (spread * cosine2).sqrt();
    let deviation = HALF_DEVIATION * p.variance.sqrt();
    let lit_at = |sign: f64| {
        let h = height * cosine2 + sign * side * sine;
        let w = up * h + (p.mirror - up * height) * (per_side * (1.0 - h * h).max(0.0).sqrt());
        let half = wo + w;
        let share = lit_share(&probes.lit, half.xy() / -half.z.max(1e-4) - m);
        let lit = lit_fraction(shadowing, o, &direction_area(w, m, probes.cholesky))
            * horizon.map_or(1.0, |horizon| horizon_visibility(w, m, &horizon, deviation))
            * (probes.lit.mean + share).min(MOST_SHARE).exp();
        DVec2::new(lit, lit * schlick_weight((0.5 + 0.5 * wo.dot(w)).max(0.0).sqrt()))
    };
    let (high, low) = (lit_at(1.0), lit_at(-1.0));
    let fresnel = |lit: DVec2| f0 * lit.x + (1.0 - f0) * lit.y;
    let (above, below) = (fresnel(high), fresnel(low));
    let bias = (above - below) / (above + below).max(1e-6);
    let rise = up - p.wi * up.dot(p.wi);
    let tilt = bias * p.variance.sqrt() / rise.length_squared().max(1e-8).sqrt();
    let tilted = p.wi + tilt * rise;
    LitProbe {
        lit: 0.5 * (high.x + low.x),
        grazing: 0.5 * (high.y + low.y),
        wi: tilted / tilted.length_squared().max(1e-12).sqrt(),
        narrowing: 1.0 - 0.5 * bias * bias,
    }
}

/// Radiance towards `wo` under an environment, and the mean Fresnel reflectance of the visible facets, from the probes
/// of `rule`. `f0`: linear RGB reflectance at normal incidence. `radiance` is called for each probe.
pub fn visible_specular_environment(
    shadowing: Shadowing,
    wo: DVec3,
    m: DVec2,
    s: DVec3,
    f0: DVec3,
    rule: ProbeRule<'_>,
    radiance: impl Fn(&VisibleProbe) -> DVec3,
) -> Mirrors {
    let probes = visible_probes(shadowing, wo, m, s, rule.kernel);
    let o = direction_area(wo, probes.m, probes.cholesky);
    let rise = grazing_reflectance(f0) - f0;
    let (mut sum, mut lit) = (Mirrors::default(), 0.0);
    for node in rule.nodes(probes.wide) {
        let p = visible_probe(&probes, wo, &node);
        let l = lit_probe(shadowing, &probes, &o, wo, f0.element_sum() / 3.0, &p, None);
        let lookup = VisibleProbe { wi: l.wi, variance: l.narrowing * p.variance, ..p };
        sum.reflected += p.weight * (f0 * l.lit + rise * l.grazing) * radiance(&lookup);
        sum.fresnel += p.weight * (f0 + rise * schlick_weight(p.cosine));
        sum.weight += p.weight;
        lit += p.weight * l.lit;
    }
    // The weights of a rule sum to one. Shares of lit probes do so but for errors, which must not add energy.
    sum.reflected /= lit.max(1.0);
    sum
}
