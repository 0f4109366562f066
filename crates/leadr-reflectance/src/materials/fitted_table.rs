//! The shader data of a fitted material, which is a row of numbers in the layout of `leadr/materials/fitted.glsl`.
//!
//! Table nodes store `ln D` and its slope, so shaders interpolate with the same cubic as the CPU. The visible area is stored at
//! `cos θ = (j/n)²`. The nodes are denser where the area differs from the cosine. Fresnel reflectances are stored without conversion.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec2, DVec3};

use super::fitted::FittedBrdf;
use crate::extraction::roughness::ggx_roughness;
use crate::facets::curve::Curve;
use crate::facets::ellipse::ellipse_from_roughness;
use crate::facets::gaussian_mixture::{DRAWN_LOBES, Lobe};
use crate::facets::slope_distribution::SlopeDistribution as _;
use crate::facets::tabulated::Tabulated;

const MOST_ALPHA: f64 = 2.0;
/// The number of intervals in the table of the visible area.
const AREAS: usize = 96;
/// The number of intervals in the table of the Fresnel term.
const REFLECTANCES: usize = 90;
/// The number of values in the header.
const HEAD: usize = 14;
const LOBE: usize = 5;

/// A material in the layout of the shaders.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedTable {
    words: Vec<f32>,
    lobes: u32,
    alpha: f32,
}

/// Returns the minor radius of a lobe as a Beckmann roughness. This is the roughness across the direction of anisotropy.
pub fn lobe_alpha(lobe: &Lobe) -> f64 {
    ellipse_from_roughness(2.0 * lobe.covariance).radii.min_element().clamp(1e-4, MOST_ALPHA)
}

/// Returns the GGX roughness of the facets. For anisotropic facets, it has the mean square of both radii.
fn ggx_alpha(facets: &Tabulated) -> f64 {
    let roughness = ggx_roughness(facets);
    (0.5 * (roughness.x + roughness.y)).sqrt().clamp(1e-4, MOST_ALPHA)
}

/// Returns the direction of the largest slope variance, in radians from the x axis, modulo π.
pub fn widest_direction(covariance: DVec3) -> f64 {
    0.5 * (2.0 * covariance.z).atan2(covariance.x - covariance.y)
}

impl FittedTable {
    /// Packs a fit and its first [`DRAWN_LOBES`] lobes. `alpha` is the equivalent roughness of the fit. A surface of another roughness
    /// scales the slopes by the ratio of the roughnesses.
    pub fn new(brdf: &FittedBrdf, lobes: &[Lobe], alpha: f32) -> Self {
        let facets = &brdf.facets;
        let lobes = &lobes[..lobes.len().min(DRAWN_LOBES)];
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
        let density_at = HEAD + DRAWN_LOBES * LOBE;
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
            ggx_alpha(&facets.distribution),
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

    /// Returns the packed numbers.
    pub fn words(&self) -> &[f32] {
        &self.words
    }

    /// Returns the number of lobes.
    pub const fn lobes(&self) -> u32 {
        self.lobes
    }

    /// Returns the equivalent roughness of the material.
    pub const fn alpha(&self) -> f32 {
        self.alpha
    }
}
