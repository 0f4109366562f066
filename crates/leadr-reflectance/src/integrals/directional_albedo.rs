//! Computes the directional albedo of specular facets by quadrature. The albedo is the fraction of a white environment, or of a white cone
//! of directions, that a surface reflects towards a viewer. This module is the reference for
//! [`materials::energy`](crate::materials::energy).
//!
//! Facets of slope `x` contribute `F P22(x) f G / a_o`, where `f` is their projected area. In polar slope coordinates, `tan θ = ρ tan ψ`,
//! the integrand is smooth in `ψ` for every roughness. The integrand has an edge where the light crosses the horizon or the border of a
//! cone. Along one azimuth, `wi` moves on a circle as `2θ` grows. The position of each edge is therefore an arc cosine, and the rule ends
//! exactly at the edge. The azimuths are denser near right angles to the viewer, where facets become visible at grazing incidence.

use crate::facets::fresnel::schlick_weight;
use crate::facets::slope_distribution::SlopeDistribution;
use crate::masking::occlusion::Cone;
use crate::masking::variants::{Masking, attenuation};
use crate::materials::energy::SplitAlbedo;
use crate::materials::microfacet::half_vector;
use crate::quadrature::gauss_legendre;
use crate::roots::bisect;
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The resolution of the quadrature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AlbedoRule {
    /// The number of azimuth panels on each side of a right angle to the viewer. Each panel is a quarter as wide as the previous panel.
    pub azimuths: usize,
    /// The number of slope panels.
    pub slopes: usize,
    /// The number of Gauss–Legendre nodes per panel and dimension.
    pub order: usize,
}

impl AlbedoRule {
    /// A fine rule. For roughnesses from .03 to 1 and view cosines of at least 1e-3, its errors are below 1e-6, or below 1e-5 with a cone.
    pub const FINE: Self = Self { azimuths: 6, slopes: 6, order: 12 };
}

/// Returns the rotation angles `2θ` in `[0, π]` for which `wi·axis > bound`, as at most two intervals. The half vectors have the azimuth
/// `e`.
fn free_rotations(wo: DVec3, e: DVec2, axis: DVec3, bound: f64) -> [[f64; 2]; 2] {
    // In the plane of azimuth e, wo·h = p·(sin θ, cos θ) and axis·h = q·(sin θ, cos θ).
    let (p, q) = (DVec2::new(wo.xy().dot(e), wo.z), DVec2::new(axis.xy().dot(e), axis.z));
    let still = p.dot(q) - wo.dot(axis);
    let (cosine, sine) = (p.y * q.y - p.x * q.x, p.x * q.y + p.y * q.x);
    let radius = cosine.hypot(sine);
    let (middle, ratio) = (sine.atan2(cosine), (bound - still) / radius.max(1e-300));
    let half = ratio.clamp(-1.0, 1.0).acos();
    [0.0, if middle < 0.0 { TAU } else { -TAU }].map(|round| {
        let (low, high) = (middle + round - half, middle + round + half);
        if half >= PI && round != 0.0 { [0.0, 0.0] } else { [low.max(0.0), high.min(PI)] }
    })
}

/// Integrates the albedo of specular facets towards `wo` in a white environment. With a `cone`, the environment is white inside the cone
/// and black outside. `distribution` must be central (mean slope 0), and may be anisotropic. The result is 0 for a viewer below the
/// horizon.
pub fn directional_albedo(
    distribution: &impl SlopeDistribution,
    masking: Masking,
    wo: DVec3,
    cone: Option<Cone>,
    rule: AlbedoRule,
) -> SplitAlbedo {
    let mut sum = SplitAlbedo::default();
    if wo.z.is_nan() || wo.z <= 0.0 {
        return sum;
    }
    let shape = distribution.shape();
    let det = (shape.x * shape.y - shape.z * shape.z).max(0.0);
    let nodes = gauss_legendre(rule.order);
    let viewer = if wo.x == 0.0 && wo.y == 0.0 { 0.0 } else { wo.y.atan2(wo.x) };
    // A half circle of azimuths is enough if the integrand is symmetric about the viewer's azimuth.
    let mirrored = shape.x == shape.y
        && shape.z == 0.0
        && cone.is_none_or(|c| (c.axis.x * wo.y - c.axis.y * wo.x).abs() < 1e-15 * wo.xy().length().max(1e-3));
    let turn = if mirrored { PI } else { TAU };
    let edges = azimuths(wo, viewer, cone, turn, rule.azimuths);
    for pair in edges.windows(2) {
        let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
        for &(x, w) in &nodes {
            // This substitution makes square roots at the borders of a cone linear.
            let phi = viewer + middle + half * 0.5 * x * (3.0 - x * x);
            let w = w * half * 1.5 * (1.0 - x * x) * (TAU / turn);
            let ray = along_azimuth(distribution, masking, wo, cone, phi, (shape, det), rule.slopes, &nodes);
            sum.ideal += w * ray.ideal;
            sum.grazing += w * ray.grazing;
        }
    }
    sum
}

