//! The error of specular reflections if the facets of each class become one Gaussian.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::facets::Facet;
use super::mixture::Part;

/// The slope variance of the base material at which reflections are compared, for a Beckmann roughness of 0.35.
const BASE: f64 = 0.5 * 0.35 * 0.35;

/// Returns slopes of half vectors between twelve directions of light and five of view, and the factor from the density of slopes there
/// to a specular reflection.
fn half_vectors() -> impl Iterator<Item = (DVec2, f64)> {
    let direction = |polar: f64, azimuth: f64| {
        let ((sin, cos), (y, x)) = (polar.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
        DVec3::new(sin * x, sin * y, cos)
    };
    let views = [(0.0, 0.0), (45.0, -50.0), (45.0, 70.0), (70.0, -50.0), (70.0, 160.0)];
    let lights =
        [25.0, 50.0, 70.0].into_iter().flat_map(|polar| [25.0, 115.0, 205.0, 295.0].map(|azimuth| (polar, azimuth)));
    lights.flat_map(move |light| {
        views.map(|view| {
            let (light, view) = (direction(light.0, light.1), direction(view.0, view.1));
            let half = (light + view).normalize();
            (half.truncate() / -half.z, half.z.powi(-4) / view.z)
        })
    })
}

/// Specular reflections of facets, filtered by the base material.
pub(super) struct Truth {
    base: DVec2,
    half_vectors: Vec<(DVec2, f64)>,
    reflections: Vec<f64>,
}

impl Truth {
    /// Computes the reflections. `squares` converts slope variances to the units of the facets.
    pub fn new(facets: &[Facet], squares: DVec2) -> Self {
        let (share, base) = (1.0 / facets.len() as f64, BASE * squares);
        let lobe = |facet: &Facet| Lobe::new(share, facet.point.truncate(), facet.spread, base);
        let lobes: Vec<Lobe> = facets.iter().map(lobe).collect();
        let half_vectors: Vec<_> = half_vectors().map(|(at, factor)| (at * squares.map(f64::sqrt), factor)).collect();
        let reflections = half_vectors.par_iter().map(|half_vector| reflection(&lobes, half_vector)).collect();
        Self { base, half_vectors, reflections }
    }

    /// Returns the relative RMS difference of the reflections of parts.
    pub fn error(&self, parts: &[Part]) -> f64 {
        let lobe = |part: &Part| {
            let c = part.covariance;
            let covariance = DVec3::new(c.x_axis.x, c.y_axis.y, c.x_axis.y);
            Lobe::new(part.share, part.mean.truncate(), covariance, self.base)
        };
        let lobes: Vec<Lobe> = parts.iter().map(lobe).collect();
        let (mut difference, mut square) = (0.0, 0.0);
        for (half_vector, truth) in self.half_vectors.iter().zip(&self.reflections) {
            difference += (truth - reflection(&lobes, half_vector)).powi(2);
            square += truth * truth;
        }
        (difference / square.max(1e-300)).sqrt()
    }
}

fn reflection(lobes: &[Lobe], &(at, factor): &(DVec2, f64)) -> f64 {
    factor * lobes.iter().map(|lobe| lobe.density(at)).sum::<f64>()
}

/// A Gaussian of slopes, filtered by the base material.
struct Lobe {
    mean: DVec2,
    /// The coefficients of the squares and of the product of the deviations in the exponent.
    exponent: DVec3,
    factor: f64,
}

impl Lobe {
    fn new(share: f64, mean: DVec2, covariance: DVec3, base: DVec2) -> Self {
        let (xx, yy, xy) = (covariance.x + base.x, covariance.y + base.y, covariance.z);
        let det = (xx * yy - xy * xy).max(1e-300);
        Self { mean, exponent: DVec3::new(-0.5 * yy, -0.5 * xx, xy) / det, factor: share / det.sqrt() }
    }

    fn density(&self, at: DVec2) -> f64 {
        let d = at - self.mean;
        self.factor * self.exponent.dot(DVec3::new(d.x * d.x, d.y * d.y, d.x * d.y)).exp()
    }
}
