//! Compares diffuse models with random walks between facets, and refits the model of
//! `reflectance::materials::multiscattering`.

use crate::facet_walk::{Facets, ORDERS, facet_walks};
use crate::least_squares::least_squares;
use glam::{DVec2, DVec3};
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::materials::energy::{EnergyTable, entered};
use leadr_reflectance::materials::multiscattering::{BounceFit, multiscattering_diffuse};
use leadr_reflectance::quadrature::gauss_legendre;
use rayon::prelude::*;
use std::f64::consts::PI;

/// The number of azimuths between viewer and light in a [`Simulation`]. The azimuths are the centres of equal steps from 0
/// to π.
const AZIMUTHS: usize = 9;

/// The number of cosines in a [`Simulation`]. The cosines are Gauss nodes over 0 to 1.
const COSINES: usize = 10;

/// Simulated values of `π f_r` for pairs of directions, by two cosines and an azimuth. Swapping the directions does not
/// change a value.
pub struct Simulation {
    /// The roughness of the facets.
    pub alpha: f64,
    /// The reflectance of the facets' coat.
    pub f0: f64,
    nodes: Vec<(f64, f64)>,
    values: Vec<[f64; ORDERS]>,
    /// The directional albedo at each node, by number of bounces.
    albedo: Vec<[f64; ORDERS]>,
}

/// One pair of directions of a [`Simulation`].
#[derive(Clone, Copy, Debug)]
pub struct DirectionPair {
    /// The unit vector to the viewer.
    pub wo: DVec3,
    /// The unit vector to the light.
    pub wi: DVec3,
    /// The weight of the pair in the integral over both cosine-weighted hemispheres. The weights of all pairs sum to 1.
    pub weight: f64,
}

fn direction(cosine: f64, azimuth: f64) -> DVec3 {
    let s = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    DVec3::new(s * azimuth.cos(), s * azimuth.sin(), cosine)
}

fn azimuth(k: usize) -> f64 {
    PI * (k as f64 + 0.5) / AZIMUTHS as f64
}

fn powers(values: &[f64; ORDERS], albedo: f64) -> f64 {
    values.iter().rev().fold(0.0, |sum, v| albedo * (v + sum))
}

impl Simulation {
    /// Simulates `count` walks on GGX facets from each of the ten cosines.
    pub fn new(alpha: f64, f0: f64, facets: Facets, count: u64, seed: u64) -> Self {
        let nodes: Vec<(f64, f64)> =
            gauss_legendre(COSINES).into_iter().map(|(x, w)| (0.5 + 0.5 * x, 0.5 * w)).collect();
        let distribution = Ggx::isotropic(DVec2::ZERO, alpha);
        let outwards: Vec<DVec3> =
            nodes.iter().flat_map(|&(c, _)| (0..AZIMUTHS).map(move |k| direction(c, azimuth(k)))).collect();
        let walks: Vec<_> = nodes
            .par_iter()
            .enumerate()
            .map(|(i, n)| facet_walks(&distribution, facets, direction(n.0, 0.0), &outwards, count, seed + i as u64))
            .collect();
        let mut values = vec![[0.0; ORDERS]; COSINES * COSINES * AZIMUTHS];
        for (i, j, k) in direction_pairs() {
            let half =
                |a: usize, b: usize, order: usize| 0.5 * PI * walks[a].towards[b * AZIMUTHS + k][order] / nodes[b].0;
            values[(i * COSINES + j) * AZIMUTHS + k] = std::array::from_fn(|o| half(i, j, o) + half(j, i, o));
        }
        let albedo = walks.iter().map(|w| w.albedo).collect();
        Self { alpha, f0, nodes, values, albedo }
    }

    /// Returns all pairs with their `π f_r` for facets of this albedo.
    pub fn direction_pairs(&self, albedo: f64) -> impl Iterator<Item = (DirectionPair, f64)> + '_ {
        direction_pairs().map(move |(i, j, k)| {
            let ((ci, wi), (co, wo)) = (self.nodes[i], self.nodes[j]);
            let weight = 4.0 * ci * co * wi * wo / AZIMUTHS as f64;
            let pair = DirectionPair { wo: direction(co, azimuth(k)), wi: direction(ci, 0.0), weight };
            (pair, powers(&self.values[(i * COSINES + j) * AZIMUTHS + k], albedo))
        })
    }

    /// Computes the RMS error of `model` (`π f_r`) over both cosine-weighted hemispheres.
    pub fn error(&self, albedo: f64, model: impl Fn(DVec3, DVec3) -> f64) -> f64 {
        self.direction_pairs(albedo).map(|(p, want)| p.weight * (model(p.wo, p.wi) - want).powi(2)).sum::<f64>().sqrt()
    }

    /// Returns each cosine with the directional albedo of the walks, for facets of this albedo.
    pub fn albedo(&self, albedo: f64) -> Vec<(f64, f64)> {
        self.nodes.iter().zip(&self.albedo).map(|(n, a)| (n.0, powers(a, albedo))).collect()
    }
}

