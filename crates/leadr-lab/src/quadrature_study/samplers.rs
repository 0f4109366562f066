//! The samplers that LEADR §6 and §7 and Dupuy's thesis name beside the paper's grid: Gauss–Hermite rules, importance samples of the
//! slopes, the visible-normal rule, and pruned grids.
//!
//! Every sampler is a list of [`Node`]s for one pixel. All estimators divide by the sum of the weights, as the paper's grid does, so a
//! constant environment is reproduced exactly.

use super::Row;
use super::diffuse::DiffuseSet;
use super::light::LightSet;
use super::specular::{Lobes, SIZE, SpecularSet};
use super::surfaces::Surface;
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use leadr_reflectance::facets::normal_distribution::{normal_pdf, normal_quantile};
use leadr_reflectance::facets::projected_area::face_viewer;
use leadr_reflectance::integrals::diffuse::NormalMoments;
use leadr_reflectance::integrals::slope_nodes::{NodePlacement, SlopeNode, slope_nodes};
use leadr_reflectance::integrals::specular::{
    LOD_ALGORITHM_1, LOD_MATCHED, LOD_SUPPLEMENT, LOD_SUPPLEMENT_5, LOD_SUPPLEMENT_32, environment_sample_at,
};
use leadr_reflectance::quadrature::gauss_hermite;
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::{
    facet_area, grid_lambda, grid_nodes, grid_spacing, normal_of_slope, slope_at, slope_cholesky,
};
use std::f64::consts::TAU;

/// The numbers of nodes per axis in the tables.
pub const ORDERS: [u32; 4] = [3, 5, 7, 9];

/// A placement of `n`² nodes over the slopes of a pixel, or of fewer where nodes are left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampler {
    /// The paper's grid (LEADR §5.1).
    Grid,
    /// The paper's grid without the nodes of small weight ([`Pruning`]).
    PrunedGrid(Pruning),
    /// The product of two Gauss–Hermite rules (LEADR §6).
    GaussHermite,
    /// [`Sampler::GaussHermite`] without the nodes of small weight.
    PrunedGaussHermite(Pruning),
    /// One random slope of `P22` per cell of an `n`×`n` grid over the unit square, by the inverse of the normal distribution
    /// along both axes (LEADR §6). Every surface has its own samples.
    Stratified {
        /// Another seed gives other samples.
        seed: u64,
    },
    /// Slopes of `P22` at the points of Hammersley's set, by a radius and an angle as in Colbert and Křivánek 2007. All pixels
    /// use the same points.
    Hammersley,
    /// Visible normals at `u = j/n`, or at the centres of the cells of `u` (thesis eq. 2.18–2.23 and §3.4).
    VisibleNormals {
        /// Whether the points are the centres. Those of the thesis are not.
        centred: bool,
    },
}

/// A rule that leaves nodes of small weight out (LEADR §7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pruning {
    /// Leave out nodes whose weight is below `w₁ w_mid / n`, with the first and the middle weight of the rule of one axis, whose
    /// sum is 1. This is the threshold of Jäckel 2005.
    Jaeckel,
    /// Leave out the lightest nodes, as long as their sum is at most this fraction of the total weight.
    Fraction(f64),
}

/// One node of a sampler.
pub type Node = SlopeNode;

/// The footprint of a lookup in the environment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// No filter: the finest level of the mip chain.
    Unfiltered,
    /// The solid angle that the node stands for, from the density of the samples (Křivánek and Colbert 2008).
    Density,
    /// Like [`Filter::Density`], but with the larger slope deviation on both axes (LEADR §5.2).
    Widest,
}

/// Returns the points of Hammersley's set of `count` points in the unit square, shifted by half a step so that no coordinate is 0.
pub fn hammersley(count: u32) -> impl Iterator<Item = DVec2> {
    let bits = count.next_power_of_two().trailing_zeros();
    let half_step = 0.5 / f64::from(1u32 << bits);
    (0..count).map(move |i| {
        let inverse = f64::from(i.reverse_bits()) / 2f64.powi(32);
        DVec2::new((f64::from(i) + 0.5) / f64::from(count), inverse + half_step)
    })
}

/// Keeps the heavy nodes `(x, y, weight)` of an `n`×`n` product rule.
fn pruned(mut nodes: Vec<DVec3>, n: u32, pruning: Pruning) -> Vec<DVec3> {
    let total: f64 = nodes.iter().map(|p| p.z).sum();
    let threshold = match pruning {
        // Node `n / 2` has the first weight along one axis and the middle weight along the other.
        Pruning::Jaeckel => nodes[(n / 2) as usize].z / f64::from(n),
        Pruning::Fraction(fraction) => {
            let mut weights: Vec<f64> = nodes.iter().map(|p| p.z).collect();
            weights.sort_by(f64::total_cmp);
            // Symmetric nodes have weights that differ by rounding, and leave together.
            let mut sum = 0.0;
            let mut threshold = 0.0;
            for group in weights.chunk_by(|a, b| b - a < 1e-9 * total) {
                sum += group.iter().sum::<f64>();
                if sum > fraction * total {
                    break;
                }
                threshold = group[group.len() - 1] * (1.0 + 1e-6);
            }
            threshold
        }
    };
    nodes.retain(|p| p.z >= threshold);
    nodes
}

