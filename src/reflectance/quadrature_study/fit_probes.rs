//! Where the nodes of [`visible_specular`](super::super::visible_specular) and the two constants of
//! [`shadowed_specular`](super::super::shadowed_specular) come from: least squares of what random rough surfaces reflect of
//! random lobes, without shadows and with them.
//!
//! A rule is rings of equal, evenly spaced nodes; of each ring its weight, radius, phase and cover are free, for narrow lobes
//! and for wide ones. Every surface gives four errors: of the radiance without shadows, of the radiance with them, of what is lit
//! in a white room, and of the mean Fresnel term. The first three count in units of what the paper's 5×5 grid errs among surfaces as
//! rough under lobes as sharp, so that the roughest surfaces do not decide alone; sharp lobes by half, the white room threefold.
//!
//! `cargo run --release --example 12_fit_probes` runs it.

use super::super::correlated_masking::{Visibility, direction_area, lit_fraction};
use super::super::reference::{visible_extents, visible_mean_panels};
use super::super::shadowed_specular::{LitProbe, lit_probe_of};
use super::super::slope_grid::{normal_of_slope, slope_cholesky};
use super::super::specular::LOD_MATCHED;
use super::super::visible_specular::{ProbeNode, ProbeRule, solid_angle_lod, visible_probe, visible_probes};
use super::CLASSES;
use super::least_squares::least_squares;
use super::specular::{Lobes, SIZE, Sharpness, grid_radiance};
use super::surfaces::{Random, Surface, rough_surfaces, surfaces};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Evenly spaced nodes of one radius; a single one is in the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// How many.
    pub count: usize,
    /// Distance from the middle, in standard deviations.
    pub radius: f64,
    /// Azimuth of the first, in radians.
    pub phase: f64,
    /// Weight of each, up to a factor that all rings share.
    pub weight: f64,
    /// What each covers ([`ProbeNode::cover`]).
    pub cover: f64,
}

/// A rule of rings, and what shadows take the width of its probes for.
#[derive(Clone, Debug, PartialEq)]
pub struct RingRule {
    /// For narrow lobes.
    pub narrow: Vec<Ring>,
    /// For wide ones: as many rings of as many nodes, then those that only they have.
    pub wide: Vec<Ring>,
    /// `w` and `l` of `shadowed_specular`.
    pub shadows: [f64; 2],
}

/// The nodes of rings, their weights summing to one.
fn ring_nodes(rings: &[Ring]) -> Vec<ProbeNode> {
    let sum: f64 = rings.iter().map(|r| r.count as f64 * r.weight).sum();
    let nodes = |r: &Ring| {
        let Ring { count, radius, phase, weight, cover } = *r;
        (0..count).map(move |i| {
            let place = DVec2::from_angle(phase + TAU * i as f64 / count as f64) * radius;
            ProbeNode { place, weight: weight / sum, cover }
        })
    };
    rings.iter().flat_map(nodes).collect()
}

impl RingRule {
    /// Nodes for narrow lobes and for wide ones.
    #[must_use]
    pub fn nodes(&self) -> (Vec<ProbeNode>, Vec<ProbeNode>) {
        (ring_nodes(&self.narrow), ring_nodes(&self.wide))
    }
}

/// Where a fit may start: `counts` nodes on rings of these radii, weights and covers as the density has them.
#[must_use]
pub fn plain_rings(counts: &[usize], radii: &[f64]) -> Vec<Ring> {
    let ring = |(&count, &radius): (&usize, &f64)| {
        let weight = (-0.5 * radius * radius).exp();
        Ring { count, radius, phase: 0.3, weight, cover: 0.5 / counts.iter().sum::<usize>() as f64 * (1.0 + radius) }
    };
    counts.iter().zip(radii).map(ring).collect()
}

