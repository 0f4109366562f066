//! Mixtures of Gaussians of slope, height and material, fitted by expectation maximisation.

use glam::{DMat3, DVec2, DVec3};
use leadr_reflectance::random::Random;
use rayon::prelude::*;

use super::facets::Facet;

/// The largest number of parts of a mixture.
pub(super) const MOST_PARTS: usize = 8;
/// The number of steps of a fit, and the number of fits from different starts.
const STEPS: usize = 40;
const STARTS: u64 = 4;
/// The variance that is added to the logarithm of the roughness, and to colours relative to their variance.
const MATERIAL_FLOOR: DVec2 = DVec2::new(2.5e-3, 1e-2);

/// A weighted Gaussian of slopes and heights, independent of Gaussians of the material.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub share: f64,
    pub mean: DVec3,
    pub covariance: DMat3,
    material: DVec2,
    material_variance: DVec2,
}

impl Part {
    /// Returns the logarithm of the weighted density.
    pub fn density(&self, floor: DVec3) -> Density {
        let covariance = self.covariance + DMat3::from_diagonal(floor);
        let inverse = covariance.inverse();
        let variance = self.material_variance + MATERIAL_FLOOR;
        Density {
            mean: self.mean,
            inverse,
            of_spread: DVec3::new(inverse.x_axis.x, inverse.y_axis.y, 2.0 * inverse.x_axis.y),
            material: self.material,
            of_material: variance.recip(),
            constant: self.share.max(1e-300).ln()
                - 0.5 * (covariance.determinant().max(1e-300) * variance.x * variance.y).ln(),
        }
    }
}

/// The logarithm of the weighted density of a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Density {
    mean: DVec3,
    inverse: DMat3,
    of_spread: DVec3,
    material: DVec2,
    of_material: DVec2,
    constant: f64,
}

impl Density {
    /// Returns the mean over the slopes of a facet.
    #[inline]
    fn at(&self, facet: &Facet) -> f64 {
        let off = facet.point - self.mean;
        let material = facet.material - self.material;
        let square = off.dot(self.inverse * off) + self.of_spread.dot(facet.spread);
        self.constant - 0.5 * (square + self.of_material.dot(material * material))
    }
}

/// Sums over weighted facets.
#[derive(Clone, Copy, Debug)]
struct Sums {
    weight: f64,
    first: DVec3,
    second: DMat3,
    spread: DVec3,
    material: DVec2,
    material_squares: DVec2,
}

impl Sums {
    const NONE: Self = Self {
        weight: 0.0,
        first: DVec3::ZERO,
        second: DMat3::ZERO,
        spread: DVec3::ZERO,
        material: DVec2::ZERO,
        material_squares: DVec2::ZERO,
    };

    fn add(&mut self, weight: f64, facet: &Facet) {
        self.weight += weight;
        self.first += weight * facet.point;
        self.second += outer(facet.point) * weight;
        self.spread += weight * facet.spread;
        self.material += weight * facet.material;
        self.material_squares += weight * facet.material * facet.material;
    }