/// Returns the nodes `(x, y, weight)` of the paper's grid in standard normal coordinates.
fn grid(n: u32) -> Vec<DVec3> {
    grid_nodes(n, grid_lambda(n)).collect()
}

/// Returns the nodes `(x, y, weight)` of the product of two Gauss–Hermite rules.
fn hermite(n: u32) -> Vec<DVec3> {
    let rule = gauss_hermite(n as usize);
    rule.iter().flat_map(|a| rule.iter().map(move |b| DVec3::new(a.0, b.0, a.1 * b.1))).collect()
}

impl Sampler {
    /// Returns the name in the tables, such as `Gauss-Hermite 5x5`.
    pub fn name(self, n: u32) -> String {
        let of = |pruning| match pruning {
            Pruning::Jaeckel => ", Jäckel".to_owned(),
            Pruning::Fraction(f) => format!(", {} % less", 100.0 * f),
        };
        match self {
            Self::Grid => format!("paper {n}x{n}"),
            Self::PrunedGrid(p) => format!("pruned paper {n}x{n}{}", of(p)),
            Self::GaussHermite => format!("Gauss-Hermite {n}x{n}"),
            Self::PrunedGaussHermite(p) => format!("pruned Gauss-Hermite {n}x{n}{}", of(p)),
            Self::Stratified { .. } => format!("stratified {n}x{n}"),
            Self::Hammersley => format!("Hammersley {n}x{n}"),
            Self::VisibleNormals { centred: false } => format!("visible-normal {n}x{n}, j/N"),
            Self::VisibleNormals { .. } => format!("visible-normal {n}x{n}, centred"),
        }
    }

    /// Returns the nodes over the slopes of `P22` in standard normal coordinates, with weights and cells, or `None` for the placements that
    /// pictures have.
    fn slopes_of_p22(self, surface: &Surface, n: u32) -> Option<Vec<(DVec2, f64, f64)>> {
        let density = |p: DVec2| normal_pdf(p.x) * normal_pdf(p.y);
        let even = |p: DVec2| (p, 1.0, 1.0 / (f64::from(n * n) * density(p)).max(1e-12));
        let spaced = |nodes: Vec<DVec3>| {
            let cell = grid_spacing(n, grid_lambda(n)).powi(2);
            nodes.into_iter().map(|p| (p.xy(), p.z, cell)).collect()
        };
        let weighted =
            |nodes: Vec<DVec3>| nodes.into_iter().map(|p| (p.xy(), p.z, p.z / density(p.xy()).max(1e-12))).collect();
        Some(match self {
            Self::PrunedGrid(pruning) => spaced(pruned(grid(n), n, pruning)),
            Self::GaussHermite => weighted(hermite(n)),
            Self::PrunedGaussHermite(pruning) => weighted(pruned(hermite(n), n, pruning)),
            Self::Stratified { seed } => {
                let mut r = Random::stream(seed, surface.wo.x.to_bits() ^ surface.m.y.to_bits().rotate_left(32));
                let mut at = |i: u32| normal_quantile((f64::from(i) + r.unit()) / f64::from(n));
                (0..n * n).map(|i| even(DVec2::new(at(i % n), at(i / n)))).collect()
            }
            Self::Hammersley => hammersley(n * n)
                .map(|u| even(DVec2::from_angle(TAU * u.y) * (-2.0 * (1.0 - u.x).ln()).sqrt()))
                .collect(),
            Self::Grid | Self::VisibleNormals { .. } => return None,
        })
    }

    /// Returns the nodes for a pixel.
    pub fn nodes(self, surface: &Surface, n: u32) -> Vec<Node> {
        let Surface { wo, m, s } = *surface;
        let c = slope_cholesky(s);
        let placement = match self {
            Self::Grid => Some(NodePlacement::Grid),
            Self::PrunedGrid(Pruning::Jaeckel) => Some(NodePlacement::Pruned),
            Self::VisibleNormals { centred: false } => Some(NodePlacement::VisibleNormals),
            Self::VisibleNormals { centred: true } => Some(NodePlacement::CentredNormals),
            _ => None,
        };
        if let Some(placement) = placement {
            return slope_nodes(placement, wo, m, s, n).all(wo).collect();
        }
        let m = face_viewer(wo, m, s, grid_lambda(n));
        let node = |(p, weight, cell): (DVec2, f64, f64)| {
            let slope = slope_at(p, m, c);
            Node { slope, weight: weight * facet_area(wo, slope), cell }
        };
        self.slopes_of_p22(surface, n).into_iter().flatten().map(node).collect()
    }