/// The rings, of these numbers of nodes, that `nodes` lie on.
#[must_use]
pub fn rings_of(counts: &[usize], nodes: &[ProbeNode]) -> Vec<Ring> {
    let mut first = 0;
    let ring = |&count: &usize| {
        let ProbeNode { place, weight, cover } = nodes[first];
        first += count;
        Ring { count, radius: place.length(), phase: place.y.atan2(place.x), weight, cover }
    };
    counts.iter().map(ring).collect()
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
            f(wn, wi, lit_fraction(Visibility::Correlated, &o, &direction_area(wi, m, cholesky)))
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
        let sharpness = |i: usize| if i % 2 == 0 { Sharpness::Smooth } else { Sharpness::Sharp };
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
    fn errors(&self, rule: ProbeRule<'_>, shadows: [f64; 2]) -> Vec<[f64; 4]> {
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
                        shadows,
                        Visibility::Correlated,
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

    /// Root mean square errors of a rule: radiance without shadows and with them, lit fraction, Fresnel term, in the units of the
    /// module's head (the last: of 0.012). `shadows`: `w` and `l` of `shadowed_specular`.
    #[must_use]
    pub fn error(&self, rule: ProbeRule<'_>, shadows: [f64; 2]) -> [f64; 4] {
        let errors = self.errors(rule, shadows);
        std::array::from_fn(|k| (errors.iter().map(|e| e[k] * e[k]).sum::<f64>() / errors.len() as f64).sqrt())
    }
}

/// What a fit may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Free {
    /// Rings for narrow lobes.
    pub narrow: bool,
    /// Rings for wide lobes.
    pub wide: bool,
    /// The constants of shadows.
    pub shadows: bool,
}

/// The unknowns. Of the first ring, which may be the middle, the weight is the unit.
fn unknowns(rule: &RingRule, free: Free) -> Vec<f64> {
    let mut p = Vec::new();
    let rings = [(free.narrow, &rule.narrow), (free.wide, &rule.wide)];
    for (_, rings) in rings.into_iter().filter(|(free, _)| *free) {
        for (i, r) in rings.iter().enumerate() {
            p.push(r.cover.ln());
            if i > 0 {
                p.push(r.weight.ln());
            }
            if r.count > 1 {
                p.extend([r.radius, r.phase]);
            }
        }
    }
    if free.shadows {
        p.extend(rule.shadows.map(f64::ln));
    }
    p
}

/// The rule of these unknowns, in the shape of `like`.
fn rule_of(p: &[f64], like: &RingRule, free: Free) -> RingRule {
    let mut p = p.iter().copied();
    let mut rings = |free: bool, like: &[Ring]| -> Vec<Ring> {
        if !free {
            return like.to_vec();
        }
        like.iter()
            .enumerate()
            .map(|(i, r)| {
                let mut next = |free: bool, held: f64| if free { p.next().unwrap_or(held) } else { held };
                let (cover, weight) = (next(true, 0.0).exp(), next(i > 0, 0.0).exp());
                let (radius, phase) = (next(r.count > 1, 0.0), next(r.count > 1, 0.0));
                Ring { count: r.count, radius, phase, weight, cover }
            })
            .collect()
    };
    let (narrow, wide) = (rings(free.narrow, &like.narrow), rings(free.wide, &like.wide));
    let shadows = like.shadows.map(|held| p.next().map_or(held, f64::exp));
    RingRule { narrow, wide, shadows }
}

/// The rule of least squared error over `training`, from `start`, in at most `steps` steps. Errors of more than three units count less than their square.
#[must_use]
pub fn fit_probes(training: &ProbeTraining, start: &RingRule, free: Free, steps: u32) -> RingRule {
    let residuals = |p: &[f64]| -> Vec<f64> {
        let rule = rule_of(p, start, free);
        let (narrow, wide) = rule.nodes();
        let errors = training.errors(ProbeRule { narrow: &narrow, wide: &wide }, rule.shadows);
        errors.into_iter().flatten().map(|e| e / (1.0 + e * e / 9.0).powf(0.25)).collect()
    };
    rule_of(&least_squares(unknowns(start, free), steps, residuals), start, free)
}
