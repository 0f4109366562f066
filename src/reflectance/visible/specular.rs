//! Specular reflection of an environment by a few probes among the visible slopes.
//!
//! A rule is a set of nodes in the plane of two standard normal variables, on two or three rings, equally good in all
//! directions. The covariance of the slopes maps the nodes to the surface. Then each node moves along the view azimuth
//! `e` from its normal coordinate `x` to match the *visible* slopes ([`visible_slopes`](super::slopes)): their mean,
//! deviation and skewness replace 0, 1 and 0,
//!
//! ```text
//! q = p + e (t − x),   x = e·p,   t = μ + σ x + γ (x² − v)        slope = m + C q,   C Cᵀ = S
//! ```
//!
//! where `v` is the variance of the rule's nodes. Everything is written with `(C p)·wo.xy` in place of `e`, so nothing
//! flips or rotates abruptly at normal incidence. No axis of an ellipse is needed either, so nothing flips where the
//! ellipse is a circle.
//!
//! A node represents a part of all slopes, and its probe covers the solid angle that this part reflects into. From the
//! density of the visible slopes, `facet P22 / A`, and the Jacobian of reflection, `4 facet / |N|⁴`, that solid angle
//! is
//!
//! ```text
//! Ω = 4 A · 2π √det S · a exp((t² − x²)/2) / |N|⁴
//! ```
//!
//! where `a` is a constant of the node. It would be the node's weight times `exp(|p|²/2)` if the probe were to cover
//! exactly the part that the node represents; it is somewhat less (fitted with the nodes), since probes overlap.
//! Weights sum to one, so a constant environment is returned unchanged, and the Fresnel term is evaluated at each
//! facet.
//!
//! Narrow and wide lobes need different nodes. The outer slopes of a wide lobe reflect directions below the horizon,
//! where little is visible and almost nothing is lit, so the middle matters most. The rings of the largest rule
//! therefore change smoothly with the variance of the slopes ([`wide_lobe`]): their radii, weights and covers change,
//! while the nodes keep their azimuths ([`WideRing`]; `lab::quadrature_study::fit_probes` finds the values).

use super::slopes::visible_slopes;
use crate::reflectance::slopes::grid::{normal_of_slope, slope_cholesky};
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::PI;

/// A node of a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeNode {
    /// Position, in standard deviations.
    pub place: DVec2,
    /// Weight; the weights of a rule sum to one.
    pub weight: f64,
    /// The module's `a`: determines the solid angle that the probe covers.
    pub cover: f64,
}

const fn node(x: f64, y: f64, weight: f64, cover: f64) -> ProbeNode {
    ProbeNode { place: DVec2::new(x, y), weight, cover }
}

/// Rings: one in the middle, 4 at 1.659.
const FIVE: [ProbeNode; 5] = [
    node(0.000_000_0, 0.000_000_0, 0.331_413_372, 0.165_3),
    node(1.534_676_8, 0.631_169_8, 0.167_146_657, 0.369_1),
    node(-0.631_169_8, 1.534_676_8, 0.167_146_657, 0.369_1),
    node(-1.534_676_8, -0.631_169_8, 0.167_146_657, 0.369_1),
    node(0.631_169_8, -1.534_676_8, 0.167_146_657, 0.369_1),
];

/// Rings: 4 at 0.787, 5 at 1.895.
const NINE: [ProbeNode; 9] = [
    node(0.728_876_5, -0.297_359_9, 0.141_900_000, 0.062_4),
    node(0.297_359_9, 0.728_876_5, 0.141_900_000, 0.062_4),
    node(-0.728_876_5, 0.297_359_9, 0.141_900_000, 0.062_4),
    node(-0.297_359_9, -0.728_876_5, 0.141_900_000, 0.062_4),
    node(1.114_832_1, -1.532_004_4, 0.086_480_000, 0.253_1),
    node(1.801_524_8, 0.586_853_0, 0.086_480_000, 0.253_1),
    node(-0.001_428_6, 1.894_699_5, 0.086_480_000, 0.253_1),
    node(-1.802_407_7, 0.584_135_7, 0.086_480_000, 0.253_1),
    node(-1.112_520_7, -1.533_683_8, 0.086_480_000, 0.253_1),
];

