//! Where the rings for wide lobes of [`visible_specular`](crate::reflectance::visible::specular) and the two constants of
//! [`shadowed_specular`](crate::reflectance::visible::shadowed_specular) come from: a least-squares fit to the reflection of random lobes in
//! random rough surfaces, with and without shadows.
//!
//! Radius, weight and cover of each ring in wide lobes are free; those for narrow lobes and the azimuths are fixed. Every
//! surface gives four errors: of the radiance without shadows, of the radiance with them, of the lit part of a white room,
//! and of the mean Fresnel term. The first three are measured in units of the 5×5 grid's error over surfaces as rough under
//! lobes as sharp, so that the roughest surfaces do not decide alone; sharp lobes weigh half, the white room threefold.
//!
//! `cargo run --release --example 12_fit_probes` runs it.

use super::CLASSES;
use super::least_squares::least_squares;
use super::specular::{Lobes, SIZE, Sharpness, grid_radiance};
use super::surfaces::{Surface, rough_surfaces, surfaces};
use crate::reflectance::integrals::reference::{visible_extents, visible_mean_panels};
use crate::reflectance::integrals::specular::LOD_MATCHED;
use crate::reflectance::masking::correlated::{direction_area, lit_fraction};
use crate::reflectance::masking::shadowing::Shadowing;
use crate::reflectance::random::Random;
use crate::reflectance::slopes::grid::{normal_of_slope, slope_cholesky};
use crate::reflectance::visible::shadowed_specular::{LitProbe, lit_probe_of};
use crate::reflectance::visible::specular::{
    ProbeNode, ProbeRule, WideRing, solid_angle_lod, visible_probe, visible_probes,
};
use glam::DVec3;
use rayon::prelude::*;

/// Result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct WideProbes {
    /// The rings in wide lobes.
    pub rings: Vec<WideRing>,
    /// `w` and `l` of `shadowed_specular`.
    pub shadows: [f64; 2],
}

struct Item {
    surface: Surface,
    lobes: Lobes,
    /// Radiance without shadows and with them, lit fraction, Schlick's weight.
    truth: [f64; 4],
    /// What each error is divided by.
    unit: [f64; 4],
}

/// Surfaces, lobes, and converged sums.
pub struct ProbeTraining(Vec<Item>);

/// The converged sums of an item.
fn converged(surface: &Surface, lobes: &Lobes, finest: f64) -> [f64; 4] {
    let Surface { wo, m, s } = *surface;
    let panels = visible_extents(wo, s).map(|e| (4.0 + 2.5 * finest.sqrt() * e).ceil() as usize);
    let cholesky = slope_cholesky(s);
    let o = direction_area(wo, m, cholesky);
    let mean = |panels, f: &dyn Fn(DVec3, DVec3, f64) -> DVec3| {
        visible_mean_panels(wo, m, s, panels, |slope| {
            let wn = normal_of_slope(slope);
            let wi = 2.0 * wn.dot(wo) * wn - wo;
            f(wn, wi, lit_fraction(Shadowing::Correlated, &o, &direction_area(wi, m, cholesky)))
        })
    };
    let light = mean(panels, &|_, wi, lit| {
        let radiance = lobes.radiance(wi);
        DVec3::new(radiance, radiance * lit, lit)
    });
    let fresnel = mean([14; 2], &|wn, _, _| DVec3::splat((1.0 - wo.dot(wn)).clamp(0.0, 1.0).powi(5)));
    [light.x, light.y, light.z, fresnel.x]
}

impl ProbeTraining {
    /// `n` surfaces like those of the tables, of another seed, and `rough` ones, half of each under smooth lobes and half
    /// under sharp ones.
    #[must_use]
    pub fn new(n: usize, rough: usize, seed: u64) -> Self {
        let mut all = surfaces(n, seed);
        all.extend(rough_surfaces(rough, seed + 1));
        let mut r = Random(seed + 2);
        let sharpness = |i: usize| if i.is_multiple_of(2) { Sharpness::Smooth } else { Sharpness::Sharp };
        let cases: Vec<(Surface, Lobes)> =
            all.iter().enumerate().map(|(i, s)| (*s, Lobes::random(&mut r, sharpness(i)))).collect();
        let truth: Vec<[f64; 4]> = cases
            .par_iter()
            .enumerate()
            .map(|(i, (surface, lobes))| converged(surface, lobes, sharpness(i).range().1))
            .collect();
        // The grid's mean square error by class and sharpness.
        let class = |s: &Surface| CLASSES.iter().position(|&top| s.roughness() < top).unwrap_or(CLASSES.len() - 1);
        let mut grid = [[(0.0, 0.0); 2]; CLASSES.len()];
        for (i, ((surface, lobes), truth)) in cases.iter().zip(&truth).enumerate() {
            let error = (grid_radiance(surface, lobes, 5, LOD_MATCHED) - truth[0]) / truth[0].max(1.0);
            let (sum, count) = &mut grid[class(surface)][i % 2];
            (*sum, *count) = (*sum + error * error, *count + 1.0);
        }
        let items = cases.into_iter().zip(truth).enumerate().map(|(i, ((surface, lobes), truth))| {
            let grid = grid[class(&surface)].map(|(sum, count): (f64, f64)| (sum / count).sqrt());
            let grid = [grid[0], 2.0 * grid[1]];
            let masked = grid[i % 2] * truth[0].max(1.0);
            let unit = [masked, grid[i % 2] * truth[1].max(0.5), 0.33 * grid[0] * truth[2].max(0.3), 0.012];
            Item { surface, lobes, truth, unit }
        });
        Self(items.collect())
    }

