//! Specular environments with the shadows that the surface throws on itself, for rules with few probes: the slopes that are visible
//! and lit, by their moments.
//!
//! A rule with few probes puts them on a line in the space of slopes ([`super::visible_specular`]) and blurs what they fetch: each
//! stands for slopes that it does not touch. Shadowing taken at the probes misses what lies across the line and beyond its ends;
//! and what is lit is another distribution, narrower and turned to the light, than what is visible. So its mass, mean and covariance are
//! integrated on their own, and the line is laid through *it*.
//!
//! Visible slopes are `axis u + across y` about their mean, `u` along the view's azimuth and `y` normal and independent of it. For one `u` the reflections
//! that stay above the mesosurface are exactly an interval of `y`: with `N = (−slope, 1)` the reflection has the mesosurface's
//! projected area `(2 (o·N) (1 + slope·m) − a_o |N|²) / |N|²`, of which `o·N` does not depend on `y`: a concave quadratic polynomial in it. Over the
//! interval shadowing is averaged by the two points of its Gauss rule, and over `u` by the nodes of a line rule with the
//! density's exact mean, variance and skewness: twice its nodes are all evaluations there are, whatever the number of probes.

use super::correlated_masking::{Visibility, direction_area, lit_fraction};
use super::fresnel::fresnel_schlick;
use super::normal_distribution::{normal_cdf, normal_pdf};
use super::slope_grid::slope_cholesky;
use super::specular::environment_sample_at;
use super::visible_slopes::{VisibleSlopes, visible_slopes};
use super::visible_specular::{LineRule, VisibleProbe, line_of_slopes, visible_probe};
use glam::{DVec2, DVec3};

/// The slopes that are visible and lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitSlopes {
    /// The part of what is visible, 0..1: what a constant environment keeps.
    pub lit: f64,
    /// Their moments in place of those of all visible slopes.
    pub slopes: VisibleSlopes,
}

/// The interval of `y` where `a2 y² + b2 y + c2 > 0`, `a2 ≤ 0`, within ±8; empty (`x ≥ y`) if nowhere.
#[must_use]
pub fn positive_interval(a2: f64, b2: f64, c2: f64) -> DVec2 {
    let discriminant = b2 * b2 - 4.0 * a2 * c2;
    if discriminant <= 0.0 {
        // No root, or constant: the sign of c2 decides.
        return if c2 > 0.0 { DVec2::new(-8.0, 8.0) } else { DVec2::splat(8.0) };
    }
    // Both roots without cancellation; the one that a2 = 0 sends to infinity ends at ±8.
    let side = if b2 < 0.0 { -1.0 } else { 1.0 };
    let k = b2 + side * discriminant.sqrt();
    let near = (-2.0 * c2 / k).clamp(-8.0, 8.0);
    let far = if -a2 * 16.0 > k.abs() { -0.5 * k / a2 } else { 8.0 * side };
    DVec2::new(near.min(far), near.max(far))
}

/// Where next to nothing is lit, its moments tend to those of what is visible, as if so much of that were lit besides.
const FAINT: f64 = 1e-3;

