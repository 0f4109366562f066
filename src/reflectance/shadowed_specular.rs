//! Specular environments with the shadows that the surface throws on itself, for rules with few probes.
//!
//! A rule with few probes puts them on a line in the space of slopes ([`super::visible_specular`]) and blurs what they fetch, so that
//! each stands for slopes that it does not touch: shadowing taken at the probes themselves misses all that lies across the line and
//! beyond its ends. Here what is lit is integrated on its own, over all visible slopes, and then handed to the probes as a function of the position along their line.
//!
//! Visible slopes are `m + axis u + across y` with `u` along the view's azimuth and `y` normal and independent of it. For one `u` the reflections
//! that stay above the mesosurface are exactly an interval of `y`: with `N = (−slope, 1)` the reflection has the mesosurface's projected area
//! `(2 (o·N) (1 + slope·m) − a_o |N|²) / |N|²`, of which `o·N = a − b u` does not depend on `y`: a concave quadratic polynomial in it. In
//! that interval the shadowing is averaged by the two points of its Gauss rule, and over `u` by the nodes of a line rule with the density's exact mean, variance and skewness. Twice its
//! nodes are all evaluations there are, whatever the number of probes.
//!
//! The three means `E[lit]`, `E[lit z]`, `E[lit (z² − 1)]/2`, with `z` the standard normal coordinate along the probes' line, make the parabola
//! `lit(z)` that is nearest to the true dependence under the density of `z`. The sum over probes is scaled so that a constant
//! environment gets `E[lit]`, whatever the probes.

use super::correlated_masking::{DirectionArea, Visibility, direction_area, lit_fraction};
use super::normal_distribution::{normal_cdf, normal_pdf};
use super::slope_grid::slope_cholesky;
use super::specular::environment_sample_at;
use super::visible_slopes::{VisibleSlopes, visible_slopes};
use super::visible_specular::{LineRule, VisibleProbe, visible_line, visible_probe};
use glam::{DVec2, DVec3, Vec3Swizzles as _};

/// What is lit of the visible slopes, by the standard normal coordinate `z` along a line through them:
/// `mean + slope z + curve (z² − 1)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitLine {
    /// `E[lit]`, 0..1: what a constant environment keeps.
    pub mean: f64,
    /// `E[lit z]`.
    pub slope: f64,
    /// `E[lit (z² − 1)] / 2`.
    pub curve: f64,
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

/// Integrates what is lit. `v`: the visible slopes; `o`: [`direction_area`] of the viewer for their `v.m` and `cholesky`
/// (of `v.s`); `major`: direction of the probes' line, in slopes, of any length; `rule`: nodes along the view's azimuth.
#[must_use]
pub fn lit_line(
    visibility: Visibility,
    o: &DirectionArea,
    wo: DVec3,
    v: &VisibleSlopes,
    major: DVec2,
    cholesky: DVec3,
    rule: &LineRule,
) -> LitLine {
    if visibility == Visibility::Masking {
        return LitLine { mean: 1.0, slope: 0.0, curve: 0.0 };
    }
    // The whitened frame whose first axis is the view's azimuth.
    let p = if o.spread > 1e-9 { o.whitened / o.spread } else { DVec2::X };
    let to_slope = |q: DVec2| DVec2::new(cholesky.x * q.x, cholesky.y * q.x + cholesky.z * q.y);
    let (axis, across) = (to_slope(p), to_slope(DVec2::new(-p.y, p.x)));
    let deviation = v.variance.sqrt();
    let skew = v.third / (6.0 * v.variance * deviation);
    // The line in coordinates of unit variance along both.
    let x = major.x / cholesky.x.max(1e-9);
    let q = DVec2::new(x, (major.y - cholesky.y * x) / cholesky.z.max(1e-9));
    let line = DVec2::new(p.dot(q) / deviation, p.x * q.y - p.y * q.x).try_normalize().unwrap_or(DVec2::X);
    let ao = o.meso.max(0.0);
    let mut sum = DVec3::ZERO;
    for i in 0..rule.n {
        let j = f64::from(i) - 0.5 * f64::from(rule.n - 1);
        let (z, weight) = (j * rule.step, rule.norm * (-rule.decay * j * j).exp());
        let u = z + skew * (z * z - 1.0);
        let slope = v.mean + axis * (deviation * u);
        let facet = (wo.z - wo.xy().dot(slope)).max(0.0);
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
        let mean = ((pl - ph) / mass).clamp(low, high);
        let variance = (1.0 + (low * pl - high * ph) / mass - mean * mean).clamp(0.0, 1.0);
        let half = variance.sqrt().min(0.288_675 * (high - low));
        for y in [side * (mean - half), side * (mean + half)] {
            let wi = environment_sample_at(wo, slope + y * across).wi;
            let lit = 0.5 * weight * mass * lit_fraction(visibility, o, &direction_area(wi, v.m, cholesky));
            let z = line.dot(DVec2::new(u, y));
            sum += lit * DVec3::new(1.0, z, 0.5 * (z * z - 1.0));
        }
    }
    LitLine { mean: sum.x, slope: sum.y, curve: sum.z }
}

/// What is lit at `z` standard deviations along the line, ≥ 0: a factor of a probe's weight. A sum over probes is to be multiplied by
/// [`lit_scale`] of the sum of their lit weights.
#[must_use]
pub fn lit_along(line: &LitLine, z: f64) -> f64 {
    (line.mean + line.slope * z + line.curve * (z * z - 1.0)).max(0.0)
}

/// Factor, 0..1, that brings probes of total lit weight `sum` to [`LitLine::mean`].
#[must_use]
pub fn lit_scale(line: &LitLine, sum: f64) -> f64 {
    line.mean / sum.max(1e-6)
}

/// Radiance of ideal mirrors towards `wo` under an environment of cube edge `size`, with shadows, by the probes of `rule`. `nodes`: of the
/// integral of what is lit. `radiance` is asked for each probe.
#[must_use]
pub fn shadowed_specular_environment(
    visibility: Visibility,
    wo: DVec3,
    m: DVec2,
    s: DVec3,
    size: f64,
    rule: &LineRule,
    nodes: &LineRule,
    radiance: impl Fn(&VisibleProbe) -> DVec3,
) -> DVec3 {
    let v = visible_slopes(wo, m, s);
    let cholesky = slope_cholesky(v.s);
    let line = visible_line(wo, m, s, size, rule);
    let lit = lit_line(visibility, &direction_area(wo, v.m, cholesky), wo, &v, line.major, cholesky, nodes);
    let (mut sum, mut lit_weight) = (DVec3::ZERO, 0.0);
    for i in 0..rule.n {
        let probe = visible_probe(&line, wo, i, rule);
        let z = (f64::from(i) - 0.5 * f64::from(rule.n - 1)) * rule.step;
        let weight = probe.weight * lit_along(&lit, z);
        sum += weight * radiance(&probe);
        lit_weight += weight;
    }
    sum * lit_scale(&lit, lit_weight)
}
