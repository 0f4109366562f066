//! Specular reflection of an environment by a few probes among the visible slopes.
//!
//! The visible slopes have a mean `μ` and a covariance `S` ([`visible_slopes`](super::slopes)). Near the mean, reflected
//! directions move with the slope by a linear map `J`, `|dwi|² = dsᵀ M ds` with `M = JᵀJ`. So the environment is seen
//! through a Gaussian lobe of the covariance `Σ = J S Jᵀ`. It is taken apart into smaller, round Gaussians, one per
//! probe: nodes carry `Σ − v`, and every lookup is a kernel of variance `v` ([`kernel`](super::kernel)). Whatever `v`
//! is, the second moments are those of the lobe, and where kernels overlap enough, the sum shows no pattern.
//!
//! **How wide a kernel.** With `λ₁ ≥ λ₂` the eigenvalues of `Σ`,
//!
//! ```text
//! v = λ₂ (1 − (1 − κ) ρ) + g (λ₁ − λ₂)²/(λ₁ + λ₂),   r = 4 λ₁λ₂/(λ₁ + λ₂)²,   ρ = r⁸ in narrow lobes, 1 in wide ones
//! ```
//!
//! Round lobes (`r = 1`) have the share `κ` in the kernel. In elongated narrow ones the kernel is soon as wide as the lobe, and
//! nodes spread along it alone; `g` keeps the nodes of very long ones from showing. What is left for the nodes,
//! `λ₁ − v` along the lobe and `λ₂ − v`, smoothly kept from falling below 0, across it, is the covariance
//! `a S + b M⁻¹` in slopes, whose square root `C` places them: no axis of an ellipse is needed, and nothing flips
//! where it is a circle.
//!
//! **Nodes** are points of a plane on two or three rings, of unit variance, equally good in all directions:
//! `slope = μ + d + e γ (u² − E[u²])`, `d = C p`. Here `u` is the slope along the view azimuth in standard deviations of
//! all slopes, `e` the slope per unit of it, and `γ` gives the nodes the skewness of the visible slopes. Everything is
//! written with `d·wo.xy` in place of the azimuth, so nothing flips or rotates abruptly at normal incidence.
//!
//! **Away from the mean** the lobe is denser or thinner, and each kernel shrinks or grows with it. With the density of
//! the visible slopes, `facet P22 / A`, and the Jacobian of reflection, `4 facet / |N|⁴`, the variance of a probe is
//!
//! ```text
//! v a A exp((t² − y²)/2) / |N|⁴ · |N₀|⁴/(facet₀ σ)      y = u/σ,  t = slope along the azimuth
//! ```
//!
//! where `σ` is the deviation of the visible slopes along the azimuth, 0 marks the mean, and `a`, a constant of the node,
//! is 1 on average. Facets turn the reflected direction by at most half a turn, so `v/(1 + v/2)` is looked up.
//!
//! Nor does a part of the lobe lie about the mirror direction of its middle slope, because reflection bends what it maps:
//! every lookup goes to the mean direction of its part ([`mean_mirror`]).
//!
//! Weights sum to one, so a constant environment is returned unchanged, and the Fresnel term, which no kernel
//! filters, is evaluated at each node as if nodes carried the whole lobe.
//!
//! Narrow and wide lobes need different nodes, for wide ones are no Gaussians of directions: smaller kernels, spread over
//! both axes of a long lobe. Share, `ρ` and rings change smoothly with the variance of the slopes ([`wide_lobe`]): radii,
//! weights and covers change, while the nodes keep their azimuths ([`ProbeRing`]; `lab::quadrature_study::fit_probes`
//! fits them). With shadows probes are placed for the part of the slopes that mirrors lit directions
//! ([`lit_slopes`](super::lit_slopes)).

use super::lit_slopes::{LitSlopes, lit_slopes};
use super::mapped::MappedSlopes;
use super::slopes::{VisibleSlopes, visible_slopes};
use crate::limits::within;
use crate::masking::shadowing::Shadowing;
use crate::slopes::grid::slope_cholesky;
use crate::slopes::statistics::covariance_times;
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::TAU;

/// A node of a rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeNode {
    /// Position, in standard deviations of the nodes.
    pub place: DVec2,
    /// Weight; the weights of a rule sum to one.
    pub weight: f64,
    /// The module's `a`: the kernel's variance relative to others of the rule.
    pub cover: f64,
}

