//! Compares forms for the distribution of the normals under a pixel: Gaussians of slopes (LEADR and its classes of facets), the lobes of
//! von Mises and Fisher (one for Toksvig 2005, several for Han et al. 2007), and spherical harmonics (Han et al. 2007).

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use leadr_maps::derive::{Facets, classes_of_count};
use leadr_maps::{HeightMap, Wrap, procedural};
use leadr_reflectance::facets::beckmann::beckmann_ndf;
use leadr_reflectance::masking::classes::Class;
use leadr_reflectance::slopes::grid::{normal_of_slope, slope_at, slope_cholesky};
use rayon::prelude::*;

use crate::ray_cast::Tile;

/// The half vectors of the comparison, from the mesonormal to this angle in degrees.
const WIDEST: f64 = 75.0;
const HALF_VECTORS: usize = 500;
/// The number of facets of a relief that are compared.
const FACETS: usize = 1 << 17;
/// Facets for the lobes' expectation maximisation.
const SAMPLES: usize = 8192;
const ROUNDS: usize = 80;

/// A form for the distribution of normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// This number of Gaussians of slopes, one per class of facets.
    Gaussians(usize),
    /// This number of von Mises–Fisher lobes.
    Lobes(usize),
    /// Spherical harmonics up to this degree.
    Harmonics(usize),
}

impl Form {
    /// Returns the number of floats that a texel stores, if their mean over texels describes the union of the texels.
    pub fn floats(self) -> usize {
        match self {
            Self::Gaussians(count) => 6 * count - 1,
            Self::Lobes(count) => 4 * count - 1,
            Self::Harmonics(degree) => (degree + 1).pow(2),
        }
    }
}

/// The normals of a relief, each with the area of its facet over one unit of the mesosurface.
#[derive(Clone, Debug)]
pub struct Normals {
    weighted: Vec<(DVec3, f64)>,
    map: HeightMap,
    scale: f64,
}

/// Directions with weights, which stand for a distribution of normals.
type Nodes = Vec<(DVec3, f64)>;

impl Normals {
    /// Takes the normals of a square height map. `scale` converts heights to texture widths.
    ///
    /// # Panics
    /// Panics if the side of the map is not a power of two.
    pub fn new(map: HeightMap, scale: f64) -> Self {
        let cells = scale * f64::from(map.width);
        let tile = Tile::from_heights(map.width, map.texels.iter().map(|h| (f64::from(*h) * cells) as f32).collect());
        let size = map.width as i32;
        let facets = (0..size * size).flat_map(|i| tile.slopes(i % size, i / size));
        let stride = odd_stride(2 * (size * size) as usize, FACETS);
        Self { weighted: facets.step_by(stride).map(|slope| area_weighted(slope, 1.0)).collect(), map, scale }
    }

    /// Returns the errors of forms for facets with an isotropic Beckmann base of roughness `alpha`: the RMS over half vectors of the
    /// difference in the distribution of the bases' normals, divided by the RMS of that distribution.
    pub fn errors<const N: usize>(&self, forms: [Form; N], alpha: f64) -> [f64; N] {
        let truth = distribution(&self.weighted, alpha);
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
        let whole = square(&mut truth.iter().copied());
        forms.map(|form| {
            let found = self.distribution_by(form, alpha);
            (square(&mut truth.iter().zip(&found).map(|(a, b)| a - b)) / whole).sqrt()
        })
    }

    fn distribution_by(&self, form: Form, alpha: f64) -> Vec<f64> {
        match form {
            Form::Gaussians(count) => {
                let facets = Facets::OfHeights(&self.map, Wrap::Repeat);
                let found = classes_of_count(facets, [self.scale; 2], count).sampled([self.scale; 2]);
                distribution(&found.iter().flat_map(gaussian_nodes).collect(), alpha)
            }
            Form::Lobes(count) => {
                distribution(&lobes(&self.weighted, count).iter().flat_map(Lobe::nodes).collect(), alpha)
            }
            Form::Harmonics(degree) => harmonics(&self.weighted, degree, alpha),
        }
    }
}

/// Returns a step through `count` values that takes about `wanted` of them. It is odd, so it visits all columns of a map.
fn odd_stride(count: usize, wanted: usize) -> usize {
    (count / wanted).max(1) | 1
}

/// A relief with heavy tails: a Gaussian field whose amplitude varies log-normally over larger distances.
pub fn heavy_tails(size: u32, slope_sigma: f32, spread: f32) -> HeightMap {
    let mut field = procedural::gaussian(size, size, 3, slope_sigma, 0.006);
    let amplitude = procedural::gaussian(size, size, 4, 1.0, 0.05);
    let deviation = (amplitude.texels.iter().map(|a| a * a).sum::<f32>() / amplitude.texels.len() as f32).sqrt();
    for (height, a) in field.texels.iter_mut().zip(&amplitude.texels) {
        *height *= (spread * (a / deviation) - spread * spread).exp();
    }
    field
}

fn area_weighted(slope: DVec2, weight: f64) -> (DVec3, f64) {
    let n = normal_of_slope(slope);
    (n, weight / n.z)
}