/// Rings: one in the middle, 6 at 1.002, 9 at 1.968.
const SIXTEEN: [ProbeNode; 16] = [
    node(0.000_000_0, 0.000_000_0, 0.140_932_953, 0.048_1),
    node(0.991_426_3, 0.145_870_7, 0.081_605_920, 0.048_9),
    node(0.369_385_4, 0.931_535_7, 0.081_605_920, 0.048_9),
    node(-0.622_040_9, 0.785_665_0, 0.081_605_920, 0.048_9),
    node(-0.991_426_3, -0.145_870_7, 0.081_605_920, 0.048_9),
    node(-0.369_385_4, -0.931_535_7, 0.081_605_920, 0.048_9),
    node(0.622_040_9, -0.785_665_0, 0.081_605_920, 0.048_9),
    node(1.700_564_4, 0.989_911_1, 0.041_047_948, 0.130_9),
    node(0.666_405_4, 1.851_417_6, 0.041_047_948, 0.130_9),
    node(-0.679_572_2, 1.846_625_3, 0.041_047_948, 0.130_9),
    node(-1.707_570_3, 0.977_776_5, 0.041_047_948, 0.130_9),
    node(-1.936_577_4, -0.348_584_8, 0.041_047_948, 0.130_9),
    node(-1.259_438_3, -1.511_839_4, 0.041_047_948, 0.130_9),
    node(0.007_005_9, -1.967_687_5, 0.041_047_948, 0.130_9),
    node(1.270_172_0, -1.502_832_8, 0.041_047_948, 0.130_9),
    node(1.939_010_5, -0.334_785_9, 0.041_047_948, 0.130_9),
];

/// A ring in the limit of wide lobes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WideRing {
    /// Number of nodes.
    pub count: usize,
    /// Radius, as a multiple of the radius for narrow lobes.
    pub radius: f64,
    /// Weight of each node; the weights of all rings' nodes sum to one.
    pub weight: f64,
    /// Cover of each node ([`ProbeNode::cover`]).
    pub cover: f64,
}

const fn ring(count: usize, radius: f64, weight: f64, cover: f64) -> WideRing {
    WideRing { count, radius, weight, cover }
}

/// The rings of [`SIXTEEN`] in the limit of wide lobes.
const WIDE_SIXTEEN: [WideRing; 3] = [
    ring(1, 1.0, 0.086_722_3, 0.042_8),
    ring(6, 0.882_6, 0.071_775_9, 0.056_6),
    ring(9, 0.925_7, 0.053_624_7, 0.244_3),
];

/// The nodes of a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeRule<'a> {
    /// The nodes for slopes of variance up to [`WIDE_FROM`], ring by ring.
    pub nodes: &'a [ProbeNode],
    /// The same rings in the limit of wide lobes; empty for rules that do not change.
    pub wide: &'a [WideRing],
}

impl<'a> ProbeRule<'a> {
    /// The nodes for a lobe of the given width `wide` ([`wide_lobe`], 0..1).
    pub fn nodes(self, wide: f64) -> impl Iterator<Item = ProbeNode> + 'a {
        let mut rings = self.wide.iter().flat_map(|ring| std::iter::repeat_n(ring, ring.count));
        self.nodes.iter().map(move |&n| match rings.next() {
            Some(ring) => ProbeNode {
                place: n.place * (1.0 + wide * (ring.radius - 1.0)),
                weight: n.weight + wide * (ring.weight - n.weight),
                cover: n.cover + wide * (ring.cover - n.cover),
            },
            None => n,
        })
    }
}

