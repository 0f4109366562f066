//! The specular reflection of an environment, by a few probes over the visible slopes.
//!
//! The visible slopes have a mean `μ` and a covariance `S` ([`visible_slopes`](super::slopes)). Near the mean, reflection maps slopes to
//! directions by a linear map `J`, so `|dwi|² = dsᵀ M ds` with `M = JᵀJ`. The reflection lobe is then a Gaussian of covariance
//! `Σ = J S Jᵀ`. Smaller, round Gaussians approximate the lobe, one per probe. Each lookup filters with a kernel of variance `v`
//! ([`kernel`](super::kernel)), and the nodes have the covariance `Σ − v`. For every `v`, the sum has the second moments of the lobe.
//! Kernels that overlap enough show no pattern.
//!
//! **Kernel width.** If `λ₁ ≥ λ₂` are the eigenvalues of `Σ`, the kernel variance is
//!
//! ```text
//! v = λ₂ (1 − (1 − κ) ρ) + g (λ₁ − λ₂)²/(λ₁ + λ₂),   r = 4 λ₁λ₂/(λ₁ + λ₂)²,   ρ = r⁸ in narrow lobes, 1 in wide ones
//! ```
//!
//! For round lobes (`r = 1`), the kernel takes the fraction `κ` of the variance. For elongated narrow lobes, the kernel approaches the
//! width of the lobe, and the nodes are spread only along the lobe. The term in `g` hides the separate nodes of very long lobes. The nodes
//! keep the remaining covariance: `λ₁ − v` along the lobe and `λ₂ − v` across it, smoothly bounded at 0. In slopes, this covariance is
//! `a S + b M⁻¹`, and its square root `C` positions the nodes. The formula needs no ellipse axes, so it stays continuous for circular
//! lobes.
//!
//! **Nodes** are points `p` on two or three rings in a plane. The points have unit variance and no preferred direction. Their slopes are
//! `slope = μ + d + e γ (u² − E[u²])` with `d = C p`. Here `u` is the slope along the view azimuth in standard deviations of all slopes,
//! and `e` is the slope per unit of `u`. `γ` gives the nodes the skewness of the visible slopes. The formulas use `d·wo.xy` instead of the
//! azimuth, so they are continuous at normal incidence.
//!
//! **Away from the mean**, the lobe has a different density, and the kernels scale accordingly. With the density of the visible slopes,
//! `facet P22 / A`, and the Jacobian of reflection, `4 facet / |N|⁴`, the variance of a probe is
//!
//! ```text
//! v a A exp((t² − y²)/2) / |N|⁴ · |N₀|⁴/(facet₀ σ)      y = u/σ,  t = slope along the azimuth
//! ```
//!
//! Here `σ` is the standard deviation of the visible slopes along the azimuth, and the index 0 marks the mean. The node constant `a` is 1
//! on average. Reflected directions span at most π, so the lookup uses `v/(1 + v/2)`.
//!
//! Reflection is nonlinear, so the reflection at the mean slope is not the centre of a probe's part of the lobe. Each lookup uses the mean
//! direction of that part ([`mean_mirror`]).
//!
//! Weights sum to one, so a constant environment is returned unchanged. Kernels do not filter the Fresnel term, which is evaluated at each
//! node as if the nodes covered the whole lobe.
//!
//! Wide lobes are not Gaussian in direction, so they need other nodes, with smaller kernels spread over both axes of a long lobe. The
//! kernel fraction, `ρ`, radii, weights and covers change smoothly with the slope variance ([`wide_lobe`]). Node azimuths stay fixed
//! ([`ProbeRing`]; fitted by `lab::quadrature_study::fit_probes`). With shadowing, probes sample only the slopes that reflect lit
//! directions ([`lit_slopes`](super::lit_slopes)).

use super::fresnel::visible_schlick_weight;
use super::lit_slopes::{LitSlopes, lit_slopes};
use super::mapped::MappedSlopes;
use super::slopes::{VisibleSlopes, visible_slopes};
use crate::limits::within;
use crate::masking::shadowing::Shadowing;
use crate::slopes::grid::slope_cholesky;
use crate::slopes::statistics::covariance_times;
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::{SQRT_2, TAU};