/// The nodes of a ring, for lobes of one width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingShape {
    /// Distance from the origin, in standard deviations of the nodes.
    pub radius: f64,
    /// Weight of each node.
    pub weight: f64,
    /// Cover of each node ([`ProbeNode::cover`]).
    pub cover: f64,
}

/// Nodes at the same distance from the origin, evenly spaced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeRing {
    /// Number of nodes.
    pub count: usize,
    /// Azimuth of the first one, in radians.
    pub phase: f64,
    /// Narrow lobes: `Σ weight = 1`, `Σ weight radius² = 2` and `Σ weight cover = 1` over the nodes of a rule.
    pub narrow: RingShape,
    /// The limit of wide lobes: `Σ weight = 1`, `Σ weight radius² = 2`.
    pub wide: RingShape,
}

/// Count and phase; radius, weight and cover for narrow lobes and for wide ones.
const fn ring(count: usize, phase: f64, narrow: [f64; 3], wide: [f64; 3]) -> ProbeRing {
    const fn shape([radius, weight, cover]: [f64; 3]) -> RingShape {
        RingShape { radius, weight, cover }
    }
    ProbeRing { count, phase, narrow: shape(narrow), wide: shape(wide) }
}

/// How a rule divides the variance of a lobe between its kernels and its nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeKernel {
    /// `κ`: the kernels' share of a round lobe, for narrow lobes and in the limit of wide ones.
    pub share: [f64; 2],
    /// `g`: their share of a long lobe's variance along it.
    pub along: f64,
}

/// A rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbeRule<'a> {
    /// Its kernels.
    pub kernel: ProbeKernel,
    /// Its nodes.
    pub rings: &'a [ProbeRing],
}

const FIVE: ProbeRule<'_> = ProbeRule {
    kernel: ProbeKernel { share: [0.6, 0.413], along: 0.073 },
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
    /// The nodes for a lobe of the given width `wide` ([`wide_lobe`], 0..1).
    pub fn nodes(self, wide: f64) -> impl Iterator<Item = ProbeNode> + 'a {
        self.rings.iter().flat_map(move |ring| {
            let ProbeRing { narrow, wide: other, count, phase } = *ring;
            let mix = |a: f64, b: f64| a + wide * (b - a);
            let radius = mix(narrow.radius, other.radius);
            let (weight, cover) = (mix(narrow.weight, other.weight), mix(narrow.cover, other.cover));
            (0..count).map(move |i| {
                let place = radius * DVec2::from_angle(phase + TAU * i as f64 / count as f64);
                ProbeNode { place, weight, cover }
            })
        })
    }
}

/// The rule of 5, 9 or 16 probes; any other number gives the next larger rule.
pub fn probe_rule(n: u32) -> ProbeRule<'static> {
    match n {
        0..=5 => FIVE,
        6..=9 => NINE,
        _ => SIXTEEN,
    }
}

/// Variance of round slopes, summed over both axes, at which a lobe is half wide: a deviation of 0.42 per axis.
pub const WIDE_HALF: f64 = 0.35;

/// [`VisibleProbes::lit_spread`] of wide lobes, and of what is seen from straight above. Narrow lobes seen edge-on have twice as much:
/// they end at the horizon, and most of what is shadowed of them lies in tails that few probes stand for. Fitted to
/// converged integrals in a white room and under order 2, held against ray casts.
const LIT_SPREAD: f64 = 0.6;

/// Width of a lobe, from 0 to 1; `s`: covariance of the slopes. Long lobes are as wide as they are across.
pub fn wide_lobe(s: DVec3) -> f64 {
    let x = 4.0 / WIDE_HALF * (s.x * s.y - s.z * s.z).max(0.0) / (s.x + s.y).max(1e-15);
    x * x / (1.0 + x * x)
}

/// Where the nodes of a rule lie among the slopes: `middle + root p + bend u²`, `u = azimuth·root p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodePlaces {
    /// Slope of a node at the origin.
    pub middle: DVec2,
    /// Square root of the nodes' covariance `(xx, yy, xy)`.
    pub root: DVec3,
    /// Additional slope per `u²`.
    pub bend: DVec2,
    /// `u` per slope.
    pub azimuth: DVec2,
}

/// The slope of a node, and its `u`.
pub fn node_slope(places: &NodePlaces, p: DVec2) -> (DVec2, f64) {
    let d = covariance_times(places.root, p);
    let u = within(d.dot(places.azimuth), 6.0);
    (places.middle + d + places.bend * (u * u), u)
}

