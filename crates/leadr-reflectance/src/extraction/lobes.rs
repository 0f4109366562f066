//! Fits Gaussian lobes to any slope distribution. Expectation maximisation finds the lobes of maximum likelihood (Dempster, Laird and Rubin
//! 1977).

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::samples::{Misfit, Sample, direction, misfit};
use crate::facets::gaussian_mixture::{GaussianMixture, Lobe, MOST_LOBES};
use crate::facets::radial_table::angle_at;
use crate::facets::slope_distribution::SlopeDistribution as _;
use crate::facets::tabulated::Tabulated;
use crate::limits::MIN_VARIANCE;
use crate::materials::fitted::FittedBrdf;
use crate::materials::microfacet::Microfacet;
use crate::slopes::statistics::outer_square;

const ITERATIONS: u32 = 300;

/// Fits lobes about a slope of zero and returns them from the smoothest to the roughest. The lobes of an isotropic table are round.
///
/// `count` is clamped to 1..=[`MOST_LOBES`]. Lobes of negligible weight are left out.
pub fn fit_lobes(slopes: &Tabulated, count: usize) -> Vec<Lobe> {
    let count = count.clamp(1, MOST_LOBES);
    let points = points(slopes);
    let total: f64 = points.iter().map(|(_, mass)| mass).sum();
    // Initialise the variances from quantiles of the squared slopes.
    let mut squares: Vec<(f64, f64)> = points.iter().map(|(s, mass)| (s.length_squared(), *mass)).collect();
    squares.sort_by(|a, b| a.0.total_cmp(&b.0));
    let quantile = |share: f64| {
        let mut sum = 0.0;
        squares
            .iter()
            .find(|(_, mass)| {
                sum += mass;
                sum >= share * total
            })
            .map_or(1.0, |(square, _)| *square)
    };
    let mut lobes: Vec<Lobe> = (0..count)
        .map(|k| {
            let variance = 0.7 * quantile((k as f64 + 0.5) / count as f64).max(MIN_VARIANCE);
            Lobe { share: 1.0 / count as f64, covariance: DVec3::new(variance, variance, 0.0) }
        })
        .collect();
    let round = matches!(slopes, Tabulated::Radial(_));
    let mut densities = vec![0.0; count];
    for _ in 0..ITERATIONS {
        let gaussians: Vec<_> = lobes.iter().map(|lobe| (lobe.share, Gaussian::new(lobe.covariance))).collect();
        let mut sums = vec![(0.0, DVec3::ZERO); count];
        for &(s, mass) in &points {
            let square = outer_square(s);
            let mut all = 0.0;
            for (density, (share, gaussian)) in densities.iter_mut().zip(&gaussians) {
                *density = share * gaussian.density(square);
                all += *density;
            }
            // For a slope far beyond all lobes, every density underflows. The widest lobe then gets the weight.
            if all <= 0.0 {
                densities[count - 1] = 1.0;
                all = 1.0;
            }
            for (sum, density) in sums.iter_mut().zip(&densities) {
                let part = mass * density / all;
                sum.0 += part;
                sum.1 += part * square;
            }
        }
        for (lobe, (mass, square)) in lobes.iter_mut().zip(&sums) {
            lobe.share = mass / total;
            if *mass > 1e-9 * total {
                let c = *square / *mass;
                let even = 0.5 * (c.x + c.y);
                let c = if round { DVec3::new(even, even, 0.0) } else { c };
                lobe.covariance = DVec3::new(c.x.max(MIN_VARIANCE), c.y.max(MIN_VARIANCE), c.z);
            }
        }
        lobes.sort_by(|a, b| (a.covariance.x + a.covariance.y).total_cmp(&(b.covariance.x + b.covariance.y)));
    }
    lobes.retain(|lobe| lobe.share > 1e-4);
    let all: f64 = lobes.iter().map(|lobe| lobe.share).sum();
    lobes.iter_mut().for_each(|lobe| lobe.share /= all);
    lobes
}

/// The errors of a material whose slopes are replaced by Gaussian lobes.
#[derive(Clone, Debug, PartialEq)]
pub struct LobeErrors {
    /// The lobes.
    pub lobes: Vec<Lobe>,
    /// The Kullback–Leibler divergence of the lobes from the slopes of the table, `∫ P ln (P / Q)`, in nats.
    pub slopes: f64,
    /// The misfit of the material to the samples.
    pub misfit: Misfit,
}

/// Replaces the slopes of a material by up to `count` lobes and compares the material with samples (thesis 5.3).
pub fn lobe_errors(material: &FittedBrdf, samples: &[Sample], count: usize) -> LobeErrors {
    let Microfacet { distribution, masking, fresnel } = &material.facets;
    let lobes = fit_lobes(distribution, count);
    let mixture = GaussianMixture::new(distribution.mean_slope(), &lobes);
    let (mut divergence, mut total) = (0.0, 0.0);
    for (slope, mass) in points(distribution) {
        divergence += mass * (distribution.p22(slope) / mixture.p22(slope).max(1e-300)).ln();
        total += mass;
    }
    let facets = Microfacet { distribution: mixture, masking: *masking, fresnel: fresnel.clone() };
    let misfit = misfit(samples, &FittedBrdf { facets, diffuse: material.diffuse });
    LobeErrors { lobes, slopes: divergence / total, misfit }
}

struct Gaussian {
    inverse: DVec3,
    peak: f64,
}

impl Gaussian {
    fn new(c: DVec3) -> Self {
        let det = (c.x * c.y - c.z * c.z).max(1e-12 * c.x * c.y);
        Self { inverse: DVec3::new(c.y, c.x, -2.0 * c.z) / det, peak: det.sqrt().recip() }
    }