/// One node of a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeNode {
    /// The position of the node, in standard deviations of the nodes.
    pub offset: DVec2,
    /// The weight. The weights of a rule sum to one.
    pub weight: f64,
    /// The factor `a` of the module documentation, which is the kernel's variance relative to the other nodes of the rule.
    pub cover: f64,
}

/// The shape of a ring for one lobe width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingShape {
    /// The distance of the nodes from the origin, in standard deviations of the nodes.
    pub radius: f64,
    /// The weight of each node.
    pub weight: f64,
    /// The cover of each node ([`ProbeNode::cover`]).
    pub cover: f64,
}

/// Evenly spaced nodes at one distance from the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeRing {
    /// The number of nodes.
    pub count: usize,
    /// The azimuth of the first node, in radians.
    pub phase: f64,
    /// The shape for narrow lobes, with `Σ weight = 1`, `Σ weight radius² = 2` and `Σ weight cover = 1` over the nodes of a rule.
    pub narrow: RingShape,
    /// The limit shape for wide lobes, with `Σ weight = 1` and `Σ weight radius² = 2`.
    pub wide: RingShape,
}

/// Returns a ring with this count and phase. `narrow` and `wide` each hold the radius, the weight and the cover.
const fn ring(count: usize, phase: f64, narrow: [f64; 3], wide: [f64; 3]) -> ProbeRing {
    const fn shape([radius, weight, cover]: [f64; 3]) -> RingShape {
        RingShape { radius, weight, cover }
    }
    ProbeRing { count, phase, narrow: shape(narrow), wide: shape(wide) }
}

/// The division of a lobe's variance between kernels and nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeKernel {
    /// The fraction `κ` of a round lobe's variance that the kernel takes, for narrow lobes and in the limit of wide lobes.
    pub share: [f64; 2],
    /// The fraction `g` of a long lobe's variance along the lobe that the kernel takes.
    pub along: f64,
}

/// A probe quadrature rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeRule<'a> {
    /// The division of the variance between kernels and nodes.
    pub kernel: ProbeKernel,
    /// The rings of nodes.
    pub rings: &'a [ProbeRing],
}

/// The kernels of the rules with 3 and 5 probes.
const FEW_KERNELS: ProbeKernel = ProbeKernel { share: [0.6, 0.413], along: 0.073 };

/// The lobes of classes of facets with small shares have this rule. Kernels that suit it better with one class make several classes worse.
const THREE: ProbeRule<'_> = ProbeRule {
    kernel: FEW_KERNELS,
    rings: &[ring(3, 0.000, [SQRT_2, 0.333_333_333, 1.0], [SQRT_2, 0.333_333_333, 1.0])],
};

const FIVE: ProbeRule<'_> = ProbeRule {
    kernel: FEW_KERNELS,
    rings: &[
        ring(1, 0.000, [0.000_0, 0.229_228_000, 0.705_5], [0.0000, 0.396920000, 1.7688]),
        ring(4, 0.390, [1.610_8, 0.192_693_000, 1.087_6], [1.8211, 0.150770000, 0.9803]),
    ],
};

const NINE: ProbeRule<'_> = ProbeRule {
    kernel: ProbeKernel { share: [0.5, 0.262], along: 0.024 },
    rings: &[
        ring(3, 0.000, [0.543_4, 0.110_301_110, 0.783_3], [0.7234, 0.169077662, 1.3253]),
        ring(6, 5.925, [1.686_1, 0.111_516_112, 1.107_2], [1.8762, 0.082127836, 1.0869]),
    ],
};

const SIXTEEN: ProbeRule<'_> = ProbeRule {
    kernel: ProbeKernel { share: [0.4, 0.167], along: 0.01 },
    rings: &[
        ring(1, 0.000, [0.000_0, 0.101_126_798, 0.953_3], [0.0000, 0.129550000, 1.2382]),
        ring(6, 5.925, [0.943_7, 0.082_907_834, 0.866_8], [1.0018, 0.081103000, 1.1103]),
        ring(9, 3.213, [1.969_4, 0.044_602_911, 1.176_9], [1.9845, 0.042648000, 1.2183]),
    ],
};

