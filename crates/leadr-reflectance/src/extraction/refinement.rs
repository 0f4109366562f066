//! Refines a fit with directions other than backscattering. Alternating updates of the slopes, the Fresnel term and a diffuse term increase
//! the likelihood of the whole material.
//!
//! The thesis takes the slopes from backscattering, where instruments are least accurate. It has no diffuse term, and puts all residuals
//! into the Fresnel term. This module fits `f_r = F(θ_d) D(h) g + k/π` to all pairs of directions, where `g` is the geometric factor of the
//! previous slopes. The multiplicative Richardson–Lucy steps keep every factor positive and lower the Kullback–Leibler divergence. This
//! divergence is a compromise between absolute errors, which highlights dominate, and relative errors, which shadows dominate.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, TAU};

use glam::DVec3;

use super::samples::{Sample, direction};
use crate::facets::fresnel::{Fresnel, FresnelTable};
use crate::facets::radial_table::{angle_at, u_of_angle};
use crate::facets::slope_distribution::SlopeDistribution as _;
use crate::facets::tabulated::Tabulated;
use crate::materials::fitted::FittedBrdf;
use crate::materials::microfacet::{Microfacet, microfacet_eval};

/// The number of outer rounds. Each round updates the visible areas, then runs `STEPS` steps.
const ROUNDS: usize = 6;
const STEPS: usize = 12;
/// The number of intervals between the nodes of the Fresnel term.
const ANGLES: usize = 45;
/// The fraction of the direction pairs that may initially be darker than the diffuse term.
const DARK: f64 = 0.02;

/// Improves a fit over all directions. The nodes of the slope table stay the same.
pub fn refine(samples: &[Sample], start: &FittedBrdf) -> FittedBrdf {
    let mut grid = Grid::of(&start.facets.distribution);
    let mut fresnel: Vec<DVec3> =
        (0..=ANGLES).map(|i| start.facets.fresnel.at((i as f64 / ANGLES as f64 * FRAC_PI_2).cos())).collect();
    let mut diffuse = start.diffuse.max(darkest(samples));
    let mut fit = start.clone();
    for _ in 0..ROUNDS {
        let slopes = &fit.facets.distribution;
        let mut facets: Vec<Facet> = samples
            .iter()
            .map(|s| {
                let theta_d = s.wi.dot(s.wh).clamp(0.0, 1.0).acos() / FRAC_PI_2 * ANGLES as f64;
                let low = (theta_d as usize).min(ANGLES - 1);
                Facet {
                    around: grid.around(s.wh),
                    angle: (low, theta_d - low as f64),
                    ideal: microfacet_eval(fit.facets.masking, slopes, s.wo, s.wi) / s.wi.z,
                }
            })
            .collect();
        let mut changes = vec![1.0; grid.densities.len()];
        for _ in 0..STEPS {
            step(samples, &mut facets, &mut changes, &mut fresnel, &mut diffuse);
        }
        grid.densities.iter_mut().zip(&changes).for_each(|(d, change)| *d *= change);
        let Some(table) = grid.table() else { break };
        // The table's densities differ from the grid's by a constant factor.
        let factor = grid.densities[0] / table.ndf(DVec3::Z).max(1e-300);
        grid = Grid::of(&table);
        fresnel.iter_mut().for_each(|f| *f = (*f * factor).clamp(DVec3::ZERO, DVec3::ONE));
        diffuse = diffuse.clamp(DVec3::ZERO, DVec3::ONE);
        let facets = Microfacet {
            distribution: table,
            masking: fit.facets.masking,
            fresnel: Fresnel::Tabulated(FresnelTable::new(fresnel.clone()).expect("within 0..1")),
        };
        fit = FittedBrdf { facets, diffuse };
    }
    fit
}

/// Returns the initial diffuse term, which is a lower bound of the reflectance for nearly all direction pairs.
fn darkest(samples: &[Sample]) -> DVec3 {
    let channel = |c: usize| {
        let mut all: Vec<f64> = samples.iter().filter(|s| s.wo.z > 0.2 && s.wi.z > 0.2).map(|s| s.value[c]).collect();
        all.sort_by(f64::total_cmp);
        // The term is never 0, because multiplicative steps cannot change 0.
        all.get((DARK * all.len() as f64) as usize).map_or(1e-4, |f| (f / FRAC_1_PI).clamp(1e-4, 1.0))
    };
    DVec3::new(channel(0), channel(1), channel(2))
}