/// Integrates what is lit of the visible slopes `v` from `wo`. `rule`: nodes along the view's azimuth.
#[must_use]
pub fn lit_slopes(visibility: Visibility, wo: DVec3, v: &VisibleSlopes, rule: &LineRule) -> LitSlopes {
    if visibility == Visibility::Masking {
        return LitSlopes { lit: 1.0, slopes: *v };
    }
    let cholesky = slope_cholesky(v.s);
    let o = direction_area(wo, v.m, cholesky);
    // The whitened frame whose first axis is the view's azimuth.
    let p = if o.spread > 1e-9 { o.whitened / o.spread } else { DVec2::X };
    let deviation = v.variance.sqrt();
    let skew = v.third / (6.0 * v.variance * deviation);
    let along = deviation * DVec2::new(cholesky.x * p.x, cholesky.y * p.x + cholesky.z * p.y);
    let across = DVec2::new(-cholesky.x * p.y, cholesky.z * p.x - cholesky.y * p.y);
    let ao = o.meso.max(0.0);
    let (mut lit, mut mean, mut second) = (0.0, DVec2::ZERO, DVec3::new(FAINT, FAINT, 0.0));
    for i in 0..rule.n {
        let j = f64::from(i) - 0.5 * f64::from(rule.n - 1);
        let (z, weight) = (j * rule.step, rule.norm * (-rule.decay * j * j).exp());
        let u = z + skew * (z * z - 1.0);
        let slope = v.mean + along * u;
        let facet = (v.facet - v.b * deviation * u).max(0.0);
        let interval = positive_interval(
            -ao * across.length_squared(),
            2.0 * (facet * across.dot(v.m) - ao * slope.dot(across)),
            2.0 * facet * (1.0 + slope.dot(v.m)) - ao * (1.0 + slope.length_squared()),
        );
        if interval.x >= interval.y {
            continue;
        }
        // Mass, mean and standard deviation of the normal density over it, from the side where the tail is small.
        let side = if interval.x + interval.y > 0.0 { -1.0 } else { 1.0 };
        let (low, high) = if side < 0.0 { (-interval.y, -interval.x) } else { (interval.x, interval.y) };
        let (pl, ph) = (normal_pdf(low), normal_pdf(high));
        let mass = (normal_cdf(high) - normal_cdf(low)).max(1e-6);
        let middle = ((pl - ph) / mass).clamp(low, high);
        let variance = (1.0 + (low * pl - high * ph) / mass - middle * middle).clamp(0.0, 1.0);
        let half = variance.sqrt().min(0.288_675 * (high - low));
        for y in [side * (middle - half), side * (middle + half)] {
            let wi = environment_sample_at(wo, slope + y * across).wi;
            let w = 0.5 * weight * mass * lit_fraction(visibility, &o, &direction_area(wi, v.m, cholesky));
            lit += w;
            mean += w * DVec2::new(u, y);
            second += w * DVec3::new(u * u, y * y, u * y);
        }
    }
    // Moments in u and y, then in slopes.
    let per = 1.0 / (lit + FAINT);
    let mean = mean * per;
    let cov = second * per - DVec3::new(mean.x * mean.x, mean.y * mean.y, mean.x * mean.y);
    let cov = DVec3::new(cov.x.max(0.02), cov.y.max(0.02), cov.z);
    let mut slopes = *v;
    slopes.mean += along * mean.x + across * mean.y;
    slopes.cov = cov.x * DVec3::new(along.x * along.x, along.y * along.y, along.x * along.y)
        + cov.y * DVec3::new(across.x * across.x, across.y * across.y, across.x * across.y)
        + cov.z
            * DVec3::new(2.0 * along.x * across.x, 2.0 * along.y * across.y, along.x * across.y + along.y * across.x);
    slopes.facet = (v.facet - v.b * deviation * mean.x).max(1e-6);
    slopes.variance = (cov.x * v.variance).clamp(0.02, 1.0);
    slopes.third = v.third * lit;
    LitSlopes { lit, slopes }
}

/// Radiance towards `wo` under an environment of cube edge `size`, with shadows, by the probes of `rule`. `f0`: linear RGB
/// reflectance at normal incidence; `nodes`: of the integral of what is lit. `radiance` is asked for each probe.
#[must_use]
pub fn shadowed_specular_environment(
    visibility: Visibility,
    wo: DVec3,
    m: DVec2,
    s: DVec3,
    f0: DVec3,
    size: f64,
    [rule, nodes]: [&LineRule; 2],
    radiance: impl Fn(&VisibleProbe) -> DVec3,
) -> DVec3 {
    let lit = lit_slopes(visibility, wo, &visible_slopes(wo, m, s), nodes);
    let line = line_of_slopes(&lit.slopes, wo, size, rule);
    let probes = (0..rule.n).map(|i| visible_probe(&line, wo, i, rule));
    let reflected = |probe: VisibleProbe| probe.weight * fresnel_schlick(f0, probe.cosine) * radiance(&probe);
    probes.map(reflected).fold(DVec3::ZERO, |sum, r| sum + r) * lit.lit
}