/// Places of the covariance `spread` about the mean of `v`, with its skewness. Also `γ` and `E[u²]`.
fn node_places(wo: DVec3, v: &VisibleSlopes, spread: DVec3) -> (NodePlaces, f64, f64) {
    let skew = v.third / (6.0 * v.variance * v.variance);
    let azimuth = wo.xy() / v.b.max(1e-18);
    let mean_square =
        azimuth.x * (spread.x * azimuth.x + 2.0 * spread.z * azimuth.y) + spread.y * azimuth.y * azimuth.y;
    // Rounding of a vanishing covariance must not look like a large one.
    let mean_square = within(mean_square, 1.0);
    let bend = skew * v.axis;
    let middle = v.mean - bend * mean_square;
    (NodePlaces { middle, root: root_of(spread), bend, azimuth }, skew, mean_square)
}

/// The values that all probes of a pixel share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleProbes {
    /// Mean slope, of all facets.
    pub m: DVec2,
    /// Lower Cholesky factor `(c_xx, c_yx, c_yy)` of their covariance.
    pub cholesky: DVec3,
    /// Visible area `A(wo)` of all facets.
    pub area: f64,
    /// Places of the probes.
    pub places: NodePlaces,
    /// `t = along.x + u + along.y u²`, and half the inverse of the variance of the visible `u`.
    pub along: DVec3,
    /// Projected area of the mesosurface, and its decrease per unit of `t`.
    pub facet: DVec2,
    /// Covariance of the slopes that one kernel stands for.
    pub part: DVec3,
    /// Variance of a lookup per `a exp((t² − y²)/2) / |N|⁴`.
    pub kernel: f64,
    /// Width of the lobe ([`wide_lobe`]).
    pub wide: f64,
    /// Places over the whole lobe, lit or not, for the Fresnel terms.
    pub whole: NodePlaces,
    /// Projected area of a facet of slope 0 there.
    pub flat: f64,
    /// How far kernels grow with the projected area of their facet, 0 or the share of a normal map, and the inverse of that area at the
    /// mean.
    pub projected: DVec2,
    /// Part of the variance of a probe's light by which the two directions that it is taken apart into lie about what its facet
    /// mirrors ([`shadowed_specular`](super::shadowed_specular)), 0.6..1.2.
    pub lit_spread: f64,
    /// What probes are placed for instead of all visible slopes; its `mean` includes the ratio of the visible areas.
    pub lit: LitSlopes,
}

/// The symmetric square root of a covariance `(xx, yy, xy)`. Unlike a Cholesky factor, that of a thin one does not turn
/// abruptly as it passes an axis.
pub fn root_of(s: DVec3) -> DVec3 {
    let det = (s.x * s.y - s.z * s.z).max(0.0).sqrt();
    let per = 1.0 / (s.x + s.y + 2.0 * det).max(1e-18).sqrt();
    DVec3::new(s.x.max(0.0) + det, s.y.max(0.0) + det, s.z) * per
}

/// The probes for everything visible from `wo`, or with `shadowing` for the part of it that is lit. `wo`: unit; `m`, `s`:
/// mean slope and covariance, anything finite.
pub fn visible_probes(shadowing: Shadowing, wo: DVec3, m: DVec2, s: DVec3, kernel: ProbeKernel) -> VisibleProbes {
    visible_probes_of(shadowing, wo, visible_slopes(wo, m, s), kernel)
}

