//! A fitted material as the row of numbers that shaders read: `leadr/materials/fitted.glsl` says what lies where.
//!
//! `ln D` is held by the nodes of its table, each with its slope, so that shaders interpolate it by the very same cubic. The visible area is
//! held at the directions `cos θ = (j/n)²`, dense where it is not simply the cosine; Fresnel reflectances as they are measured.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};

use super::fitted::FittedBrdf;
use crate::facets::curve::Curve;
use crate::facets::ellipse::ellipse_from_roughness;
use crate::facets::gaussian_mixture::{Lobe, MOST_LOBES};
use crate::facets::slope_distribution::SlopeDistribution as _;

/// Largest roughness of a lobe.
const MOST_ALPHA: f64 = 2.0;
/// Intervals of the visible area.
const AREAS: usize = 96;
/// Intervals of the Fresnel term.
const REFLECTANCES: usize = 90;
/// Numbers in front of the lobes, and of a lobe.
const HEAD: usize = 13;
const LOBE: usize = 5;

/// A material as shaders read it.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedTable {
    words: Vec<f32>,
    lobes: u32,
    alpha: f32,
}

/// The lesser half-axis of a lobe as a Beckmann roughness: how rough it is across what brushed it.
pub fn lobe_alpha(lobe: &Lobe) -> f64 {
    ellipse_from_roughness(2.0 * lobe.covariance).radii.min_element().clamp(1e-4, MOST_ALPHA)
}

/// The direction along which slopes vary most, from the x axis; half a turn further is the same.
pub fn widest_direction(covariance: DVec3) -> f64 {
    0.5 * (2.0 * covariance.z).atan2(covariance.x - covariance.y)
}

impl FittedTable {
    /// A fit with its lobes, of which [`MOST_LOBES`] are kept. `alpha`: the roughness that stands for it; where a surface has another, slopes
    /// are scaled by the quotient.
    pub fn new(brdf: &FittedBrdf, lobes: &[Lobe], alpha: f32) -> Self {
        let facets = &brdf.facets;
        let lobes = &lobes[..lobes.len().min(MOST_LOBES)];
        let rows = facets.distribution.ln_d();
        let area = |azimuth: f64, j: usize| {
            let cosine = (j as f64 / AREAS as f64).powi(2);
            let across = (1.0 - cosine * cosine).max(0.0).sqrt() * DVec2::from_angle(azimuth);
            facets.distribution.visible_area(across.extend(cosine))
        };
        let areas: Vec<Curve> = (0..rows.len())
            .map(|k| TAU * k as f64 / rows.len() as f64)
            .map(|azimuth| Curve::new((0..=AREAS).map(|j| area(azimuth, j)).collect()))
            .collect();
        let density_at = HEAD + MOST_LOBES * LOBE;
        let nodes = rows[0].values().len();
        let area_at = density_at + 2 * nodes * rows.len();
        let fresnel_at = area_at + 2 * (AREAS + 1) * rows.len();
        let mean = facets.distribution.mean_slope();
        let mut words = vec![
            f64::from(facets.masking as u32),
            lobes.len() as f64,
            f64::from(alpha),
            widest_direction(lobes.iter().map(|lobe| lobe.share * lobe.covariance).sum()),
            mean.x,
            mean.y,
            (nodes - 1) as f64,
            rows.len() as f64,
            density_at as f64,
            AREAS as f64,
            area_at as f64,
            REFLECTANCES as f64,
            fresnel_at as f64,
        ];
        for lobe in lobes {
            words.push(lobe.share);
            words.extend(lobe.covariance.to_array());
            words.push(lobe_alpha(lobe));
        }
        words.resize(density_at, 0.0);
        words.extend(rows.iter().flat_map(Curve::knots).flatten());
        words.extend(areas.iter().flat_map(Curve::knots).flatten());
        let angle = |i: usize| i as f64 / REFLECTANCES as f64 * FRAC_PI_2;
        words.extend((0..=REFLECTANCES).flat_map(|i| facets.fresnel.at(angle(i).cos()).to_array()));
        Self { words: words.into_iter().map(|word| word as f32).collect(), lobes: lobes.len() as u32, alpha }
    }

    /// The numbers.
    pub fn words(&self) -> &[f32] {
        &self.words
    }

    /// How many lobes it has.
    pub const fn lobes(&self) -> u32 {
        self.lobes
    }

    /// The roughness that stands for it.
    pub const fn alpha(&self) -> f32 {
        self.alpha
    }
}