    /// Errors of a rule, four per surface.
    fn errors(&self, nodes: &[ProbeNode], wide: &WideProbes) -> Vec<[f64; 4]> {
        let rule = ProbeRule { nodes, wide: &wide.rings };
        self.0
            .par_iter()
            .map(|item| {
                let Surface { wo, m, s } = item.surface;
                let probes = visible_probes(wo, m, s);
                let o = direction_area(wo, probes.m, probes.cholesky);
                let mut sums = [0.0; 4];
                for node in rule.nodes(probes.wide) {
                    let p = visible_probe(&probes, wo, &node);
                    let LitProbe { lit, wi } = lit_probe_of(
                        wide.shadows,
                        Shadowing::Correlated,
                        &o,
                        p.wi,
                        p.solid_angle,
                        probes.m,
                        probes.cholesky,
                    );
                    let lod = solid_angle_lod(p.solid_angle, SIZE);
                    sums[0] += p.weight * item.lobes.lookup(p.wi, lod);
                    sums[1] += p.weight * lit * item.lobes.lookup(wi, lod);
                    sums[2] += p.weight * lit;
                    sums[3] += p.weight * (1.0 - p.cosine).powi(5);
                }
                std::array::from_fn(|k| (sums[k] - item.truth[k]) / item.unit[k])
            })
            .collect()
    }

    /// Root mean square errors of the rule of these `nodes` in narrow lobes: radiance without shadows and with them, lit
    /// fraction, Fresnel term, in the units of the module's head (the last: of 0.012).
    #[must_use]
    pub fn error(&self, nodes: &[ProbeNode], wide: &WideProbes) -> [f64; 4] {
        let errors = self.errors(nodes, wide);
        std::array::from_fn(|k| (errors.iter().map(|e| e[k] * e[k]).sum::<f64>() / errors.len() as f64).sqrt())
    }
}

/// The unknowns, all positive, as logarithms. Of the first ring, which is the middle, the weight is the unit.
fn unknowns(probes: &WideProbes) -> Vec<f64> {
    let unit = probes.rings[0].weight;
    let of_ring = |(i, r): (usize, &WideRing)| {
        let more = if i > 0 { vec![r.weight / unit, r.radius] } else { vec![] };
        std::iter::once(r.cover).chain(more)
    };
    let rings = probes.rings.iter().enumerate().flat_map(of_ring);
    rings.chain(probes.shadows).map(f64::ln).collect()
}

/// The rings and constants that these unknowns stand for, with rings of as many nodes as `like` has.
fn of_unknowns(p: &[f64], like: &WideProbes) -> WideProbes {
    let mut p = p.iter().map(|p| p.exp());
    let mut next = || p.next().expect("as many unknowns as there are");
    let mut rings: Vec<WideRing> = Vec::new();
    for (i, &WideRing { count, .. }) in like.rings.iter().enumerate() {
        let cover = next();
        let (weight, radius) = if i > 0 { (next(), next()) } else { (1.0, 1.0) };
        rings.push(WideRing { count, radius, weight, cover });
    }
    let sum: f64 = rings.iter().map(|r| r.count as f64 * r.weight).sum();
    rings.iter_mut().for_each(|r| r.weight /= sum);
    WideProbes { rings, shadows: [next(), next()] }
}

/// The rings of wide lobes of least squared error over `training`, from `start`, in at most `steps` steps; `nodes`: of narrow
/// lobes. Errors of more than three units count less than their square.
#[must_use]
pub fn fit_probes(training: &ProbeTraining, nodes: &[ProbeNode], start: &WideProbes, steps: u32) -> WideProbes {
    let residuals = |p: &[f64]| -> Vec<f64> {
        let errors = training.errors(nodes, &of_unknowns(p, start));
        errors.into_iter().flatten().map(|e| e / (1.0 + e * e / 9.0).powf(0.25)).collect()
    };
    of_unknowns(&least_squares(unknowns(start), steps, residuals), start)
}
