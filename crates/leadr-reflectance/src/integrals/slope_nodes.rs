//! Placements of the `N × N` samples of a pixel: the paper's grid, the same grid without its lightest nodes or with an artificial
//! micronormal, and the visible normals of Dupuy's thesis.
//!
//! *Pruned.* A product rule with the weights `wⱼ wₖ` leaves out the nodes that are lighter than `w₁ w_mid / N`, with the first and the middle
//! weight of the rule of one axis (Jäckel 2005; LEADR §7). For the weights `exp(−p²/2)` of the grid, these are the nodes outside the circle
//! `|p|² = λ² + p_mid² + 2 ln N`.
//!
//! *Artificial micronormal.* If the mesonormal faces away, all nodes of the grid can be invisible. One more sample then faces the viewer
//! ([`artificial_micronormal`], LEADR supplement 3.7). The other placements turn the mesonormal with [`face_viewer`].
//!
//! *Visible normals.* Thesis eq. 2.23 and §3.4 map the unit square to the visible normals and take the points `u = j/N`. All samples then
//! have the weight 1. `u = 0` is the end of the distribution, so a sample stands for its cell better at `u = (j + ½)/N`. The
//! quantiles read 0 as 2⁻³², and as 2⁻²⁵ in shaders (6.2 and 5.4 deviations).
//!
//! The solid angle of the light of a sample follows from the density of the samples, with the larger deviation of the slopes on both axes
//! (LEADR §5.2, thesis §3.4).

use super::diffuse::NormalMoments;
use super::specular::{EnvironmentSample, SpecularTerm, environment_sample_at};
use crate::facets::beckmann_sampling::visible_slope_quantile;
use crate::facets::fresnel::fresnel_schlick;
use crate::facets::normal_distribution::{normal_pdf, normal_quantile};
use crate::facets::projected_area::{ARTIFICIAL_WEIGHT, artificial_micronormal, face_viewer, meso_area, visible_area};
use crate::masking::correlated::{direction_area, lit_fraction};
use crate::masking::shadowing::Shadowing;
use crate::masking::smith::shadowing_given_masking;
use crate::slopes::grid::{
    facet_area, grid_lambda, grid_node, grid_spacing, normal_of_slope, slope_at, slope_cholesky,
};
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::PI;

/// A placement of samples. The numbers equal the `LEADR_NODES_` constants in `leadr/integrals/slope_nodes.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NodePlacement {
    /// The grid of the paper (LEADR §5.1).
    Grid = 0,
    /// The grid without its lightest nodes (Jäckel 2005).
    Pruned = 1,
    /// The grid of the paper and the artificial micronormal (LEADR supplement 3.7).
    Micronormal = 2,
    /// Visible normals at `u = j/N` (thesis eq. 2.23 and §3.4).
    VisibleNormals = 3,
    /// Visible normals at `u = (j + ½)/N`.
    CentredNormals = 4,
}

impl NodePlacement {
    /// All placements, in numeric order.
    pub const ALL: [Self; 5] =
        [Self::Grid, Self::Pruned, Self::Micronormal, Self::VisibleNormals, Self::CentredNormals];

    /// Whether the samples are visible normals, not nodes of a grid.
    const fn of_normals(self) -> bool {
        matches!(self, Self::VisibleNormals | Self::CentredNormals)
    }

    /// Returns the name on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Grid => "even",
            Self::Pruned => "pruned",
            Self::Micronormal => "micronormal",
            Self::VisibleNormals => "visible-normals",
            Self::CentredNormals => "centred-normals",
        }
    }

    /// Returns a one-line help text.
    pub const fn help(self) -> &'static str {
        match self {
            Self::Grid => "The even grid of the paper",
            Self::Pruned => "The even grid without its lightest nodes (Jaeckel 2005)",
            Self::Micronormal => "The even grid and an artificial micronormal (LEADR supplement 3.7)",
            Self::VisibleNormals => "Visible normals at u = j/N (thesis section 3.4)",
            Self::CentredNormals => "Visible normals at the centres of the cells of u",
        }
    }
}

