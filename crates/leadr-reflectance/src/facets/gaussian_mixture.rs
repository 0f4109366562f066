//! A mixture of Gaussian slope lobes about one mean. The convolution of the mixture with the slopes of a relief is also a mixture (LEADR
//! 4.1, thesis 5.1). The relief's covariance adds to the covariance of each lobe, and each lobe has its own visible area.

use glam::{DVec2, DVec3};

use super::beckmann::Beckmann;
use super::slope_distribution::SlopeDistribution;

/// The maximum number of lobes in a fit. The thesis compares one lobe with eight (5.3).
pub const MOST_LOBES: usize = 8;
/// The maximum number of lobes that the renderer draws.
pub const DRAWN_LOBES: usize = 4;

/// One Gaussian lobe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// The fraction of the facets that belong to this lobe, from 0 to 1.
    pub share: f64,
    /// The slope covariance `(xx, yy, xy)`.
    pub covariance: DVec3,
}

/// A mixture of lobes whose weights sum to one.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianMixture {
    lobes: Vec<(f64, Beckmann)>,
    mean: DVec2,
    covariance: DVec3,
}

impl GaussianMixture {
    /// Creates a mixture about a mean slope. The weights of the lobes are normalised to sum to one.
    pub fn new(mean: DVec2, lobes: &[Lobe]) -> Self {
        let all = lobes.iter().map(|lobe| lobe.share).sum::<f64>().max(f64::MIN_POSITIVE);
        let covariance = lobes.iter().map(|lobe| lobe.share / all * lobe.covariance).sum();
        let lobes = lobes.iter().map(|lobe| (lobe.share / all, Beckmann::new(mean, lobe.covariance))).collect();
        Self { lobes, mean, covariance }
    }

    /// Returns the weight and the distribution of each lobe.
    pub fn lobes(&self) -> &[(f64, Beckmann)] {
        &self.lobes
    }

    fn sum(&self, of: impl Fn(&Beckmann) -> f64) -> f64 {
        self.lobes.iter().map(|(share, lobe)| share * of(lobe)).sum()
    }
}

impl SlopeDistribution for GaussianMixture {
    fn p22(&self, slope: DVec2) -> f64 {
        self.sum(|lobe| lobe.p22(slope))
    }

    fn ndf(&self, wn: DVec3) -> f64 {
        self.sum(|lobe| lobe.ndf(wn))
    }

    fn mean_slope(&self) -> DVec2 {
        self.mean
    }

    fn shape(&self) -> DVec3 {
        self.covariance
    }

    fn visible_area(&self, w: DVec3) -> f64 {
        self.sum(|lobe| lobe.visible_area(w))
    }

    fn sample_visible(&self, wo: DVec3, u: DVec2) -> DVec3 {
        // Select a lobe with a probability proportional to its visible area. Rescale the random number to sample that lobe.
        let mut left = u.x * self.visible_area(wo);
        let last = self.lobes.len() - 1;
        for (i, (share, lobe)) in self.lobes.iter().enumerate() {
            let part = share * lobe.visible_area(wo);
            if left < part || i == last {
                return lobe.sample_visible(wo, DVec2::new((left / part.max(1e-300)).clamp(0.0, 1.0 - 1e-16), u.y));
            }
            left -= part;
        }
        DVec3::Z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn a_mixture_is_the_sum_of_its_lobes() {
        let lobe = |share: f64, v: f64| Lobe { share, covariance: DVec3::new(v, 2.0 * v, 0.5 * v) };
        let mean = DVec2::new(0.2, -0.1);
        let mixture = GaussianMixture::new(mean, &[lobe(3.0, 0.01), lobe(1.0, 0.3)]);
        let [a, b] = [0.01, 0.3].map(|v| Beckmann::new(mean, lobe(1.0, v).covariance));
        let mut sampled = DVec3::ZERO;
        let wo = DVec3::new(0.7, 0.1, 0.4).normalize();
        let count = 20_000;
        let (mut exact, mut mass) = (DVec3::ZERO, 0.0);
        for i in 0..count {
            let mut random = Random::stream(2, i);
            let w = random.on_sphere();
            assert!((mixture.ndf(w) - 0.75 * a.ndf(w) - 0.25 * b.ndf(w)).abs() < 1e-9 * mixture.ndf(w).max(1e-9));
            let area = 0.75 * a.visible_area(w) + 0.25 * b.visible_area(w);
            assert!((mixture.visible_area(w) - area).abs() < 1e-12);
            sampled += mixture.sample_visible(wo, DVec2::new(random.unit(), random.unit())) / count as f64;
            // Average the samples of each lobe, weighted by visible area.
            for (share, lobe) in [(0.75, &a), (0.25, &b)] {
                let part = share * lobe.visible_area(wo);
                exact += part * lobe.sample_visible(wo, DVec2::new(random.unit(), random.unit()));
                mass += part;
            }
        }
        assert!((sampled - exact / mass).length() < 0.01, "{sampled} {}", exact / mass);
        assert!(
            (mixture.shape() - (0.75 * lobe(1.0, 0.01).covariance + 0.25 * lobe(1.0, 0.3).covariance)).length() < 1e-12
        );
    }
}