impl<'a> ProbeRule<'a> {
    /// Returns the nodes for a lobe of the width `wide`, from 0 to 1 ([`wide_lobe`]).
    pub fn nodes(self, wide: f64) -> impl Iterator<Item = ProbeNode> + 'a {
        self.rings.iter().flat_map(move |ring| {
            let ProbeRing { narrow, wide: other, count, phase } = *ring;
            let mix = |a: f64, b: f64| a + wide * (b - a);
            let radius = mix(narrow.radius, other.radius);
            let (weight, cover) = (mix(narrow.weight, other.weight), mix(narrow.cover, other.cover));
            (0..count).map(move |i| {
                let offset = radius * DVec2::from_angle(phase + TAU * i as f64 / count as f64);
                ProbeNode { offset, weight, cover }
            })
        })
    }
}

/// Returns the rule of 3, 5, 9 or 16 probes. Other numbers select the next larger rule, up to 16 probes. The nodes of the rule with 3
/// probes need [`towards_viewer`].
pub fn probe_rule(n: u32) -> ProbeRule<'static> {
    match n {
        0..=3 => THREE,
        4..=5 => FIVE,
        6..=9 => NINE,
        _ => SIXTEEN,
    }
}

/// The variance of round slopes, summed over both axes, at which [`wide_lobe`] is 1/2. It is a standard deviation of 0.42 per axis.
pub const WIDE_HALF: f64 = 0.35;

/// The value of [`VisibleProbes::lit_spread`] for wide lobes and at normal incidence. Narrow lobes at grazing angles have twice this
/// spread, because they end at the horizon, and their shadowed part is in tails that few probes sample. The value is fitted to converged
/// integrals in a white room and under harmonics of order 2, and validated against ray casts.
const LIT_SPREAD: f64 = 0.6;

/// Returns the width of a lobe, from 0 to 1. `s` is the covariance of the slopes. The minor axis determines the width of long lobes.
pub fn wide_lobe(s: DVec3) -> f64 {
    let x = 4.0 / WIDE_HALF * (s.x * s.y - s.z * s.z).max(0.0) / (s.x + s.y).max(1e-15);
    x * x / (1.0 + x * x)
}

/// The positions of a rule's nodes in slope space. A node `p` has the slope `middle + root p + bend u²`, where `u = azimuth·root p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodePositions {
    /// The slope of a node at the origin.
    pub middle: DVec2,
    /// The square root of the nodes' covariance `(xx, yy, xy)`.
    pub root: DVec3,
    /// The additional slope per unit of `u²`.
    pub bend: DVec2,
    /// The gradient of `u` with respect to the slope.
    pub azimuth: DVec2,
}

/// Returns the slope and the coordinate `u` of the node `p`.
pub fn node_slope(nodes: &NodePositions, p: DVec2) -> (DVec2, f64) {
    let d = covariance_times(nodes.root, p);
    let u = within(d.dot(nodes.azimuth), 6.0);
    (nodes.middle + d + nodes.bend * (u * u), u)
}

/// Returns node positions with the covariance `spread` about the mean of `v`, and with the skewness of `v`. Also returns `γ` and `E[u²]`.
fn node_positions(wo: DVec3, v: &VisibleSlopes, spread: DVec3) -> (NodePositions, f64, f64) {
    let skew = v.third / (6.0 * v.variance * v.variance);
    let azimuth = wo.xy() / v.b.max(1e-18);
    let mean_square =
        azimuth.x * (spread.x * azimuth.x + 2.0 * spread.z * azimuth.y) + spread.y * azimuth.y * azimuth.y;
    // The rounding error of a vanishing covariance must not produce a large value.
    let mean_square = within(mean_square, 1.0);
    let bend = skew * v.axis;
    let middle = v.mean - bend * mean_square;
    (NodePositions { middle, root: root_of(spread), bend, azimuth }, skew, mean_square)
}