/// The quantities that all samples of a pixel share.
#[derive(Clone, Copy, Debug)]
pub struct SlopeNodes {
    placement: NodePlacement,
    n: u32,
    lambda: f64,
    m: DVec2,
    cholesky: DVec3,
    /// The azimuth of the viewer, in the space where the slopes are isotropic.
    along: DVec2,
    /// The projected area of the mesosurface, in units of the spread of slopes along this azimuth.
    nu: f64,
    /// The visible area.
    area: f64,
    /// The largest square of the distance of a pruned node from the mean, in standard deviations.
    farthest: f64,
}

/// One sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeNode {
    /// The slope of the facet.
    pub slope: DVec2,
    /// The weight, which contains the visible area of the facet. Weights are not normalised. Samples that are left out have 0.
    pub weight: f64,
    /// The area of slopes that the sample stands for, in units of the determinant of the Cholesky factor.
    pub cell: f64,
}

/// Returns `n × n` samples of the slopes with the mean `m` and the covariance `s`, as seen from the unit vector `wo`.
pub fn slope_nodes(placement: NodePlacement, wo: DVec3, m: DVec2, s: DVec3, n: u32) -> SlopeNodes {
    let (lambda, cholesky) = (grid_lambda(n), slope_cholesky(s));
    let t = DVec2::new(cholesky.x * wo.x + cholesky.y * wo.y, cholesky.z * wo.y);
    let middle = grid_node(n / 2, 0, n, lambda).x;
    SlopeNodes {
        placement,
        n,
        lambda,
        m: match placement {
            NodePlacement::Grid | NodePlacement::Pruned => face_viewer(wo, m, s, lambda),
            _ => m,
        },
        cholesky,
        along: t.try_normalize().unwrap_or(DVec2::X),
        nu: (meso_area(wo, m) / t.length().max(1e-18)).clamp(-1e15, 1e15),
        area: visible_area(wo, m, s),
        farthest: lambda * lambda + middle * middle + 2.0 * f64::from(n).ln(),
    }
}

impl SlopeNodes {
    /// Returns the standard normal coordinate of a row of samples: along the viewer's azimuth for visible normals, else along the first axis.
    pub fn row(&self, j: u32) -> f64 {
        if self.placement.of_normals() {
            visible_slope_quantile(self.uniform(j), self.nu)
        } else {
            grid_node(j, 0, self.n, self.lambda).x
        }
    }

    fn uniform(&self, j: u32) -> f64 {
        let offset = if self.placement == NodePlacement::CentredNormals { 0.5 } else { 0.0 };
        (f64::from(j) + offset) / f64::from(self.n)
    }

    /// Returns sample `k` of the row with the coordinate `row`.
    pub fn node(&self, wo: DVec3, row: f64, k: u32) -> SlopeNode {
        if !self.placement.of_normals() {
            let p = DVec2::new(row, grid_node(0, k, self.n, self.lambda).y);
            let (slope, square) = (slope_at(p, self.m, self.cholesky), p.length_squared());
            let kept = self.placement != NodePlacement::Pruned || square <= self.farthest * (1.0 + 1e-6);
            let weight = if kept { (-0.5 * square).exp() * facet_area(wo, slope) } else { 0.0 };
            return SlopeNode { slope, weight, cell: grid_spacing(self.n, self.lambda).powi(2) };
        }
        let p = DVec2::new(row, normal_quantile(self.uniform(k)));
        let slope = slope_at(self.along.rotate(p), self.m, self.cholesky);
        let density = normal_pdf(p.x) * normal_pdf(p.y) * facet_area(wo, slope) / self.area.max(1e-12);
        SlopeNode { slope, weight: 1.0, cell: 1.0 / (f64::from(self.n * self.n) * density).max(1e-12) }
    }

    /// Returns the artificial micronormal, whose weight is 10⁻⁵ of the sum of the grid's weights times its own visible area. It has the
    /// weight 0 with other placements, and where it is no slope.
    pub fn artificial(&self, wo: DVec3) -> SlopeNode {
        let cell = grid_spacing(self.n, self.lambda).powi(2);
        let n = artificial_micronormal(wo, normal_of_slope(self.m));
        let slope = -n.xy() / n.z.max(1e-3);
        if self.placement != NodePlacement::Micronormal || n.z <= 1e-3 {
            return SlopeNode { slope, weight: 0.0, cell };
        }
        let of_axis: f64 = (0..self.n).map(|j| (-0.5 * self.row(j).powi(2)).exp()).sum();
        SlopeNode { slope, weight: ARTIFICIAL_WEIGHT * of_axis * of_axis * facet_area(wo, slope), cell }
    }