/// Returns azimuths relative to the viewer's azimuth, in `0..turn`. The integrand is smooth between consecutive azimuths. They are denser
/// at right angles to the viewer, and include the borders of a cone.
fn azimuths(wo: DVec3, viewer: f64, cone: Option<Cone>, turn: f64, panels: usize) -> Vec<f64> {
    let mut edges = vec![0.0, turn];
    for right in [FRAC_PI_2, 3.0 * FRAC_PI_2] {
        edges.push(right);
        let beside = |k: i32| FRAC_PI_2 * 0.25f64.powi(k);
        edges.extend((0..panels as i32).flat_map(|k| [right - beside(k), right + beside(k)]));
    }
    if let Some(cone) = cone {
        let lit = |phi: f64| {
            let (sin, cos) = (viewer + phi).sin_cos();
            free_rotations(wo, DVec2::new(cos, sin), cone.axis, cone.cosine).iter().any(|[low, high]| high > low)
        };
        let half = half_vector(wo, cone.axis);
        let towards = (half.y.atan2(half.x) - viewer).rem_euclid(TAU);
        let mut at: Vec<f64> = (0..=SEARCHED).map(|i| turn * i as f64 / SEARCHED as f64).collect();
        at.push(towards.min(turn));
        at.sort_by(f64::total_cmp);
        for pair in at.windows(2) {
            let before = lit(pair[0]);
            if before != lit(pair[1]) {
                edges.push(bisect(pair[0], pair[1], 50, |phi| lit(phi) == before));
            }
        }
    }
    edges.retain(|e| (0.0..=turn).contains(e));
    edges.sort_by(f64::total_cmp);
    edges.dedup_by(|a, b| (*a - *b).abs() < 1e-14);
    edges
}

/// The number of azimuths in the search for the borders of a cone.
const SEARCHED: usize = 64;