/// The rule of 5, 9 or 16 probes; any other number gives the next larger rule.
#[must_use]
pub fn probe_rule(n: u32) -> ProbeRule<'static> {
    match n {
        0..=5 => ProbeRule { nodes: &FIVE, wide: &[] },
        6..=9 => ProbeRule { nodes: &NINE, wide: &[] },
        _ => ProbeRule { nodes: &SIXTEEN, wide: &WIDE_SIXTEEN },
    }
}

/// `v`: approximate variance of the nodes of any rule; the width of the probes makes up the rest.
pub const NODE_VARIANCE: f64 = 0.95;

/// Variance of slopes, summed over both axes, up to which a lobe is narrow: a deviation of 0.35 per axis.
pub const WIDE_FROM: f64 = 0.25;
/// Additional variance at which the lobe is half wide (0.5 per axis).
pub const WIDE_HALF: f64 = 0.25;

/// Width of a lobe, from 0 to 1; `s`: covariance of the slopes. Its derivative is continuous.
#[must_use]
pub fn wide_lobe(s: DVec3) -> f64 {
    let x = (s.x + s.y - WIDE_FROM).max(0.0) / WIDE_HALF;
    x * x / (1.0 + x * x)
}

/// Added solid angle of the probes of a footprint that is much longer than wide, in units of the variance along it.
/// Probes keep a width even where slopes vary in one direction alone.
pub const LONG_FOOTPRINT: f64 = 0.02;

/// The values that all probes of a pixel share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleProbes {
    /// Mean slope, of all facets.
    pub m: DVec2,
    /// Lower Cholesky factor `(c_xx, c_yx, c_yy)` of their covariance.
    pub cholesky: DVec3,
    /// Change of slope per standard deviation along the view azimuth.
    pub axis: DVec2,
    /// `x = azimuth · C p`.
    pub azimuth: DVec2,
    /// `μ`, `σ` and `γ` of the visible slopes along the view azimuth.
    pub along: DVec3,
    /// Projected area of the mesosurface, and its decrease per unit of `t`.
    pub facet: DVec2,
    /// Visible area `A(wo)`.
    pub area: f64,
    /// Solid angle per `a exp((t² − x²)/2) / |N|⁴`.
    pub cover: f64,
    /// Smallest solid angle of a probe, added to all of them.
    pub least: f64,
    /// Width of the lobe ([`wide_lobe`]).
    pub wide: f64,
}

/// The probes for everything visible from `wo`. `wo`: unit; `m`, `s`: mean slope and covariance, anything finite.
#[must_use]
pub fn visible_probes(wo: DVec3, m: DVec2, s: DVec3) -> VisibleProbes {
    let v = visible_slopes(wo, m, s);
    let cholesky = slope_cholesky(v.s);
    let per_b = 1.0 / v.b.max(1e-18);
    // |dwi|² = 4/|N|² ((p·ds)² + facet²/|N|² (|ds|² − (s·ds)²/|N|²)) at the mean.
    let s = v.mean;
    let per = 1.0 / (1.0 + s.dot(s));
    let p = wo.xy() + s * (v.facet * per);
    let q = v.facet * v.facet * per;
    let metric = 4.0
        * per
        * DVec3::new(
            p.x * p.x + q * (1.0 - s.x * s.x * per),
            p.y * p.y + q * (1.0 - s.y * s.y * per),
            p.x * p.y - q * s.x * s.y * per,
        );
    // With λ₁ and λ₂ the footprint's variances along its axes: (λ₁ − λ₂)² / (λ₁ + λ₂).
    let trace = v.cov.x * metric.x + v.cov.y * metric.y + 2.0 * v.cov.z * metric.z;
    let jacobian = 4.0 * v.facet * per * per;
    let det = (v.cov.x * v.cov.y - v.cov.z * v.cov.z).max(0.0) * jacobian * jacobian;
    let long = (trace - 4.0 * det / trace.max(1e-20)).max(0.0);
    VisibleProbes {
        m: v.m,
        cholesky,
        axis: v.axis,
        azimuth: wo.xy() * per_b,
        along: DVec3::new(-v.shift, v.variance.sqrt(), v.third / (6.0 * v.variance)),
        facet: DVec2::new(v.a, v.b),
        area: v.area,
        cover: 8.0 * PI * v.area * cholesky.x * cholesky.z,
        least: LONG_FOOTPRINT * long,
        wide: wide_lobe(v.s),
    }
}