    /// Returns all samples. Those that are left out are missing.
    pub fn all(&self, wo: DVec3) -> impl Iterator<Item = SlopeNode> {
        let rows = (0..self.n).map(|j| self.row(j));
        let nodes = rows.flat_map(move |row| (0..self.n).map(move |k| self.node(wo, row, k)));
        nodes.chain([self.artificial(wo)]).filter(|node| node.weight > 0.0)
    }
}

/// Computes the moments of the visible normals, like [`visible_normal_moments`](super::diffuse::visible_normal_moments) on the even grid.
pub fn node_normal_moments(placement: NodePlacement, wo: DVec3, m: DVec2, s: DVec3, n: u32) -> NormalMoments {
    let mut sum = NormalMoments { mean: DVec3::ZERO, diag: DVec3::ZERO, off: DVec3::ZERO };
    let mut norm = 0.0;
    for node in slope_nodes(placement, wo, m, s, n).all(wo) {
        let (wn, w) = (normal_of_slope(node.slope), node.weight);
        sum.mean += w * wn;
        sum.diag += w * wn * wn;
        sum.off += w * wn.yzx() * wn.zxy();
        norm += w;
    }
    let scale = 1.0 / norm.max(1e-12);
    NormalMoments { mean: sum.mean * scale, diag: sum.diag * scale, off: sum.off * scale }
}

/// Returns the diffuse radiance per unit of albedo under one light, like [`leadr_diffuse_light`](super::diffuse::leadr_diffuse_light) on the
/// even grid.
pub fn node_diffuse_light(
    placement: NodePlacement,
    wo: DVec3,
    wi: DVec3,
    m: DVec2,
    s: DVec3,
    shadowing: bool,
    n: u32,
) -> f64 {
    let (mut sum, mut norm) = (0.0, 0.0);
    for node in slope_nodes(placement, wo, m, s, n).all(wo) {
        sum += node.weight * wi.dot(normal_of_slope(node.slope)).max(0.0);
        norm += node.weight;
    }
    shadowing_given_masking(wo, wi, m, s, shadowing) * sum / norm.max(1e-12) / PI
}