fn direction_pairs() -> impl Iterator<Item = (usize, usize, usize)> {
    (0..COSINES).flat_map(|i| (0..COSINES).flat_map(move |j| (0..AZIMUTHS).map(move |k| (i, j, k))))
}

/// Computes `π f_r` of [`multiscattering_diffuse`] with the constants `fit`.
pub fn fitted(fit: &BounceFit, table: &EnergyTable, alpha: f64, f0: f64, albedo: f64, wo: DVec3, wi: DVec3) -> f64 {
    let (f0, average) = (DVec3::splat(f0), table.average(alpha));
    let [o, i] = [wo.z, wi.z].map(|c| entered(f0, table.albedo(alpha, c), average.ideal));
    let mean = entered(f0, average, average.ideal);
    PI * multiscattering_diffuse(wo, wi, fit.at(alpha), f0, DVec3::splat(albedo), o, i, mean).x
}

/// Fits the constants to `simulations` by least squares, for facets of albedo .5 and 1. `lost` stays 0 if it starts at 0.
pub fn fit_bounces(simulations: &[Simulation], table: &EnergyTable, start: &BounceFit, steps: u32) -> BounceFit {
    let lossy = start.lost[0] != 0.0;
    let from = |p: &[f64]| {
        let k = |i: usize| [p[i], p[i + 1], p[i + 2]];
        BounceFit { grazing: k(0), again: k(3), lean: k(6), lost: if lossy { k(9) } else { start.lost } }
    };
    let wanted: Vec<(usize, f64, DirectionPair, f64)> = simulations
        .iter()
        .enumerate()
        .flat_map(|(s, sim)| {
            [0.5, 1.0].into_iter().flat_map(move |rho| sim.direction_pairs(rho).map(move |(p, want)| (s, rho, p, want)))
        })
        // The values are symmetric in the two directions, so one half suffices.
        .filter(|(_, _, p, _)| p.wo.z <= p.wi.z)
        .collect();
    let residuals = |p: &[f64]| -> Vec<f64> {
        let fit = from(p);
        wanted
            .par_iter()
            .map(|&(s, rho, pair, want)| {
                let sim = &simulations[s];
                let got = fitted(&fit, table, sim.alpha, sim.f0, rho, pair.wo, pair.wi);
                pair.weight.sqrt() * (got - want) / rho
            })
            .collect()
    };
    let parts = [start.grazing, start.again, start.lean, start.lost];
    from(&least_squares(parts[..if lossy { 4 } else { 3 }].concat(), steps, residuals))
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::materials::microfacet::half_vector;
    use leadr_reflectance::materials::multiscattering::{BOUNCES, BOUNCES_LOSSY, chan_diffuse};

    /// Checks the fit for all glosses of the paper's figures and both kinds of simulation.
    #[test]
    fn nearer_to_the_walk_than_the_published_fit() {
        let table = EnergyTable::ggx();
        for g in [0.0, 60.0, 120.0, 180.0, 240.0].map(|g: f64| g / 255.0) {
            let alpha = (2.0 / (1.0 + (18.0 * g).exp2())).sqrt();
            for (facets, fit) in [(Facets::Coated(0.04), BOUNCES), (Facets::Diffuse(0.04), BOUNCES_LOSSY)] {
                let walk = Simulation::new(alpha, 0.04, facets, 2000, 7);
                let published = walk.error(1.0, |wo, wi| {
                    let h = half_vector(wo, wi);
                    chan_diffuse(wi.z, wo.z, h.z, wi.dot(h), g)
                });
                let ours = walk.error(1.0, |wo, wi| fitted(&fit, &table, alpha, 0.04, 1.0, wo, wi));
                assert!(ours < 0.8 * published, "{facets:?} gloss {g}: {ours} {published}");
            }
        }
    }
}