    /// Returns the number of nodes.
    pub fn count(self, n: u32) -> u32 {
        let some = Surface { wo: DVec3::Z, m: DVec2::ZERO, s: DVec3::new(0.1, 0.1, 0.0) };
        self.nodes(&some, n).len() as u32
    }
}

/// Computes the moments of the visible normals.
pub fn moments(nodes: &[Node]) -> NormalMoments {
    let norm = nodes.iter().map(|p| p.weight).sum::<f64>().max(1e-12);
    let mean =
        |f: fn(DVec3) -> DVec3| nodes.iter().map(|p| p.weight * f(normal_of_slope(p.slope))).sum::<DVec3>() / norm;
    NormalMoments { mean: mean(|n| n), diag: mean(|n| n * n), off: mean(|n| n.yzx() * n.zxy()) }
}

/// Computes the mean clamped cosine of the visible facets for a light from `wi`.
pub fn cosine(nodes: &[Node], wi: DVec3) -> f64 {
    let norm = nodes.iter().map(|p| p.weight).sum::<f64>().max(1e-12);
    nodes.iter().map(|p| p.weight * wi.dot(normal_of_slope(p.slope)).max(0.0)).sum::<f64>() / norm
}

/// Returns the solid angle of the reflected directions of a node, in steradians.
pub fn solid_angle(surface: &Surface, node: &Node, filter: Filter) -> f64 {
    let c = slope_cholesky(surface.s);
    let unit = match filter {
        Filter::Unfiltered => return 0.0,
        Filter::Density => c.x * c.z,
        Filter::Widest => surface.s.x.max(surface.s.y),
    };
    let wn = normal_of_slope(node.slope);
    4.0 * wn.dot(surface.wo).abs() * wn.z.powi(3) * unit * node.cell
}

/// Computes the radiance of specular facets.
pub fn radiance(surface: &Surface, lobes: &Lobes, nodes: &[Node], filter: Filter) -> f64 {
    let (mut sum, mut norm) = (0.0, 0.0);
    for node in nodes {
        let e = environment_sample_at(surface.wo, node.slope);
        let lod = 0.5 * solid_angle(surface, node, filter).max(1e-12).log2() + SIZE.log2() + LOD_MATCHED;
        sum += node.weight * lobes.lookup(e.wi, lod);
        norm += node.weight;
    }
    sum / norm.max(1e-12)
}

/// The pruned grids and rules of the tables.
const PRUNED: [(Sampler, u32); 8] = [
    (Sampler::PrunedGrid(Pruning::Jaeckel), 5),
    (Sampler::PrunedGrid(Pruning::Jaeckel), 7),
    (Sampler::PrunedGrid(Pruning::Jaeckel), 9),
    (Sampler::PrunedGrid(Pruning::Fraction(0.05)), 7),
    (Sampler::PrunedGrid(Pruning::Fraction(0.05)), 9),
    (Sampler::PrunedGaussHermite(Pruning::Jaeckel), 5),
    (Sampler::PrunedGaussHermite(Pruning::Jaeckel), 7),
    (Sampler::PrunedGaussHermite(Pruning::Jaeckel), 9),
];

/// Returns the samplers of the tables, with their numbers of nodes per axis.
pub fn samplers() -> impl Iterator<Item = (Sampler, u32)> {
    let full = [
        Sampler::Grid,
        Sampler::GaussHermite,
        Sampler::Stratified { seed: 0 },
        Sampler::Hammersley,
        Sampler::VisibleNormals { centred: false },
        Sampler::VisibleNormals { centred: true },
    ];
    full.into_iter().flat_map(|sampler| ORDERS.map(|n| (sampler, n))).chain(PRUNED)
}

impl DiffuseSet {
    /// Measures the samplers that the papers compare with the grid.
    pub fn sampler_rows(&self) -> Vec<Row> {
        samplers().map(|(s, n)| self.row(&s.name(n), s.count(n), |at| moments(&s.nodes(at, n)))).collect()
    }
}

impl LightSet {
    /// Measures the samplers that the papers compare with the grid.
    pub fn sampler_rows(&self) -> Vec<Row> {
        samplers().map(|(s, n)| self.row(&s.name(n), s.count(n), |at, wi| cosine(&s.nodes(at, n), wi))).collect()
    }
}