/// The values shared by all probes of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleProbes {
    /// The mean slope of all facets.
    pub m: DVec2,
    /// The lower Cholesky factor `(c_xx, c_yx, c_yy)` of the slope covariance.
    pub cholesky: DVec3,
    /// The visible area `A(wo)` of all facets.
    pub area: f64,
    /// The node positions of the probes.
    pub nodes: NodePositions,
    /// The coefficients of `t = along.x + u + along.y u²`. `along.z` is half the inverse variance of the visible `u`.
    pub along: DVec3,
    /// The projected area of the mesosurface, and the decrease of this area per unit of `t`.
    pub facet: DVec2,
    /// The slope covariance that one kernel filters.
    pub part: DVec3,
    /// The lookup variance divided by `a exp((t² − y²)/2) / |N|⁴`.
    pub kernel: f64,
    /// The width of the lobe ([`wide_lobe`]).
    pub wide: f64,
    /// The node positions over the whole lobe, whether lit or not, for the Fresnel term.
    pub fresnel_nodes: NodePositions,
    /// The projected area of a facet of slope 0 in `fresnel_nodes`.
    pub flat: f64,
    /// The degree to which kernels scale with the projected area of their facet, and the inverse of this area at the mean. The degree is 0,
    /// or the variance fraction of a normal map.
    pub projected: DVec2,
    /// The spread of the two directions that split a probe's light, as a fraction of the probe's variance, from 0.6 to 1.2
    /// ([`shadowed_specular`](super::shadowed_specular)).
    pub lit_spread: f64,
    /// The mean of Schlick's weight over all visible facets.
    pub grazing: f64,
    /// The lit slopes that replace all visible slopes. The field `lit.mean` includes the ratio of the visible areas.
    pub lit: LitSlopes,
}

/// Returns the symmetric square root of a covariance `(xx, yy, xy)`. Unlike a Cholesky factor, this root is continuous when a thin
/// distribution rotates across an axis.
pub fn root_of(s: DVec3) -> DVec3 {
    let det = (s.x * s.y - s.z * s.z).max(0.0).sqrt();
    let per = 1.0 / (s.x + s.y + 2.0 * det).max(1e-18).sqrt();
    DVec3::new(s.x.max(0.0) + det, s.y.max(0.0) + det, s.z) * per
}

/// Returns the probes for all facets visible from `wo`, or for the lit facets only if `shadowing` applies. `wo` is a unit vector. The mean
/// slope `m` and the covariance `s` may have any finite value.
pub fn visible_probes(shadowing: Shadowing, wo: DVec3, m: DVec2, s: DVec3, kernel: ProbeKernel) -> VisibleProbes {
    visible_probes_of(shadowing, wo, visible_slopes(wo, m, s), kernel)
}

/// Returns the probes of a normal map and its base ([`mapped_slopes`](super::mapped::mapped_slopes)), over its front-facing facets. Away
/// from the mean, kernels also scale with the projected facet area, which does not cancel for normal maps.
pub fn mapped_probes(wo: DVec3, v: &MappedSlopes, kernel: ProbeKernel) -> VisibleProbes {
    let facet = v.slopes.facet.max(1e-9);
    VisibleProbes {
        projected: DVec2::new(v.relief, 1.0 / facet),
        ..visible_probes_of(Shadowing::None, wo, v.slopes, kernel)
    }
}