/// One lookup of the environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleProbe {
    /// Slope of the facet.
    pub slope: DVec2,
    /// Reflected direction, unit.
    pub wi: DVec3,
    /// `wo·wn`, 0..1.
    pub cosine: f64,
    /// Weight; the weights of a rule sum to one.
    pub weight: f64,
    /// Solid angle to look up, in steradians.
    pub solid_angle: f64,
}

/// The probe of a node.
#[must_use]
pub fn visible_probe(probes: &VisibleProbes, wo: DVec3, node: &ProbeNode) -> VisibleProbe {
    let (p, c) = (node.place, probes.cholesky);
    let d = DVec2::new(c.x * p.x, c.y * p.x + c.z * p.y);
    let x = d.dot(probes.azimuth);
    let t = probes.along.x + x * probes.along.y + (x * x - NODE_VARIANCE) * probes.along.z;
    let slope = probes.m + d + probes.axis * (t - x);
    let wn = normal_of_slope(slope);
    let cosine = (probes.facet.x - t * probes.facet.y).max(0.0) * wn.z;
    let covered = node.cover * (0.5 * (t * t - x * x)).min(40.0).exp() * wn.z.powi(4);
    VisibleProbe {
        slope,
        wi: 2.0 * cosine * wn - wo,
        cosine,
        weight: node.weight,
        solid_angle: probes.cover * covered + probes.least,
    }
}

/// Level of detail at which the texels have this solid angle on average. `size`: texels per edge of the environment's
/// cube map. May be negative.
#[must_use]
pub fn solid_angle_lod(solid_angle: f64, size: f64) -> f64 {
    0.5 * (solid_angle.max(1e-12) * (6.0 / (4.0 * PI))).log2() + size.log2()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_have_the_moments_they_should() {
        for n in [5, 9, 16] {
            for wide in [0.0, 0.3, 1.0] {
                let nodes: Vec<ProbeNode> = probe_rule(n).nodes(wide).collect();
                assert_eq!(nodes.len(), n as usize);
                let sum = |f: &dyn Fn(DVec2) -> f64| nodes.iter().map(|k| k.weight * f(k.place)).sum::<f64>();
                assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-7, "weights of {n}");
                assert!(sum(&|p| p.x).abs() < 1e-5 && sum(&|p| p.y).abs() < 1e-5, "mean of {n}");
                let (xx, yy, xy) = (sum(&|p| p.x * p.x), sum(&|p| p.y * p.y), sum(&|p| p.x * p.y));
                println!("{n} {wide}: {xx}");
                assert!(
                    (xx - yy).abs() < 1e-5 && (xx - NODE_VARIANCE).abs() < 0.04 && xy.abs() < 1e-5,
                    "{xx} {yy} {xy}"
                );
            }
        }
    }

    /// Lobes widen gradually.
    #[test]
    fn wide_lobes_come_smoothly() {
        let at = |x: f64| wide_lobe(DVec3::new(0.5 * (WIDE_FROM + x), 0.5 * (WIDE_FROM + x), 0.0));
        assert_eq!((at(-0.1), at(0.0), at(WIDE_HALF)), (0.0, 0.0, 0.5));
        assert!(at(1e-4) < 1e-6 && at(1e6) > 0.999);
        assert_eq!(WIDE_SIXTEEN.map(|r| r.count), [1, 6, 9]);
    }
}