/// The probes of a normal map and its base ([`mapped_slopes`](super::mapped::mapped_slopes)): those of the facets that face the viewer. Away from the mean, kernels
/// also grow with the projected area of the facet, which no longer cancels.
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
    let jacobian = 4.0 * v.facet * per * per;
    let inverse = DVec3::new(metric.y, metric.x, -metric.z) / (jacobian * jacobian).max(1e-20);
    // The lobe's variances along its axes, their sum and difference.
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
    // 2 det/sum is the minor variance of round lobes, without its kink there.
    let most = (minor - share * 0.5 * sum * round) * even;
    let long = kernel.along * sum * (1.0 - round);
    let variance = minor - most + long;
    // What nodes keep across the lobe: its variance less the kernel's, rounded off at 0.
    let rest = most - long;
    let soft = 0.1 * long;
    let root = (rest * rest + soft * soft).sqrt();
    let across = 0.5 * (rest + root) + 1e-3 * sum * (1.0 - round);
    let of_lobe = 1.0 - 0.5 * (root - rest) / difference.max(1e-3 * sum).max(LEAST);
    let spread = of_lobe * v.cov + (across - of_lobe * minor) * inverse;

    let (places, skew, mean_square) = node_places(wo, &v, spread);
    let sine2 = (1.0 - all.a * all.a / (1.0 + all.m.length_squared())).max(0.0);
    VisibleProbes {
        m: all.m,
        cholesky: slope_cholesky(all.s),
        area: all.area,
        places,
        along: DVec3::new(-v.shift - skew * mean_square, skew, 0.5 / v.variance),
        facet: DVec2::new(v.a, v.b),
        part: (1.0 - wide) * (v.cov - spread),
        kernel: variance * v.area / (v.facet * v.variance.sqrt() * per * per),
        wide,
        whole: node_places(wo, &all, all.cov).0,
        flat: all.a + wo.xy().dot(all.m),
        projected: DVec2::ZERO,
        lit_spread: LIT_SPREAD * (1.0 + (1.0 - wide) * sine2),
        lit,
    }
}

/// One lookup of the environment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleProbe {
    /// Slope of the facet.
    pub slope: DVec2,
    /// Direction that this facet reflects, unit.
    pub mirror: DVec3,
    /// Mean direction that its part of the lobe reflects, unit.
    pub wi: DVec3,
    /// `wo·wn` for the Fresnel term of all visible facets, 0..1.
    pub cosine: f64,
    /// Weight; the weights of a rule sum to one.
    pub weight: f64,
    /// Variance of the lookup, per axis and in radians squared, below 2 ([`kernel`](super::kernel)).
    pub variance: f64,
}

/// Mean direction, unit, reflected by Gaussian slopes of covariance `c` about `slope`: to second order,
/// `E[f N/|N|²]` by the moments of `f N` and of `|N|²`, where `f` is the projected area of a facet, and here of the one at
/// `slope`.
pub fn mean_mirror(wo: DVec3, slope: DVec2, f: f64, c: DVec3) -> DVec3 {
    let (o, s) = (covariance_times(c, wo.xy()), covariance_times(c, slope));
    let per = 1.0 / (1.0 + slope.dot(slope) + c.x + c.y);
    let up = f + 2.0 * per * (wo.xy().dot(s) + 2.0 * per * f * slope.dot(s));
    let flat = o + 2.0 * per * f * s - up * slope;
    let wi = 2.0 * per * flat.extend(up) - wo;
    wi / wi.length_squared().max(1e-12).sqrt()
}

/// The probe of a node.
pub fn visible_probe(probes: &VisibleProbes, wo: DVec3, node: &ProbeNode) -> VisibleProbe {
    let (slope, u) = node_slope(&probes.places, node.place);
    let t = probes.along.x + u + probes.along.y * u * u;
    let z2 = 1.0 / (1.0 + slope.dot(slope));
    let stretch = (0.5 * t * t - probes.along.z * u * u).min(40.0).exp() * z2 * z2;
    let facet = (probes.facet.x - t * probes.facet.y).max(0.0);
    let grown = 1.0 + probes.projected.x * (facet * probes.projected.y - 1.0);
    let variance = (probes.kernel * node.cover * stretch * grown).min(1e6);
    // The Fresnel term is convex, and a kernel does not filter it.
    let (whole, _) = node_slope(&probes.whole, node.place);
    let cosine = (probes.flat - wo.xy().dot(whole)).max(0.0) / (1.0 + whole.length_squared()).sqrt();
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
                    (xx - yy).abs() < 1e-5
                        && (xx - 1.0).abs() < if wide == 0.3 { 1.5e-2 } else { 2e-4 }
                        && xy.abs() < 1e-5,
                    "{xx} {yy} {xy}"
                );
            }
        }
    }

    /// Lobes widen gradually.
    #[test]
    fn wide_lobes_come_smoothly() {
        let at = |x: f64| wide_lobe(DVec3::new(0.5 * x, 0.5 * x, 0.0));
        assert_eq!((at(0.0), at(WIDE_HALF)), (0.0, 0.5));
        assert!(at(1e-3) < 1e-5 && at(1e6) > 0.999);
        assert!(wide_lobe(DVec3::new(4.0, 0.01, 0.0)) < 0.02, "long lobes are narrow");
    }
}