/// The contributions of the unknowns to the reflectance of a pair of directions.
struct Facet {
    /// The slope nodes and their interpolation weights.
    around: [(usize, f64); 4],
    /// The lower node of the Fresnel term, and the position between this node and the next, from 0 to 1.
    angle: (usize, f64),
    /// The reflectance of ideal facets, `D g`.
    ideal: f64,
}

/// Updates the diffuse term, then the Fresnel term, then the slopes.
fn step(samples: &[Sample], facets: &mut [Facet], changes: &mut [f64], fresnel: &mut [DVec3], diffuse: &mut DVec3) {
    let reflectance =
        |facet: &Facet, fresnel: &[DVec3]| fresnel[facet.angle.0].lerp(fresnel[facet.angle.0 + 1], facet.angle.1);
    let ratio = |s: &Sample, specular: DVec3, diffuse: DVec3| {
        s.value / (specular + diffuse * FRAC_1_PI).max(DVec3::splat(1e-9))
    };

    let (mut up, mut down) = (DVec3::ZERO, 0.0);
    for (s, facet) in samples.iter().zip(&*facets) {
        up += s.weight * ratio(s, reflectance(facet, fresnel) * facet.ideal, *diffuse);
        down += s.weight;
    }
    *diffuse *= up / down;

    let mut sums = vec![(DVec3::ZERO, 0.0); fresnel.len()];
    for (s, facet) in samples.iter().zip(&*facets) {
        let r = ratio(s, reflectance(facet, fresnel) * facet.ideal, *diffuse);
        for (node, share) in [(facet.angle.0, 1.0 - facet.angle.1), (facet.angle.0 + 1, facet.angle.1)] {
            let part = s.weight * share * facet.ideal;
            sums[node].0 += part * r;
            sums[node].1 += part;
        }
    }
    for (f, (up, down)) in fresnel.iter_mut().zip(sums) {
        if down > 1e-9 {
            *f *= up / down;
        }
    }

    let mut sums = vec![(0.0, 0.0); changes.len()];
    for (s, facet) in samples.iter().zip(&*facets) {
        let specular = reflectance(facet, fresnel) * facet.ideal;
        let r = ratio(s, specular, *diffuse);
        for &(node, share) in &facet.around {
            let part = s.weight * share * specular;
            sums[node].0 += part.dot(r);
            sums[node].1 += part.element_sum();
        }
    }
    let step: Vec<f64> = sums.iter().map(|&(up, down)| if down > 1e-12 { up / down } else { 1.0 }).collect();
    changes.iter_mut().zip(&step).for_each(|(change, step)| *change *= step);
    for facet in facets {
        facet.ideal *= facet.around.iter().map(|&(node, share)| share * step[node]).sum::<f64>();
    }
}

/// A grid of normal densities at the nodes of a table.
struct Grid {
    /// The number of angles and the number of azimuths. An isotropic table has one azimuth.
    size: (usize, usize),
    /// The densities. The azimuths of one angle are contiguous.
    densities: Vec<f64>,
}

impl Grid {
    fn of(slopes: &Tabulated) -> Self {
        let size = slopes.nodes();
        let at = |i: usize, k: usize| {
            slopes.ndf(direction(angle_at(i as f64 / size.0 as f64), TAU * k as f64 / size.1 as f64))
        };
        let densities = (0..size.0).flat_map(|i| (0..size.1).map(move |k| (i, k))).map(|(i, k)| at(i, k)).collect();
        Self { size, densities }
    }

    fn around(&self, wh: DVec3) -> [(usize, f64); 4] {
        let (n, m) = self.size;
        let along = (u_of_angle(wh.truncate().length().atan2(wh.z)) * n as f64).min((n - 1) as f64);
        let i = (along as usize).min(n - 2);
        let t = along - i as f64;
        let turn = (wh.y.atan2(wh.x) / TAU).rem_euclid(1.0) * m as f64;
        let (k, p) = (turn as usize % m, turn.fract());
        let node = |i: usize, k: usize| i * m + k % m;
        [
            (node(i, k), (1.0 - t) * (1.0 - p)),
            (node(i + 1, k), t * (1.0 - p)),
            (node(i, k + 1), (1.0 - t) * p),
            (node(i + 1, k + 1), t * p),
        ]
    }

    fn table(&self) -> Option<Tabulated> {
        let (n, m) = self.size;
        let rows: Vec<Vec<f64>> = (0..m).map(|k| (0..n).map(|i| self.densities[i * m + k]).collect()).collect();
        Tabulated::from_rows(&rows)
    }
}