/// Returns half vectors of equal solid angle, on a spiral.
fn half_vectors() -> impl IndexedParallelIterator<Item = DVec3> {
    let cap = 1.0 - WIDEST.to_radians().cos();
    (0..HALF_VECTORS).into_par_iter().map(move |i| {
        let z = 1.0 - cap * (i as f64 + 0.5) / HALF_VECTORS as f64;
        let phi = i as f64 * PI * (3.0 - 5f64.sqrt());
        (DVec2::from_angle(phi) * (1.0 - z * z).sqrt()).extend(z)
    })
}

/// Returns the density of a Beckmann base by the cosine between half vector and facet.
fn base(cosine: f64, alpha: f64) -> f64 {
    let h = DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    beckmann_ndf(h, DVec2::ZERO, DVec3::new(0.5, 0.5, 0.0) * (alpha * alpha))
}

/// Returns the density of the bases' normals for each half vector, per unit area of all facets.
fn distribution(nodes: &Nodes, alpha: f64) -> Vec<f64> {
    let whole: f64 = nodes.iter().map(|(_, area)| area).sum();
    half_vectors()
        .map(|h| nodes.iter().map(|(n, area)| area * base(h.dot(*n).min(1.0), alpha)).sum::<f64>() / whole)
        .collect()
}

fn gaussian_nodes(class: &Class) -> Nodes {
    const SIDE: i32 = 40;
    let cholesky = slope_cholesky(class.covariance);
    let at = |i: i32| f64::from(i) * 4.0 / f64::from(SIDE);
    let weight = |t: f64| (-0.5 * t * t).exp();
    let sum: f64 = (-SIDE..=SIDE).map(|i| weight(at(i))).sum();
    (-SIDE..=SIDE)
        .flat_map(|i| (-SIDE..=SIDE).map(move |j| DVec2::new(at(i), at(j))))
        .map(|t| {
            area_weighted(slope_at(t, class.mean, cholesky), class.share * weight(t.x) * weight(t.y) / (sum * sum))
        })
        .collect()
}

/// A von Mises–Fisher lobe with its share of the area.
#[derive(Clone, Copy, Debug)]
struct Lobe {
    share: f64,
    mean: DVec3,
    concentration: f64,
}

impl Lobe {
    /// Returns the lobe of a mean vector (Banerjee et al. 2005; Han et al. 2007, section 5).
    fn new(share: f64, mean: DVec3) -> Self {
        let r = mean.length().clamp(1e-9, 1.0 - 1e-7);
        Self { share, mean: mean / mean.length().max(1e-12), concentration: r * (3.0 - r * r) / (1.0 - r * r) }
    }

    fn density(&self, n: DVec3) -> f64 {
        let k = self.concentration;
        self.share * k / (TAU * (1.0 - (-2.0 * k).exp())) * (k * (self.mean.dot(n) - 1.0)).exp()
    }

    fn nodes(&self) -> Nodes {
        let (x, y) = self.mean.any_orthonormal_pair();
        let k = self.concentration;
        (0..64)
            .flat_map(|i| (0..64).map(move |j| [(f64::from(i) + 0.5) / 64.0, TAU * f64::from(j) / 64.0]))
            .map(|[u, phi]| {
                let z = (1.0 + (u + (1.0 - u) * (-2.0 * k).exp()).ln() / k).clamp(-1.0, 1.0);
                let across = DVec2::from_angle(phi) * (1.0 - z * z).sqrt();
                (across.x * x + across.y * y + z * self.mean, self.share / 4096.0)
            })
            .collect()
    }
}

/// Fits lobes to normals by expectation maximisation.
fn lobes(weighted: &Nodes, count: usize) -> Vec<Lobe> {
    let samples: Nodes = weighted.iter().copied().step_by(odd_stride(weighted.len(), SAMPLES)).collect();
    let mean = |of: &dyn Fn(DVec3) -> f64| {
        let (sum, area) = samples.iter().fold((DVec3::ZERO, 0.0), |(sum, area), (n, a)| {
            let weight = a * of(*n);
            (sum + weight * *n, area + weight)
        });
        (area, sum / f64::max(area, 1e-12))
    };
    let (whole, all) = mean(&|_| 1.0);
    if count == 1 {
        return vec![Lobe::new(1.0, all)];
    }
    // Each start is the normal that is worst described by the starts before it.
    let mut starts = vec![all.normalize()];
    while starts.len() < count {
        let nearest = |n: DVec3| starts.iter().map(|s| s.dot(n)).fold(-1.0, f64::max);
        let worst = samples.iter().min_by(|a, b| nearest(a.0).total_cmp(&nearest(b.0)));
        starts.push(worst.map_or(DVec3::Z, |(n, _)| *n));
    }
    let mut lobes: Vec<Lobe> =
        starts.iter().map(|&mean| Lobe { share: 1.0 / count as f64, mean, concentration: 20.0 }).collect();
    for _ in 0..ROUNDS {
        let before = lobes.clone();
        for (lobe, old) in lobes.iter_mut().zip(&before) {
            let part = |n: DVec3| old.density(n) / before.iter().map(|l| l.density(n)).sum::<f64>().max(1e-300);
            let (area, sum) = mean(&part);
            *lobe = Lobe::new(area / whole, sum);
        }
    }
    lobes
}