fn visible_probes_of(shadowing: Shadowing, wo: DVec3, all: VisibleSlopes, kernel: ProbeKernel) -> VisibleProbes {
    let mut lit = LitSlopes { m: all.m, s: all.s, lean: DVec2::ZERO, damp: DVec3::ZERO, mean: 0.0 };
    let mut v = all;
    if shadowing != Shadowing::None {
        lit = lit_slopes(wo, &all);
        v = visible_slopes(wo, lit.m, lit.s);
        lit.mean += (v.area.max(1e-30) / all.area.max(1e-30)).ln();
    }
    // At the mean slope, |dwi|² = 4/|N|² ((p·ds)² + facet²/|N|² (|ds|² − (s·ds)²/|N|²)).
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
    let jacobian = 4.0 * v.facet * per * per;
    let inverse = DVec3::new(metric.y, metric.x, -metric.z) / (jacobian * jacobian).max(1e-20);
    // Compute the sum and the difference of the lobe's variances along its axes.
    const LEAST: f64 = 1e-15;
    let sum = (v.cov.x * metric.x + v.cov.y * metric.y + 2.0 * v.cov.z * metric.z).max(0.0);
    let per_sum = 1.0 / sum.max(LEAST);
    let det = (v.cov.x * v.cov.y - v.cov.z * v.cov.z).max(0.0) * jacobian * jacobian;
    let round = (4.0 * (det * per_sum) * per_sum).min(1.0);
    let difference = sum * (1.0 - round).sqrt();
    let major = 0.5 * (sum + difference);
    let minor = det / major.max(LEAST);
    let wide = wide_lobe(all.s);
    let round8 = (round * round * round * round).powi(2);
    let even = round8 + wide * (1.0 - round8);
    let share = kernel.share[0] + wide * (kernel.share[1] - kernel.share[0]);
    // For round lobes, 2 det/sum equals the minor variance, and unlike it is smooth.
    let most = (minor - share * 0.5 * sum * round) * even;
    let long = kernel.along * sum * (1.0 - round);
    let variance = minor - most + long;
    // The node variance across the lobe is the lobe's variance minus the kernel's variance, smoothly bounded at 0.
    let rest = most - long;
    let soft = 0.1 * long;
    let root = (rest * rest + soft * soft).sqrt();
    let across = 0.5 * (rest + root) + 1e-3 * sum * (1.0 - round);
    let of_lobe = 1.0 - 0.5 * (root - rest) / difference.max(1e-3 * sum).max(LEAST);
    let spread = of_lobe * v.cov + (across - of_lobe * minor) * inverse;

    let (nodes, skew, mean_square) = node_positions(wo, &v, spread);
    let sine2 = (1.0 - all.a * all.a / (1.0 + all.m.length_squared())).max(0.0);
    VisibleProbes {
        m: all.m,
        cholesky: slope_cholesky(all.s),
        area: all.area,
        nodes,
        along: DVec3::new(-v.shift - skew * mean_square, skew, 0.5 / v.variance),
        facet: DVec2::new(v.a, v.b),
        part: (1.0 - wide) * (v.cov - spread),
        kernel: variance * v.area / (v.facet * v.variance.sqrt() * per * per),
        wide,
        fresnel_nodes: node_positions(wo, &all, all.cov).0,
        flat: all.a + wo.xy().dot(all.m),
        projected: DVec2::ZERO,
        grazing: visible_schlick_weight(&all),
        lit_spread: LIT_SPREAD * (1.0 + (1.0 - wide) * sine2),
        lit,
    }
}

/// A single lookup of the environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleProbe {
    /// The slope of the facet.
    pub slope: DVec2,
    /// The unit direction that this facet reflects.
    pub mirror: DVec3,
    /// The unit mean direction that the probe's part of the lobe reflects.
    pub wi: DVec3,
    /// The cosine `wo·wn` for the Fresnel term of all visible facets, from 0 to 1.
    pub cosine: f64,
    /// The weight. The weights of a rule sum to one.
    pub weight: f64,
    /// The variance of the lookup per axis, in radians², below 2 ([`kernel`](super::kernel)).
    pub variance: f64,
}

/// Returns the unit mean direction that Gaussian slopes of covariance `c` about `slope` reflect. To second order, this is `E[f N/|N|²]` by
/// the moments of `f N` and of `|N|²`, where `f` is the projected area of a facet. The argument `f` is this area at `slope`.
pub fn mean_mirror(wo: DVec3, slope: DVec2, f: f64, c: DVec3) -> DVec3 {
    let (o, s) = (covariance_times(c, wo.xy()), covariance_times(c, slope));
    let per = 1.0 / (1.0 + slope.dot(slope) + c.x + c.y);
    let up = f + 2.0 * per * (wo.xy().dot(s) + 2.0 * per * f * slope.dot(s));
    let flat = o + 2.0 * per * f * s - up * slope;
    let wi = 2.0 * per * flat.extend(up) - wo;
    wi / wi.length_squared().max(1e-12).sqrt()
}