impl SpecularSet {
    /// Measures the samplers that the papers compare with the grid, with the paper's filter and with the filter by density.
    /// Importance samples also have rows without a filter.
    pub fn sampler_rows(&self) -> Vec<Row> {
        let mut rows = Vec::new();
        for (sampler, n) in samplers() {
            let filters: &[(Filter, &str)] = match sampler {
                Sampler::Stratified { .. } | Sampler::Hammersley => {
                    &[(Filter::Unfiltered, ", unfiltered"), (Filter::Density, ", by density"), (Filter::Widest, "")]
                }
                Sampler::PrunedGrid(_) | Sampler::PrunedGaussHermite(_) => &[(Filter::Widest, "")],
                _ => &[(Filter::Widest, ""), (Filter::Density, ", by density")],
            };
            for &(filter, suffix) in filters {
                let name = sampler.name(n) + suffix;
                rows.push(
                    self.row(&name, sampler.count(n), |s, lobes| radiance(s, lobes, &sampler.nodes(s, n), filter)),
                );
            }
        }
        rows
    }

    /// Measures the paper's grid with each constant of the level of detail that the paper and its supplement give (supplement 3.5).
    pub fn lod_rows(&self) -> Vec<Row> {
        let row = |n, name, constant: f64| self.grid_row(n, &format!(", LOD {constant}{name}"), constant);
        vec![
            row(5, ", supplement's for 5x5", LOD_SUPPLEMENT_5),
            row(5, ", matched", LOD_MATCHED),
            row(5, ", supplement's", LOD_SUPPLEMENT),
            row(5, ", Algorithm 1", LOD_ALGORITHM_1),
            row(32, ", supplement's for 32x32", LOD_SUPPLEMENT_32),
            row(32, ", matched", LOD_MATCHED),
            row(32, ", supplement's", LOD_SUPPLEMENT),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SURFACE: Surface =
        Surface { wo: DVec3::new(0.48, 0.36, 0.8), m: DVec2::new(0.2, -0.1), s: DVec3::new(0.09, 0.04, 0.02) };

    #[test]
    fn dense_samplers_have_the_same_moments() {
        let exact = moments(&Sampler::Grid.nodes(&SURFACE, 128)).mean;
        for (sampler, bound) in [
            (Sampler::GaussHermite, 1e-4),
            (Sampler::PrunedGaussHermite(Pruning::Jaeckel), 1e-3),
            (Sampler::Stratified { seed: 0 }, 3e-3),
            (Sampler::Hammersley, 3e-3),
            (Sampler::VisibleNormals { centred: true }, 3e-3),
        ] {
            let found = moments(&sampler.nodes(&SURFACE, 40)).mean;
            assert!((found - exact).length() < bound, "{sampler:?}: {found} instead of {exact}");
        }
    }

    #[test]
    fn cells_cover_the_slopes_once() {
        // The density of the samples times the cells is 1 on average, so the cells have the area of the plane that is sampled.
        let grid = Sampler::Grid.nodes(&SURFACE, 9);
        let centred = Sampler::VisibleNormals { centred: true }.nodes(&SURFACE, 9);
        let hermite = Sampler::GaussHermite.nodes(&SURFACE, 9);
        let smallest = |nodes: &[Node]| nodes.iter().map(|p| p.cell).fold(f64::INFINITY, f64::min);
        assert!((grid[0].cell - 0.5625).abs() < 1e-12);
        assert!((0.05..0.12).contains(&smallest(&centred)), "{}", smallest(&centred));
        assert!((0.9..1.2).contains(&smallest(&hermite)), "{}", smallest(&hermite));
    }

    #[test]
    fn pruning_keeps_symmetric_nodes() {
        assert_eq!(Sampler::PrunedGrid(Pruning::Fraction(0.0)).count(9), 81);
        for pruning in [Pruning::Jaeckel, Pruning::Fraction(0.05)] {
            for n in ORDERS {
                let kept = pruned(grid(n), n, pruning);
                let total: f64 = grid(n).iter().map(|p| p.z).sum();
                let rest: f64 = kept.iter().map(|p| p.z).sum();
                assert!(kept.iter().map(|p| p.xy()).sum::<DVec2>().length() < 1e-12, "{pruning:?} {n}");
                assert!(rest > 0.94 * total && kept.len() as u32 <= n * n, "{pruning:?} {n}: {}", rest / total);
            }
        }
    }

    #[test]
    fn hammersley_points_are_even() {
        let points: Vec<DVec2> = hammersley(25).collect();
        let mean = points.iter().sum::<DVec2>() / 25.0;
        assert!((mean.x - 0.5).abs() < 1e-12 && (mean.y - 0.5).abs() < 0.05);
        assert!(points.iter().all(|p| p.min_element() > 0.0 && p.max_element() < 1.0));
        assert_eq!(points[1].y, 0.5 + 1.0 / 64.0);
    }
}