    /// Returns the part of these facets among `all` facets.
    fn part(&self, all: usize) -> Part {
        let of_one = self.weight.max(1e-300).recip();
        let mean = self.first * of_one;
        let [xx, yy, xy] = (self.spread * of_one).to_array();
        let spread = DMat3::from_cols(DVec3::new(xx, xy, 0.0), DVec3::new(xy, yy, 0.0), DVec3::ZERO);
        let material = self.material * of_one;
        Part {
            share: self.weight / all as f64,
            mean,
            covariance: self.second * of_one - outer(mean) + spread,
            material,
            material_variance: (self.material_squares * of_one - material * material).max(DVec2::ZERO),
        }
    }
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

/// Returns the parts of facets whose classes are given.
pub(super) fn parts(facets: &[Facet], class_of: &[usize], count: usize) -> Vec<Part> {
    let mut sums = vec![Sums::NONE; count];
    facets.iter().zip(class_of).for_each(|(facet, &class)| sums[class].add(1.0, facet));
    sums.iter().map(|sum| sum.part(facets.len())).collect()
}

/// Returns the part with the largest density at a facet.
pub(super) fn nearest(densities: &[Density], facet: &Facet) -> usize {
    let mut best = (f64::NEG_INFINITY, 0);
    for (i, density) in densities.iter().enumerate() {
        let density = density.at(facet);
        if density > best.0 {
            best = (density, i);
        }
    }
    best.1
}

/// Fits mixtures of [`MOST_PARTS`] parts by expectation maximisation, from several starts. Half of them ignore the heights.
pub(super) fn fitted(facets: &[Facet], floor: DVec3) -> Vec<Vec<Density>> {
    let whole = parts(facets, &vec![0; facets.len()], 1)[0];
    let fits = (0..STARTS).into_par_iter().map(|start| {
        let ignored = if start % 2 == 0 { 0.0 } else { 1e9 * (whole.covariance.z_axis.z + floor.z) };
        let floor = floor + ignored * DVec3::Z;
        let mut parts = started(facets, whole, floor, &mut Random::stream(start, 1));
        let mut likelihood = f64::MIN;
        for _ in 0..STEPS {
            let densities: Vec<_> = parts.iter().map(|part| part.density(floor)).collect();
            let mut sums = [Sums::NONE; MOST_PARTS];
            let mut all = 0.0;
            for facet in facets {
                let mut logs = [f64::NEG_INFINITY; MOST_PARTS];
                logs.iter_mut().zip(&densities).for_each(|(log, density)| *log = density.at(facet));
                let most = logs.iter().copied().fold(f64::MIN, f64::max);
                let weights = logs.map(|log| (log - most).exp());
                let whole: f64 = weights.iter().sum();
                all += most + whole.ln();
                // Tiny weights change nothing.
                sums.iter_mut()
                    .zip(weights)
                    .filter(|(_, weight)| *weight > 1e-9)
                    .for_each(|(sum, weight)| sum.add(weight / whole, facet));
            }
            parts = sums.iter().map(|sum| sum.part(facets.len())).collect();
            if all - likelihood < 1e-5 * facets.len() as f64 {
                break;
            }
            likelihood = all;
        }
        parts.iter().map(|part| part.density(floor)).collect()
    });
    fits.collect()
}

/// Returns parts around facets that are far from each other (k-means++).
fn started(facets: &[Facet], whole: Part, floor: DVec3, random: &mut Random) -> Vec<Part> {
    let variances =
        DVec3::new(whole.covariance.x_axis.x, whole.covariance.y_axis.y, whole.covariance.z_axis.z + floor.z);
    let unit = variances.max(DVec3::splat(1e-20)).map(f64::sqrt);
    let of_material = whole.material_variance.max(DVec2::splat(1e-20)).map(f64::sqrt);
    let mut centres = vec![facets[(random.unit() * facets.len() as f64) as usize % facets.len()]];
    let mut squares = vec![f64::MAX; facets.len()];
    while centres.len() < MOST_PARTS {
        let newest = centres[centres.len() - 1];
        for (square, facet) in squares.iter_mut().zip(facets) {
            let (off, material) = (facet.point - newest.point, facet.material - newest.material);
            *square = square.min((off / unit).length_squared() + (material / of_material).length_squared());
        }
        let mut left = random.unit() * squares.iter().sum::<f64>();
        let next = squares.iter().position(|square| {
            left -= square;
            left <= 0.0
        });
        centres.push(facets[next.unwrap_or(0)]);
    }
    let part = |centre: Facet| Part {
        share: 1.0 / MOST_PARTS as f64,
        mean: centre.point,
        covariance: whole.covariance * (0.5 / MOST_PARTS as f64),
        material: centre.material,
        material_variance: whole.material_variance * (0.5 / MOST_PARTS as f64),
    };
    centres.into_iter().map(part).collect()
}
