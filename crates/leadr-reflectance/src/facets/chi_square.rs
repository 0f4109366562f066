//! A χ² test of normals sampled from any slope distribution.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::radial_table::{angle_at, u_of_angle};
use super::slope_distribution::SlopeDistribution;
use crate::quadrature::gauss_legendre;
use crate::random::Random;

/// The number of histogram cells over the square root of the polar angle, and over the azimuth.
const CELLS: usize = 16;

/// Samples visible normals from `drawn` and compares them with the density of `of`. Returns the χ² statistic and its 99 % quantile for
/// equal distributions. Cells with few expected samples are pooled.
pub fn chi_square(drawn: &impl SlopeDistribution, of: &impl SlopeDistribution, wo: DVec3, samples: u32) -> (f64, f64) {
    let mut counts = vec![0.0; CELLS * CELLS];
    for i in 0..samples {
        let mut random = Random::stream(7, u64::from(i));
        let wn = drawn.sample_visible(wo, DVec2::new(random.unit(), random.unit()));
        let along = (u_of_angle(wn.truncate().length().atan2(wn.z)) * CELLS as f64) as usize;
        let turn = ((wn.y.atan2(wn.x) / TAU).rem_euclid(1.0) * CELLS as f64) as usize;
        counts[along.min(CELLS - 1) * CELLS + turn.min(CELLS - 1)] += 1.0;
    }
    let rule = gauss_legendre(8);
    let (mut sum, mut cells, mut few) = (0.0, 0.0, [0.0; 2]);
    for (cell, count) in counts.into_iter().enumerate() {
        let (i, k) = (cell / CELLS, cell % CELLS);
        let mut share = 0.0;
        for &(x, wx) in &rule {
            for &(y, wy) in &rule {
                let u = (i as f64 + 0.5 + 0.5 * x) / CELLS as f64;
                let (sine, cosine) = angle_at(u).sin_cos();
                let phi = TAU * (k as f64 + 0.5 + 0.5 * y) / CELLS as f64;
                let wn = DVec3::new(sine * phi.cos(), sine * phi.sin(), cosine);
                share += 0.25 * wx * wy * of.vndf(wo, wn) * sine * PI * u * TAU / (CELLS * CELLS) as f64;
            }
        }
        let expected = share * f64::from(samples);
        if expected < 5.0 {
            few = [few[0] + expected, few[1] + count];
        } else {
            sum += (count - expected).powi(2) / expected;
            cells += 1.0;
        }
    }
    if few[0] >= 1.0 {
        sum += (few[1] - few[0]).powi(2) / few[0];
        cells += 1.0;
    }
    // The quantile uses the Wilson–Hilferty approximation.
    let freedom: f64 = cells - 1.0;
    let part = 2.0 / (9.0 * freedom);
    (sum, freedom * (1.0 - part + 2.326 * part.sqrt()).powi(3))
}
