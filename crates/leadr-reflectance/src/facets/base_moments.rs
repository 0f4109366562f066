//! What a base material adds to the slopes under a pixel: the downsampling operator of thesis 5.1 for any base.
//!
//! Slopes of a relief and of its base are independent, so the filtered slopes are their convolution, whose first two moments are
//! [sums](add_moments) of theirs (thesis, Listing 5.1). Beckmann bases need no more than that, since Gaussians stay Gaussians. For the others it is one
//! Gaussian of the right variance, which their tails make too wide; a mixture of lobes ([`GaussianMixture`]) keeps
//! the peak and the tails. GGX has no variance at all: it is cut off at a largest slope, or treated as a
//! mixture.

use glam::{DVec2, DVec3};

use super::beckmann::Beckmann;
use super::ellipse::ellipse_from_roughness;
use super::gaussian_mixture::GaussianMixture;
use super::slope_distribution::SlopeDistribution as _;
use super::tabulated::Tabulated;
use crate::slopes::moments::{SlopeMoments, add_moments, moments_of_distribution};

/// A distribution of slopes with two moments.
pub trait BaseMoments {
    /// `E[x], E[y]` and `E[x²], E[y²], E[xy]`.
    fn base_moments(&self) -> SlopeMoments;
}

impl BaseMoments for Beckmann {
    fn base_moments(&self) -> SlopeMoments {
        moments_of_distribution(self.mean_slope(), self.shape())
    }
}

impl BaseMoments for GaussianMixture {
    fn base_moments(&self) -> SlopeMoments {
        moments_of_distribution(self.mean_slope(), self.shape())
    }
}

impl BaseMoments for Tabulated {
    /// Of the slopes that the table has: finite for every table.
    fn base_moments(&self) -> SlopeMoments {
        moments_of_distribution(self.mean_slope(), self.shape())
    }
}

/// The filtered moments of a displacement map with a base material on it.
#[must_use]
pub fn with_base(map: SlopeMoments, base: &impl BaseMoments) -> SlopeMoments {
    add_moments(map, base.base_moments())
}

/// Covariance of GGX slopes `s` of roughness matrix `a` (`α²` terms) within `sᵀ a⁻¹ s ≤ largest²`, and the share of the slopes that lie
/// there.
///
/// `a/2 ((1 + 1/k) ln(1 + k) − 1)` for `k = largest²`: it grows without end, however slowly.
#[must_use]
pub fn truncated_ggx(a: DVec3, largest: f64) -> (DVec3, f64) {
    let k = largest * largest;
    let share = k / (1.0 + k);
    (0.5 * a * (k.ln_1p() / share - 1.0), share)
}

/// Where GGX slopes are cut off if steeper ones than `slope` count for nothing, in terms of [`truncated_ggx`].
#[must_use]
pub fn truncation_at(a: DVec3, slope: f64) -> f64 {
    slope / ellipse_from_roughness(a).radii.max_element()
}

