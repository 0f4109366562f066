//! What the paper leaves open about its grid, or prints otherwise than its supplement: the half extent `λ`, the divisor of the sum, and
//! the distance between nodes that the footprints of the lookups use.

use super::Row;
use super::diffuse::DiffuseSet;
use super::light::LightSet;
use super::specular::{Lobes, SIZE, SpecularSet};
use super::surfaces::Surface;
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use leadr_reflectance::facets::projected_area::{face_viewer, visible_area};
use leadr_reflectance::integrals::diffuse::{leadr_diffuse_light, visible_normal_moments};
use leadr_reflectance::integrals::specular::{LOD_MATCHED, env_lod, leadr_specular_environment};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::slopes::grid::{facet_area, grid_lambda, grid_nodes, grid_spacing, slope_at, slope_cholesky};
use std::f64::consts::PI;

/// The half extents of the 5×5 grid in the tables. 1.8 is the supplement's (3.4).
pub const EXTENTS: [f64; 8] = [1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.4, 2.6];

/// The number by which an estimator divides its sum over the nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Divisor {
    /// The sum of the weights, so that a constant environment is reproduced exactly (supplement, eq. 10).
    Weights,
    /// The visible area in closed form (eq. 22, Algorithms 1 and 3).
    VisibleArea,
}

/// The distance between nodes in the footprint of a lookup.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// `2λ/(N − 1)`, the true distance (supplement, 3.4).
    Nodes,
    /// `2λ/N` (LEADR §5.2).
    Samples,
}

/// A grid of `n`×`n` slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// The number of nodes per axis.
    pub n: u32,
    /// The half extent in standard deviations.
    pub lambda: f64,
    /// The number by which the sum is divided.
    pub divisor: Divisor,
    /// The distance between nodes in the footprints of lookups.
    pub spacing: Spacing,
}

impl Grid {
    /// Returns the grid of pictures.
    pub fn new(n: u32) -> Self {
        Self { n, lambda: grid_lambda(n), divisor: Divisor::Weights, spacing: Spacing::Nodes }
    }

    /// Returns the quotient of an estimate with this divisor and one that is divided by the weights.
    pub fn scale(self, surface: &Surface) -> f64 {
        if self.divisor == Divisor::Weights {
            return 1.0;
        }
        let Surface { wo, s, .. } = *surface;
        let (m, cholesky) = (self.mean(surface), slope_cholesky(s));
        let (mut sum, mut whole) = (0.0, 0.0);
        for node in grid_nodes(self.n, self.lambda) {
            sum += node.z * facet_area(wo, slope_at(node.xy(), m, cholesky));
            whole += node.z;
        }
        sum / whole / visible_area(wo, m, s).max(1e-12)
    }

    fn mean(self, surface: &Surface) -> DVec2 {
        face_viewer(surface.wo, surface.m, surface.s, self.lambda)
    }

    fn radiance(self, surface: &Surface, lobes: &Lobes) -> f64 {
        let Surface { wo, s, .. } = *surface;
        let spacing = match self.spacing {
            Spacing::Nodes => grid_spacing(self.n, self.lambda),
            Spacing::Samples => 2.0 * self.lambda / f64::from(self.n),
        };
        let m = self.mean(surface);
        let radiance = leadr_specular_environment(Shadowing::None, wo, m, s, DVec3::ONE, self.n, self.lambda, |e| {
            DVec3::splat(lobes.lookup(e.wi, env_lod(wo, e.wn, s, spacing, SIZE, LOD_MATCHED)))
        });
        self.scale(surface) * radiance.reflected.x
    }

    fn cosine(self, surface: &Surface, wi: DVec3) -> f64 {
        let Surface { wo, s, .. } = *surface;
        self.scale(surface) * PI * leadr_diffuse_light(wo, wi, self.mean(surface), s, false, self.n, self.lambda)
    }
}

/// Returns the grids of the tables, with their names.
pub fn grids() -> Vec<(String, Grid)> {
    let extents = EXTENTS.map(|lambda| (format!("5x5, extent {lambda}"), Grid { lambda, ..Grid::new(5) }));
    let divided = [3, 5, 7].into_iter().flat_map(|n| {
        let by_area = Grid { divisor: Divisor::VisibleArea, ..Grid::new(n) };
        [(format!("{n}x{n}, by weights"), Grid::new(n)), (format!("{n}x{n}, by visible area"), by_area)]
    });
    let spaced =
        [3, 5, 7].map(|n| (format!("{n}x{n}, lookups of 2λ/N"), Grid { spacing: Spacing::Samples, ..Grid::new(n) }));
    extents.into_iter().chain(divided).chain(spaced).collect()
}

/// Returns the grids that differ for diffuse facets, which have no lookups.
fn without_lookups() -> impl Iterator<Item = (String, Grid)> {
    grids().into_iter().filter(|(_, grid)| grid.spacing == Spacing::Nodes)
}

impl DiffuseSet {
    /// Measures the grids of [`grids`].
    pub fn printed_rows(&self) -> Vec<Row> {
        let moments =
            |grid: Grid, at: &Surface| visible_normal_moments(at.wo, grid.mean(at), at.s, grid.n, grid.lambda);
        without_lookups()
            .map(|(name, grid)| self.scaled_row(&name, grid.n * grid.n, |at| (grid.scale(at), moments(grid, at))))
            .collect()
    }
}

impl LightSet {
    /// Measures the grids of [`grids`].
    pub fn printed_rows(&self) -> Vec<Row> {
        without_lookups().map(|(name, grid)| self.row(&name, grid.n * grid.n, |at, wi| grid.cosine(at, wi))).collect()
    }
}

impl SpecularSet {
    /// Measures the grids of [`grids`].
    pub fn printed_rows(&self) -> Vec<Row> {
        grids()
            .into_iter()
            .map(|(name, grid)| self.row(&name, grid.n * grid.n, |at, lobes| grid.radiance(at, lobes)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature_study::specular::{Sharpness, grid_radiance};
    use leadr_reflectance::random::Random;

    const SURFACE: Surface =
        Surface { wo: DVec3::new(0.48, 0.36, 0.8), m: DVec2::new(0.2, -0.1), s: DVec3::new(0.09, 0.04, 0.02) };

    #[test]
    fn the_grid_of_pictures_is_among_them() {
        let lobes = Lobes::random(&mut Random(3), Sharpness::Smooth);
        let expected = grid_radiance(&SURFACE, &lobes, 5, LOD_MATCHED);
        assert!((Grid::new(5).radiance(&SURFACE, &lobes) - expected).abs() < 1e-15);
        let is_same = |grid: Grid| {
            (grid.lambda - 1.8).abs() < 1e-9 && Grid { lambda: 1.8, ..grid } == Grid { lambda: 1.8, ..Grid::new(5) }
        };
        let same = grids().into_iter().filter(|(_, grid)| is_same(*grid)).count();
        assert_eq!(same, 2, "the row of its extent and that of its divisor");
    }

    /// Both divisors agree where all of many nodes are seen, and differ with few nodes at the horizon.
    #[test]
    fn the_divisors_differ_by_the_error_of_the_visible_area() {
        let by_area = |n| Grid { divisor: Divisor::VisibleArea, ..Grid::new(n) };
        assert!((by_area(64).scale(&SURFACE) - 1.0).abs() < 1e-3);
        let grazing = Surface { wo: DVec3::new(0.995, 0.0, 0.1), m: DVec2::ZERO, s: DVec3::new(0.25, 0.25, 0.0) };
        let scale = by_area(5).scale(&grazing);
        assert!((scale - 1.0).abs() > 0.01, "{scale}");
    }
}