    fn density(&self, square: DVec3) -> f64 {
        self.peak * (-0.5 * self.inverse.dot(square)).exp()
    }
}

/// Returns sample slopes of the table, with their masses.
fn points(slopes: &Tabulated) -> Vec<(DVec2, f64)> {
    let (mut angles, azimuths) = slopes.nodes();
    if azimuths == 1 {
        angles *= 4;
    }
    let mut all = Vec::with_capacity(angles * azimuths);
    for i in 0..angles {
        let u = (i as f64 + 0.5) / angles as f64;
        let theta = angle_at(u);
        let ring = PI * u / angles as f64 * theta.sin() * theta.cos() * TAU / azimuths as f64;
        for k in 0..azimuths {
            let phi = TAU * k as f64 / azimuths as f64;
            let mass = ring * slopes.ndf(direction(theta, phi));
            // For an isotropic table one azimuth is enough, because the squares of the diagonal slope equal the mean squares over all
            // azimuths.
            let slope = if azimuths == 1 {
                DVec2::splat(0.5f64.sqrt()) * theta.tan()
            } else {
                -theta.tan() * DVec2::from_angle(phi)
            };
            if mass > 0.0 {
                all.push((slope, mass));
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extraction::samples::samples;
    use crate::facets::fresnel::Fresnel;
    use crate::facets::ggx::Ggx;
    use crate::facets::polar_table::PolarTable;
    use crate::facets::radial_table::RadialTable;
    use crate::masking::variants::Masking;

    fn radial(of: &GaussianMixture) -> Tabulated {
        let at = |i: usize| {
            let (sine, cosine) = angle_at(i as f64 / 90.0).sin_cos();
            of.ndf(DVec3::new(sine, 0.0, cosine))
        };
        Tabulated::Radial(RadialTable::new(&(0..90).map(at).collect::<Vec<_>>()).unwrap())
    }

    fn polar(of: &GaussianMixture) -> Tabulated {
        let at = |i: usize, k: usize| {
            let (sine, cosine) = angle_at(i as f64 / 90.0).sin_cos();
            let phi = TAU * k as f64 / 72.0;
            of.ndf(DVec3::new(sine * phi.cos(), sine * phi.sin(), cosine))
        };
        let rows: Vec<Vec<f64>> = (0..72).map(|k| (0..90).map(|i| at(i, k)).collect()).collect();
        Tabulated::Polar(PolarTable::new(&rows).unwrap())
    }

    #[test]
    fn lobes_of_a_mixture_are_found() {
        let lobe = |share, xx, yy, xy| Lobe { share, covariance: DVec3::new(xx, yy, xy) };
        let round = [lobe(0.6, 0.002, 0.002, 0.0), lobe(0.4, 0.1, 0.1, 0.0)];
        let found = fit_lobes(&radial(&GaussianMixture::new(DVec2::ZERO, &round)), 2);
        check(&found, &round);
        let long = [lobe(0.7, 0.004, 0.02, 0.003), lobe(0.3, 0.2, 0.1, -0.05)];
        let found = fit_lobes(&polar(&GaussianMixture::new(DVec2::ZERO, &long)), 2);
        check(&found, &long);
    }

    fn check(found: &[Lobe], expected: &[Lobe]) {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            let error = (found.covariance - expected.covariance).length() / expected.covariance.length();
            assert!((found.share - expected.share).abs() < 0.01 && error < 0.02, "{found:?} {expected:?}");
        }
    }

    /// A distribution with long tails needs many lobes.
    #[test]
    fn more_lobes_are_closer() {
        let ggx = Ggx::isotropic(DVec2::ZERO, 0.2);
        let at = |i: usize| {
            let (sine, cosine) = angle_at(i as f64 / 90.0).sin_cos();
            ggx.ndf(DVec3::new(sine, 0.0, cosine))
        };
        let distribution = Tabulated::Radial(RadialTable::new(&(0..90).map(at).collect::<Vec<_>>()).unwrap());
        let facets = Microfacet { distribution, masking: Masking::SmithCorrelated, fresnel: Fresnel::Ideal };
        let material = FittedBrdf { facets, diffuse: DVec3::ZERO };
        let samples = samples(&material, true);
        let errors: Vec<LobeErrors> = (1..=MOST_LOBES).map(|count| lobe_errors(&material, &samples, count)).collect();
        for error in &errors {
            println!("{} lobes: {:.5} {:?}", error.lobes.len(), error.slopes, error.misfit);
        }
        assert!(errors.windows(2).all(|pair| pair[1].slopes < 1.001 * pair[0].slopes));
        let [one, eight] = [&errors[0], &errors[MOST_LOBES - 1]];
        assert!(eight.lobes.len() == MOST_LOBES && eight.slopes < 0.01 * one.slopes, "{} {}", one.slopes, eight.slopes);
        assert!(eight.misfit.perceptual < 0.1 * one.misfit.perceptual, "{:?} {:?}", one.misfit, eight.misfit);
    }

    #[test]
    fn one_lobe_has_the_second_moments() {
        let one = GaussianMixture::new(DVec2::ZERO, &[Lobe { share: 1.0, covariance: DVec3::new(0.03, 0.03, 0.0) }]);
        for count in [0, 1] {
            let found = fit_lobes(&radial(&one), count);
            assert!(found.len() == 1 && (found[0].covariance.x / 0.03 - 1.0).abs() < 1e-3, "{found:?}");
        }
        // Extra lobes are harmless, because their sum equals the single lobe.
        let many = fit_lobes(&radial(&one), 9);
        let variance: f64 = many.iter().map(|lobe| lobe.share * lobe.covariance.x).sum();
        assert!(many.len() <= MOST_LOBES && (variance / 0.03 - 1.0).abs() < 1e-3, "{many:?}");
    }
}