/// Returns a node of the rule with three probes, rotated so that the three are symmetric about the direction orthogonal to the viewer's
/// azimuth. Fresnel terms and shadows change most along the azimuth, where skewed nodes would be wrong. Classes of facets with small shares
/// use this rule.
pub fn towards_viewer(probes: &VisibleProbes, wo: DVec3, node: &ProbeNode) -> ProbeNode {
    let root = probes.nodes.root;
    let per = 1.0 / (root.x + root.y).max(1e-18);
    let view = covariance_times(per * root, wo.xy()) + 0.03 * wo.xy() + DVec2::new(1e-6, 0.0);
    let axis = view.perp() / view.length();
    ProbeNode { offset: axis.rotate(node.offset), ..*node }
}

/// Returns the environment lookup of one node.
pub fn visible_probe(probes: &VisibleProbes, wo: DVec3, node: &ProbeNode) -> VisibleProbe {
    let (slope, u) = node_slope(&probes.nodes, node.offset);
    let t = probes.along.x + u + probes.along.y * u * u;
    let z2 = 1.0 / (1.0 + slope.dot(slope));
    let stretch = (0.5 * t * t - probes.along.z * u * u).min(40.0).exp() * z2 * z2;
    let facet = (probes.facet.x - t * probes.facet.y).max(0.0);
    let grown = 1.0 + probes.projected.x * (facet * probes.projected.y - 1.0);
    let variance = (probes.kernel * node.cover * stretch * grown).min(1e6);
    // The Fresnel term is convex, and kernels do not filter it, so it uses the nodes of the whole lobe.
    let (fresnel_slope, _) = node_slope(&probes.fresnel_nodes, node.offset);
    let cosine = (probes.flat - wo.xy().dot(fresnel_slope)).max(0.0) / (1.0 + fresnel_slope.length_squared()).sqrt();
    let facing = (wo.z - wo.xy().dot(slope)).max(0.0);
    VisibleProbe {
        slope,
        mirror: 2.0 * facing * z2 * (-slope).extend(1.0) - wo,
        wi: mean_mirror(wo, slope, facet, probes.part),
        cosine: cosine.min(1.0),
        weight: node.weight,
        variance: variance / (1.0 + 0.5 * variance),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_have_the_moments_they_should() {
        for n in [3, 5, 9, 16] {
            for wide in [0.0, 0.3, 1.0] {
                let nodes: Vec<ProbeNode> = probe_rule(n).nodes(wide).collect();
                assert_eq!(nodes.len(), n as usize);
                let sum = |f: &dyn Fn(DVec2) -> f64| nodes.iter().map(|k| k.weight * f(k.offset)).sum::<f64>();
                assert!((sum(&|_| 1.0) - 1.0).abs() < 1e-7, "weights of {n}");
                assert!(sum(&|p| p.x).abs() < 1e-5 && sum(&|p| p.y).abs() < 1e-5, "mean of {n}");
                let (xx, yy, xy) = (sum(&|p| p.x * p.x), sum(&|p| p.y * p.y), sum(&|p| p.x * p.y));
                println!("{n} {wide}: {xx}");
                assert!(
                    (xx - yy).abs() < 1e-5
                        && (xx - 1.0).abs() < if wide == 0.3 { 1.5e-2 } else { 2e-4 }
                        && xy.abs() < 1e-5,
                    "{xx} {yy} {xy}"
                );
            }
        }
    }

    #[test]
    fn wide_lobes_come_smoothly() {
        let at = |x: f64| wide_lobe(DVec3::new(0.5 * x, 0.5 * x, 0.0));
        assert_eq!((at(0.0), at(WIDE_HALF)), (0.0, 0.5));
        assert!(at(1e-3) < 1e-5 && at(1e6) > 0.999);
        assert!(wide_lobe(DVec3::new(4.0, 0.01, 0.0)) < 0.02, "long lobes are narrow");
    }
}
