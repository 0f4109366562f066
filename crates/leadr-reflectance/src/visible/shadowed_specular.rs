//! The specular reflection of environments with self-shadowing of the surface, for rules with few probes.
//!
//! Probes sample the slopes that reflect lit directions ([`lit_slopes`](super::lit_slopes)), and are weighted by their share of all visible
//! facets. A probe represents part of the lobe, not one direction. The lit fraction of a direction ([`lit_fraction`]) depends on its height
//! above the mesosurface. The fraction is concave in the height, and falls to zero at the mesosurface's horizon, where shares are largest.
//! Each probe is therefore split into two directions, one standard deviation above and below its facet's reflection. The variance `v` of
//! the split is a fraction of the probe's variance ([`lit_spread`](super::specular::VisibleProbes::lit_spread)). With the height
//! `x = cos θ` and `tan² δ = v`, the two heights are
//!
//! ```text
//! x± = x cos² δ ± sin θ sin δ
//! ```
//!
//! The second factor `cos δ` accounts for the width to the sides. Each direction has its own lit fraction, share and Fresnel term, because
//! grazing directions are both brighter and more often hidden. The probe uses the mean of the two products of these factors. The relative
//! difference of the products, `bias = (lit₊ − lit₋)/(lit₊ + lit₋)`, locates the lit part of the probe, so the lookup direction is tilted
//! by `bias sin δ`. The tilt accounts for the fraction `bias²` of the variance along the tilt, so the kernel's variance shrinks by half of
//! this fraction. Bumps larger than the pixel occlude each of the two directions by its height above the bumps' horizon
//! ([`horizon_visibility`]). A single value for both directions would make a lobe that is cut by a horizon too bright.
//!
//! A lookup has a round kernel, which would reach light from below the mesosurface. No facet reflects this light, so the kernel near the
//! horizon is narrower: its standard deviation is at most half the height of the lookup direction.

use super::horizon::{Horizon, horizon_visibility, raised_horizon};
use super::lit_slopes::lit_share;
use super::specular::{ProbeRule, VisibleProbe, VisibleProbes, visible_probe, visible_probes};
use crate::facets::fresnel::{grazing_reflectance, schlick_weight};
use crate::integrals::specular::SpecularTerm;
use crate::masking::correlated::{DirectionArea, direction_area, lit_fraction};
use crate::masking::shadowing::Shadowing;
use glam::{DVec2, DVec3, Vec3Swizzles as _};

/// The excess of the horizon for specular facets, relative to its excess for the whole surface. Visible specular facets reflect lower
/// directions than average facets do. At low directions, the true horizon is jagged and hides more. The factor is fitted to images
/// (`docs/theory.md`, section 10).
pub const SPECULAR_HORIZON: f64 = 1.2;

/// The largest logarithm of a share. Only directions near the horizon, where nothing is lit, approach this bound.
const MOST_SHARE: f64 = 4.0;

/// The standard deviation of the part of the lobe around each of a probe's two directions, relative to the standard deviation of the probe.
const HALF_DEVIATION: f64 = 0.5;

/// The smallest distance of the horizon of the mesosurface from the lookup direction, in standard deviations of the kernel. It minimises
/// the error of flat planes under panoramas.
pub const HORIZON_DEVIATIONS: f64 = 2.0;

/// The smallest factor of the lookup variance.
pub const NARROWEST: f64 = 0.1;

/// The lit part of a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitProbe {
    /// The lit fraction times the probe's share of the visible facets. This product scales the probe's weight.
    pub lit: f64,
    /// The same product times Schlick's weight, without the reflectance at normal incidence.
    pub grazing: f64,
    /// The unit lookup direction in the environment.
    pub wi: DVec3,
    /// The factor of the lookup variance, from 0.1 to 1.
    pub narrowing: f64,
}