/// Filtered moments of a displacement map on a GGX base that is cut off at a slope.
#[must_use]
pub fn with_ggx_base(map: SlopeMoments, mean: DVec2, a: DVec3, slope: f64) -> SlopeMoments {
    let (covariance, _) = truncated_ggx(a, truncation_at(a, slope));
    add_moments(map, moments_of_distribution(mean, covariance))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::extraction::lobes::fit_lobes;
    use crate::facets::ggx::Ggx;
    use crate::facets::polar_table::PolarTable;
    use crate::facets::radial_table::{RadialTable, angle_at};
    use crate::facets::slope_distribution::SlopeDistribution;
    use crate::integrals::ggx_filtering::{displaced_ggx, displaced_ggx_p22};
    use crate::random::Random;
    use crate::slopes::moments::{mix_moments, moments_covariance, moments_of_slope, roughen_moments};

    fn normal(i: usize, n: usize, phi: f64) -> DVec3 {
        let (sine, cosine) = angle_at(i as f64 / n as f64).sin_cos();
        DVec3::new(sine * phi.cos(), sine * phi.sin(), cosine)
    }

    fn radial(of: &impl SlopeDistribution) -> Tabulated {
        let densities: Vec<f64> = (0..90).map(|i| of.ndf(normal(i, 90, 0.0))).collect();
        Tabulated::Radial(RadialTable::new(&densities).unwrap())
    }

    fn polar(of: &impl SlopeDistribution) -> Tabulated {
        let row = |k: usize| (0..90).map(|i| of.ndf(normal(i, 90, TAU * k as f64 / 90.0))).collect();
        Tabulated::Polar(PolarTable::new(&(0..90).map(row).collect::<Vec<_>>()).unwrap())
    }

    /// Every level of the mips of a rough relief, with its base added before or after them: LEADR 4.1.
    #[test]
    fn beckmann_bases_are_the_papers() {
        let mut random = Random(4);
        let mut level: Vec<SlopeMoments> =
            (0..256).map(|_| moments_of_slope(DVec2::new(random.range(-1.0, 1.0), random.range(-0.5, 0.8)))).collect();
        let alpha = 0.3;
        let v = 0.5 * alpha * alpha;
        let base = Beckmann::new(DVec2::ZERO, DVec3::new(v, v, 0.0));
        let mut rough: Vec<SlopeMoments> = level.iter().map(|m| roughen_moments(*m, alpha)).collect();
        while level.len() > 1 {
            let halved = |of: &[SlopeMoments]| of.chunks(2).map(|two| mix_moments(two[0], two[1], 0.5)).collect();
            (level, rough) = (halved(&level), halved(&rough));
            for (map, paper) in level.iter().zip(&rough) {
                let found = with_base(*map, &base);
                assert!((found.first - paper.first).length() < 1e-6 && (found.second - paper.second).length() < 1e-6);
                // Two slopes are perfectly correlated, which covariances of maps never are.
                if level.len() <= 64 {
                    let wider = moments_covariance(found) - moments_covariance(*map);
                    assert!((wider - DVec3::new(v, v, 0.0)).length() < 1e-6, "{wider}");
                }
            }
        }
    }

    /// Brushed bases with their correlation: `α² = α_X² + α_Y²`, `ρ = (ρ_X α_X.. + ρ_Y ..) / (α_x α_y)`, whose denominator the thesis misprints.
    #[test]
    fn correlations_add() {
        let (x, y) = (DVec3::new(0.02, 0.08, 0.015), DVec3::new(0.05, 0.01, -0.01));
        let [m, n] = [DVec2::new(0.3, -0.2), DVec2::new(-0.1, 0.4)];
        let sum = with_base(moments_of_distribution(m, x), &Beckmann::new(n, y));
        let covariance = moments_covariance(sum);
        assert!((covariance - (x + y)).length() < 1e-9 && (sum.first - (m + n)).length() < 1e-12);
        let rho = |s: DVec3| s.z / (s.x * s.y).sqrt();
        let expected =
            (rho(x) * (x.x * x.y).sqrt() + rho(y) * (y.x * y.y).sqrt()) / ((x.x + y.x).sqrt() * (x.y + y.y).sqrt());
        assert!((rho(covariance) - expected).abs() < 1e-9);
    }

    /// Moments of tables against the closed ones of what they were made from, and against quadrature over the table.
    #[test]
    fn tables_have_the_moments_of_their_slopes() {
        let round = Beckmann::new(DVec2::ZERO, DVec3::new(0.02, 0.02, 0.0));
        let long = Beckmann::new(DVec2::ZERO, DVec3::new(0.03, 0.008, 0.006));
        let ggx = Ggx::new(DVec2::ZERO, DVec3::new(0.04, 0.09, 0.01));
        for (table, exact) in [
            (radial(&round), Some(round.base_moments())),
            (polar(&long), Some(long.base_moments())),
            (polar(&ggx), None),
            (radial(&Ggx::isotropic(DVec2::ZERO, 0.1)), None),
        ] {
            let found = table.base_moments();
            let quadrature =
                DVec3::new(table.mean_of(|s| s.x * s.x), table.mean_of(|s| s.y * s.y), table.mean_of(|s| s.x * s.y));
            let scale = found.second.length();
            assert!((found.second - quadrature).length() < 1e-4 * scale, "{} {quadrature}", found.second);
            if let Some(exact) = exact {
                assert!((found.second - exact.second).length() < 1e-4 * scale, "{} {}", found.second, exact.second);
                assert!((found.first - exact.first).length() < 1e-4);
            }
        }
    }

    #[test]
    fn truncated_slopes_have_a_variance() {
        let a = DVec3::new(0.04, 0.09, 0.01);
        let ggx = Ggx::new(DVec2::ZERO, a);
        for largest in [0.5, 3.0, 40.0] {
            let (covariance, share) = truncated_ggx(a, largest);
            // Over the ellipse, by rings of even steps in ln(1 + r²).
            let (n, m) = (2000, 64);
            let root = crate::slopes::grid::slope_cholesky(a);
            let (mut sum, mut mass) = (DVec3::ZERO, 0.0);
            let end = (largest * largest).ln_1p();
            for i in 0..n {
                let t = end * (f64::from(i) + 0.5) / f64::from(n);
                let r = t.exp_m1().sqrt();
                for k in 0..m {
                    let p = r * DVec2::from_angle(TAU * (f64::from(k) + 0.5) / f64::from(m));
                    let s = DVec2::new(root.x * p.x, root.y * p.x + root.z * p.y);
                    let area = 0.5 * t.exp() * end / f64::from(n) * TAU / f64::from(m) * root.x * root.z;
                    let weight = ggx.p22(s) * area;
                    sum += weight * DVec3::new(s.x * s.x, s.y * s.y, s.x * s.y);
                    mass += weight;
                }
            }
            assert!((mass - share).abs() < 1e-5 && (sum / mass - covariance).length() < 1e-5 * covariance.length());
        }
        assert!((truncation_at(DVec3::new(0.04, 0.04, 0.0), 2.0) - 10.0).abs() < 1e-9);
        // A base that is not cut off in time is anything but itself.
        let flat = SlopeMoments::default();
        let at = |slope| moments_covariance(with_ggx_base(flat, DVec2::ZERO, DVec3::new(0.01, 0.01, 0.0), slope)).x;
        assert!(at(1e3) > 3.0 * at(1.0));
    }

    /// `∫ |P − Q|` between the filtered slopes of a GGX base on a Gaussian relief and each form of them.
    #[test]
    fn errors_of_the_forms_of_a_ggx_base() {
        let alpha = 0.2f64;
        let lobes = fit_lobes(&radial(&Ggx::isotropic(DVec2::ZERO, alpha)), 4);
        println!(
            "relief's deviation | one Gaussian, cut off at a slope of 1 | at 10 | GGX and Beckmann | four Gaussians"
        );
        for sigma in [0.02f64, 0.1, 0.3, 1.0] {
            let gaussian = |r2: f64, v: f64| (-0.5 * r2 / v).exp() / (TAU * v);
            // GGX is a mixture of Gaussians of variance α²/2e, whose e is exponentially distributed; e = −ln u.
            let exact = |r2: f64| {
                let n = 4000;
                let at = |i: i32| {
                    let e = -((f64::from(i) + 0.5) / f64::from(n)).ln();
                    gaussian(r2, sigma * sigma + 0.5 * alpha * alpha / e)
                };
                (0..n).map(at).sum::<f64>() / f64::from(n)
            };
            let distance = |of: &dyn Fn(f64) -> f64| {
                let n = 400;
                let end = 1e4f64.ln_1p();
                let ring = |i: i32| {
                    let t = end * (f64::from(i) + 0.5) / f64::from(n);
                    let r2 = t.exp_m1() * 1e-2;
                    (exact(r2) - of(r2)).abs() * PI * 1e-2 * t.exp() * end / f64::from(n)
                };
                (0..n).map(ring).sum::<f64>()
            };
            let relief = SlopeMoments { first: DVec2::ZERO, second: DVec3::new(sigma * sigma, sigma * sigma, 0.0) };
            let a = DVec3::new(alpha * alpha, alpha * alpha, 0.0);
            let cut = |slope: f64| {
                let v = with_ggx_base(relief, DVec2::ZERO, a, slope).second.x;
                distance(&|r2| gaussian(r2, v))
            };
            let two = displaced_ggx(a, relief.second);
            let two = distance(&|r2| displaced_ggx_p22(DVec2::new(r2.sqrt(), 0.0), DVec2::ZERO, &two));
            let four = distance(&|r2| {
                lobes.iter().map(|l| l.share * gaussian(r2, sigma * sigma + l.covariance.x)).sum::<f64>()
            });
            let (near, far) = (cut(1.0), cut(10.0));
            println!("{sigma} | {near:.3} | {far:.3} | {two:.3} | {four:.3}");
            assert!(four < 0.35 * near && two < near && near < far, "{sigma}: {near} {far} {two} {four}");
        }
    }
}