/// Returns the density of the bases' normals by spherical harmonics, which filter by a product for each degree.
fn harmonics(weighted: &Nodes, degree: usize, alpha: f64) -> Vec<f64> {
    let whole: f64 = weighted.iter().map(|(_, area)| area).sum();
    let count = (degree + 1).pow(2);
    let zero = || (vec![0.0; count], vec![0.0; count]);
    let (sums, _) = weighted
        .par_chunks(4096)
        .fold(zero, |(mut sums, mut y), chunk| {
            for (n, area) in chunk {
                evaluate(*n, degree, &mut y);
                sums.iter_mut().zip(&y).for_each(|(sum, y)| *sum += area / whole * y);
            }
            (sums, y)
        })
        .reduce(zero, |(mut a, y), (b, _)| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            (a, y)
        });
    let filter = zonal(degree, alpha);
    half_vectors()
        .map(|h| {
            let mut y = vec![0.0; count];
            evaluate(h, degree, &mut y);
            (0..count).map(|i| filter[i.isqrt()] * sums[i] * y[i]).sum()
        })
        .collect()
}

/// Returns `2π ∫ D(c) P_l(c) dc` for each degree.
fn zonal(degree: usize, alpha: f64) -> Vec<f64> {
    const STEPS: usize = 4000;
    let mut sums = vec![0.0; degree + 1];
    for i in 0..STEPS {
        let c = (i as f64 + 0.5) / STEPS as f64;
        let (mut last, mut p) = (0.0, 1.0);
        for (l, sum) in sums.iter_mut().enumerate() {
            *sum += TAU * base(c, alpha) * p / STEPS as f64;
            let next = ((2 * l + 1) as f64 * c * p - l as f64 * last) / (l + 1) as f64;
            (last, p) = (p, next);
        }
    }
    sums
}

/// Evaluates the real spherical harmonics up to a degree. The order `m` of degree `l` is at `l² + l + m`.
fn evaluate(n: DVec3, degree: usize, y: &mut [f64]) {
    // The Legendre function without its factor sin^m, which the powers of x + iy contain.
    let mut power = DVec2::X;
    let mut diagonal = (0.25 / PI).sqrt();
    for m in 0..=degree {
        let (mut last, mut p) = (0.0, diagonal);
        for l in m..=degree {
            let scale = if m == 0 { 1.0 } else { 2f64.sqrt() };
            y[l * l + l + m] = scale * p * power.x;
            y[l * l + l - m] = if m == 0 { p } else { scale * p * power.y };
            let (lf, mf) = ((l + 1) as f64, m as f64);
            let a = ((4.0 * lf * lf - 1.0) / (lf * lf - mf * mf)).sqrt();
            let b = if l > m { ((l as f64).powi(2) - mf * mf) / (4.0 * (l as f64).powi(2) - 1.0) } else { 0.0 };
            (last, p) = (p, a * (n.z * p - b.sqrt() * last));
        }
        power = DVec2::new(power.x * n.x - power.y * n.y, power.x * n.y + power.y * n.x);
        diagonal *= ((2 * m + 3) as f64 / (2 * m + 2) as f64).sqrt();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_are_orthonormal() {
        const DEGREE: usize = 5;
        let count = (DEGREE + 1).pow(2);
        let mut products = vec![0.0; count * count];
        let mut y = vec![0.0; count];
        let (rings, steps) = (200, 24);
        for (i, j) in (0..rings).flat_map(|i| (0..steps).map(move |j| (i, j))) {
            let theta = PI * (f64::from(i) + 0.5) / f64::from(rings);
            let n = (DVec2::from_angle(TAU * f64::from(j) / f64::from(steps)) * theta.sin()).extend(theta.cos());
            evaluate(n, DEGREE, &mut y);
            let weight = theta.sin() * PI / f64::from(rings) * TAU / f64::from(steps);
            for a in 0..count {
                for b in 0..count {
                    products[a * count + b] += weight * y[a] * y[b];
                }
            }
        }
        for (i, product) in products.iter().enumerate() {
            let expected = if i / count == i % count { 1.0 } else { 0.0 };
            assert!((product - expected).abs() < 1e-3, "{i}: {product}");
        }
    }

    #[test]
    fn lobes_recover_their_parameters() {
        let made = [Lobe::new(0.7, DVec3::Z * 0.98), Lobe::new(0.3, DVec3::new(0.6, 0.0, 0.8) * 0.99)];
        let found = lobes(&made.iter().flat_map(Lobe::nodes).collect(), 2);
        for (lobe, made) in found.iter().zip(made) {
            assert!((lobe.share - made.share).abs() < 0.01 && lobe.mean.dot(made.mean) > 0.9999, "{lobe:?}");
            assert!((lobe.concentration / made.concentration - 1.0).abs() < 0.05, "{lobe:?}");
        }
    }
}