fn along_azimuth(
    distribution: &impl SlopeDistribution,
    masking: Masking,
    wo: DVec3,
    cone: Option<Cone>,
    phi: f64,
    (shape, det): (DVec3, f64),
    panels: usize,
    nodes: &[(f64, f64)],
) -> SplitAlbedo {
    let mut sum = SplitAlbedo::default();
    let (sin, cos) = phi.sin_cos();
    let e = DVec2::new(cos, sin);
    // This is the slope deviation along the azimuth, up to the factor between roughness and covariance.
    let spread = (det / (shape.y * cos * cos - 2.0 * shape.z * cos * sin + shape.x * sin * sin).max(1e-300)).sqrt();
    let above = free_rotations(wo, e, DVec3::Z, 0.0);
    let free = cone.map_or([[0.0, PI], [0.0, 0.0]], |cone| free_rotations(wo, e, cone.axis, cone.cosine));
    for a in above {
        for b in free {
            let (low, high) = (a[0].max(b[0]), a[1].min(b[1]));
            if high <= low {
                continue;
            }
            let angle = |turn: f64| (0.5 * turn).sin().atan2(spread * (0.5 * turn).cos());
            let (low, high) = (angle(low), angle(high));
            // The panels are denser towards the steepest slopes, which reflect grazing light.
            let mut rest = high - low;
            for panel in 0..panels {
                let width = if panel + 1 == panels { rest } else { 0.75 * rest };
                let (half, middle) = (0.5 * width, high - rest + 0.5 * width);
                rest -= width;
                for &(x, w) in nodes {
                    let (sin, cos) = (middle + half * x).sin_cos();
                    let r = spread * sin / cos.max(1e-150);
                    let area = wo.z + r * wo.xy().dot(e);
                    if area <= 0.0 {
                        continue;
                    }
                    let wh = (r * e).extend(1.0) / r.hypot(1.0);
                    let cosine = wo.dot(wh);
                    let wi = 2.0 * cosine * wh - wo;
                    let density = distribution.p22(-r * e) * (spread * r / (cos * cos).max(1e-300));
                    let part = w * half * density * area * attenuation(masking, distribution, wo, wi, wh);
                    if part.is_finite() {
                        sum.ideal += part;
                        sum.grazing += part * schlick_weight(cosine);
                    }
                }
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::beckmann::Beckmann;
    use crate::facets::fresnel::Fresnel;
    use crate::facets::ggx::Ggx;
    use crate::materials::brdf::Brdf;
    use crate::materials::microfacet::Microfacet;
    use crate::random::Random;

    fn viewer(c: f64) -> DVec3 {
        DVec3::new(((1.0 - c) * (1.0 + c)).sqrt(), 0.0, c)
    }

    /// At normal incidence, facets of α = 1 reflect `1 − ln 2`.
    #[test]
    fn a_closed_form() {
        let ggx = Ggx::isotropic(DVec2::ZERO, 1.0);
        let e = directional_albedo(&ggx, Masking::SmithCorrelated, DVec3::Z, None, AlbedoRule::FINE);
        assert!((e.ideal - (1.0 - std::f64::consts::LN_2)).abs() < 1e-12, "{}", e.ideal);
    }

    #[test]
    fn twice_as_many_nodes_change_nothing() {
        let finer = AlbedoRule { azimuths: 8, slopes: 9, order: 20 };
        let cones = [
            None,
            Some(Cone { axis: DVec3::Z, cosine: 0.9 }),
            Some(Cone { axis: DVec3::new(-0.36, 0.48, 0.8), cosine: 0.7 }),
        ];
        let mut worst = [0.0f64; 2];
        for (alpha, c) in [(0.03, 1e-3), (0.03, 0.03), (0.1, 0.3), (0.3, 1e-3), (1.0, 0.02), (1.0, 0.9)] {
            for cone in cones {
                let both = |rule| {
                    let (m, to) = (Masking::SmithCorrelated, viewer(c));
                    let ggx = directional_albedo(&Ggx::isotropic(DVec2::ZERO, alpha), m, to, cone, rule);
                    let beckmann = directional_albedo(&Beckmann::isotropic(DVec2::ZERO, alpha), m, to, cone, rule);
                    [ggx, beckmann]
                };
                for (a, b) in both(AlbedoRule::FINE).into_iter().zip(both(finer)) {
                    let off = (a.ideal - b.ideal).abs().max((a.grazing - b.grazing).abs());
                    let kind = usize::from(cone.is_some());
                    worst[kind] = worst[kind].max(off);
                }
            }
        }
        println!("directional albedo: worst change {:.1e}, with cones {:.1e}", worst[0], worst[1]);
        assert!(worst[0] < 1e-6 && worst[1] < 1e-5, "{worst:?}");
    }

    /// Compares anisotropic facets with samples of the BRDF.
    #[test]
    fn agrees_with_samples() {
        let distribution = Ggx::new(DVec2::ZERO, DVec3::new(0.25, 0.06, 0.05));
        let brdf = Microfacet { distribution, masking: Masking::SmithCorrelated, fresnel: Fresnel::Ideal };
        let wo = viewer(0.5);
        for cone in [None, Some(Cone { axis: DVec3::new(-0.48, 0.36, 0.8), cosine: 0.6 })] {
            let e = directional_albedo(&distribution, Masking::SmithCorrelated, wo, cone, AlbedoRule::FINE);
            let (mut random, n) = (Random::stream(1, 2), 200_000);
            let mut sum = SplitAlbedo::default();
            for _ in 0..n {
                let Some(s) = brdf.sample(wo, DVec2::new(random.unit(), random.unit())) else { continue };
                if cone.is_none_or(|k| k.axis.dot(s.wi) > k.cosine) {
                    sum.ideal += s.throughput.x / f64::from(n);
                    sum.grazing += s.throughput.x * schlick_weight(wo.dot(half_vector(wo, s.wi))) / f64::from(n);
                }
            }
            // The tolerance is four standard errors.
            let off = (sum.ideal - e.ideal).abs().max((sum.grazing - e.grazing).abs());
            assert!(off < 4.0 * 0.5 / f64::from(n).sqrt(), "{sum:?} {e:?}");
        }
    }
}