/// Computes the specular term of an environment, like [`leadr_specular_environment`](super::specular::leadr_specular_environment) on the even
/// grid.
pub fn node_specular_environment(
    placement: NodePlacement,
    shadowing: Shadowing,
    wo: DVec3,
    m: DVec2,
    s: DVec3,
    f0: DVec3,
    n: u32,
    radiance: impl Fn(&EnvironmentSample) -> DVec3,
) -> SpecularTerm {
    let nodes = slope_nodes(placement, wo, m, s, n);
    let o = direction_area(wo, nodes.m, nodes.cholesky);
    let mut sum = SpecularTerm::default();
    for node in nodes.all(wo) {
        let e = environment_sample_at(wo, node.slope);
        let f = node.weight * fresnel_schlick(f0, wo.dot(e.wn));
        sum.reflected += f * lit_fraction(shadowing, &o, &direction_area(e.wi, nodes.m, nodes.cholesky)) * radiance(&e);
        sum.fresnel += f;
        sum.weight += node.weight;
    }
    let scale = 1.0 / sum.weight.max(1e-12);
    SpecularTerm { reflected: sum.reflected * scale, fresnel: sum.fresnel * scale, weight: 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrals::diffuse::{leadr_diffuse_light, visible_normal_moments};

    const S: DVec3 = DVec3::new(0.09, 0.04, 0.02);
    const M: DVec2 = DVec2::new(0.2, -0.1);

    fn wo() -> DVec3 {
        DVec3::new(0.48, 0.36, 0.8)
    }

    #[test]
    fn the_even_placement_is_the_grid() {
        let (lambda, wi) = (grid_lambda(7), DVec3::new(-0.3, 0.1, 0.9).normalize());
        let found = node_normal_moments(NodePlacement::Grid, wo(), M, S, 7);
        let want = visible_normal_moments(wo(), face_viewer(wo(), M, S, lambda), S, 7, lambda);
        assert!((found.mean - want.mean).length() < 1e-12 && (found.off - want.off).length() < 1e-12);
        let light = node_diffuse_light(NodePlacement::Grid, wo(), wi, M, S, false, 7);
        assert!((light - leadr_diffuse_light(wo(), wi, M, S, false, 7, lambda)).abs() < 1e-12);
    }

    /// The counts of Jäckel's table in docs/measurements/quadrature.md.
    #[test]
    fn pruning_keeps_the_heavy_nodes() {
        for (n, kept) in [(1, 1), (3, 9), (5, 21), (7, 45), (9, 69)] {
            let nodes: Vec<SlopeNode> =
                slope_nodes(NodePlacement::Pruned, DVec3::Z, DVec2::ZERO, S, n).all(DVec3::Z).collect();
            assert_eq!(nodes.len(), kept, "{n}");
            assert!(nodes.iter().map(|node| node.slope).sum::<DVec2>().length() < 1e-12);
        }
    }

    #[test]
    fn dense_placements_agree() {
        let exact = visible_normal_moments(wo(), M, S, 128, grid_lambda(128)).mean;
        for (placement, most) in [
            (NodePlacement::Pruned, 3e-4),
            (NodePlacement::CentredNormals, 3e-3),
            // The thesis has a row at the end of the distribution.
            (NodePlacement::VisibleNormals, 0.03),
        ] {
            let found = node_normal_moments(placement, wo(), M, S, 60).mean;
            assert!((found - exact).length() < most, "{placement:?}: {found} for {exact}");
        }
        let thesis = node_normal_moments(NodePlacement::VisibleNormals, wo(), M, S, 9).mean;
        let centred = node_normal_moments(NodePlacement::CentredNormals, wo(), M, S, 9).mean;
        assert!((thesis - exact).length() > 3.0 * (centred - exact).length());
    }

    /// The supplement's sample decides where no other is visible, and nowhere else.
    #[test]
    fn the_micronormal_counts_where_nothing_else_is_visible() {
        let (wo, away) = (DVec3::new(0.6, 0.0, 0.8), DVec2::new(2.0, 0.0));
        let s = DVec3::new(1e-4, 1e-4, 0.0);
        let nodes: Vec<SlopeNode> = slope_nodes(NodePlacement::Micronormal, wo, away, s, 5).all(wo).collect();
        let [only] = nodes[..] else { panic!("{nodes:?}") };
        let expected = artificial_micronormal(wo, normal_of_slope(away));
        assert!((normal_of_slope(only.slope) - expected).length() < 1e-12 && wo.dot(expected) > 0.0);
        assert!((node_normal_moments(NodePlacement::Micronormal, wo, away, s, 5).mean - expected).length() < 1e-12);
        for (m, s) in [(M, S), (DVec2::new(1.4, 0.3), S)] {
            let [found, even] = [NodePlacement::Micronormal, NodePlacement::Grid]
                .map(|placement| node_normal_moments(placement, wo, m, s, 5).mean);
            assert!((found - even).length() < 1e-3, "{m}: {found}, {even}");
        }
    }

    /// The mean of one over the density, over visible slopes, is the area of the slopes that are sampled. Cells cover it once.
    #[test]
    fn cells_belong_to_the_density() {
        for placement in [NodePlacement::Grid, NodePlacement::CentredNormals] {
            let nodes: Vec<SlopeNode> = slope_nodes(placement, DVec3::Z, DVec2::ZERO, S, 65).all(DVec3::Z).collect();
            // The normal density integrates to one.
            let inverse = 1.0 / (S.x * S.y - S.z * S.z);
            let square = |x: DVec2| inverse * (S.y * x.x * x.x + S.x * x.y * x.y - 2.0 * S.z * x.x * x.y);
            let sum: f64 = nodes.iter().map(|node| node.cell * (-0.5 * square(node.slope)).exp() / (2.0 * PI)).sum();
            assert!((sum - 1.0).abs() < 0.01, "{placement:?}: {sum}");
        }
    }
}