/// Returns the lit part of a probe. `o` has the viewer's areas ([`direction_area`]) for `probes.m` and `probes.cholesky`. `f0` is the mean
/// reflectance at normal incidence, which weights the two directions. `horizon` is the horizon of bumps larger than the pixel.
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
    let horizon = horizon.map(|h| raised_horizon(h, SPECULAR_HORIZON));
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
    let wi = tilted / tilted.length_squared().max(1e-12).sqrt();
    let widest = up.dot(wi).max(0.0) / HORIZON_DEVIATIONS;
    LitProbe {
        lit: 0.5 * (high.x + low.x),
        grazing: 0.5 * (high.y + low.y),
        wi,
        narrowing: (widest * widest / p.variance.max(1e-12)).min(1.0 - 0.5 * bias * bias).max(NARROWEST),
    }
}

/// Returns the radiance towards `wo` under an environment, and the mean Fresnel reflectance of the visible facets, from the probes of
/// `rule`. `f0` is the linear RGB reflectance at normal incidence. `radiance` is called for each probe.
pub fn visible_specular_environment(
    shadowing: Shadowing,
    wo: DVec3,
    m: DVec2,
    s: DVec3,
    f0: DVec3,
    rule: ProbeRule<'_>,
    radiance: impl Fn(&VisibleProbe) -> DVec3,
) -> SpecularTerm {
    let probes = visible_probes(shadowing, wo, m, s, rule.kernel);
    let o = direction_area(wo, probes.m, probes.cholesky);
    let rise = grazing_reflectance(f0) - f0;
    let (mut at_normal, mut by_angle, mut lit, mut grazing) = (DVec3::ZERO, DVec3::ZERO, 0.0, 0.0);
    for node in rule.nodes(probes.wide) {
        let p = visible_probe(&probes, wo, &node);
        let l = lit_probe(shadowing, &probes, &o, wo, f0.element_sum() / 3.0, &p, None);
        let light = p.weight * radiance(&VisibleProbe { wi: l.wi, variance: l.narrowing * p.variance, ..p });
        at_normal += l.lit * light;
        by_angle += l.grazing * light;
        lit += p.weight * l.lit;
        grazing += p.weight * schlick_weight(p.cosine);
    }
    // Without shadows, the specular and the diffuse term share the exact mean of Schlick's weight.
    let exact = if shadowing == Shadowing::None { probes.grazing / grazing.max(1e-9) } else { 1.0 };
    let reflected = f0 * at_normal + exact * rise * by_angle;
    // The weights of a rule sum to one. With approximate shares the sum may exceed one, but it must not add energy.
    SpecularTerm { reflected: reflected / lit.max(1.0), fresnel: f0 + rise * probes.grazing, weight: 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::normal_distribution::normal_cdf;
    use crate::visible::specular::probe_rule;

    /// A flat plane seen from above reflects no light from below its horizon.
    #[test]
    fn lookups_reach_little_light_from_below() {
        for degrees in [20.0f64, 45.0, 60.0, 75.0] {
            let (y, z) = degrees.to_radians().sin_cos();
            for alpha in [0.2f64, 0.35, 0.6] {
                let s = DVec3::new(0.5, 0.5, 0.0) * alpha * alpha;
                let reflected = |radiance: &dyn Fn(&VisibleProbe) -> f64| {
                    let f0 = DVec3::splat(0.04);
                    let lookup = |p: &VisibleProbe| DVec3::splat(radiance(p));
                    let wo = DVec3::new(0.0, y, z);
                    let (shadowing, rule) = (Shadowing::Correlated, probe_rule(16));
                    visible_specular_environment(shadowing, wo, DVec2::ZERO, s, f0, rule, lookup).reflected.x
                };
                // The radiance is 1 below the horizon and 0 above it.
                let below = reflected(&|p| normal_cdf(-p.wi.z.asin() / p.variance.sqrt()));
                let share = below / reflected(&|_| 1.0);
                assert!(share < 0.015, "{degrees} degrees, alpha {alpha}: {share}");
            }
        }
    }
}
