//! Computes roughness from the length of a mean normal, by Toksvig's factor and by von Mises–Fisher lobes.
//!
//! A von Mises–Fisher lobe `κ/(4π sinh κ) exp(κ cos θ)` has a mean of length `L = coth κ − 1/κ` (Langevin function). A narrow lobe is a
//! Gaussian of normals with the variance `1/κ` per axis, so `α² = 2/κ`. Engines add `c/κ` to the `α²` of the base, where `c` is 1/2, 3/4
//! or 2. The best value depends on the normal distribution (`docs/measurements/gloss.md`):
//!
//! * For *relief of Gaussian slopes* `c = 2` is right in the limit of small slopes. The resulting `α` is 3 % too small at `α` = .2, and
//!   13 % too small at .5. With `c` = 1/2, `α` is half as large.
//! * For *GGX facets* no constant is right, because the tails shorten the mean so that `α² κ → 1/(ln(2/α) − 1)`. The right `c` is 1/2 for
//!   `α` = .10, 3/4 for .22 and 2 for .70. [`shortened_normals`](super::shortened_normals) has the exact relation.

use super::gloss::usable_alpha;
use super::shortened_normals::{held_shortening, odds_of_shortening};
use crate::limits::held;
use crate::roots::increasing_root;

/// The largest concentration, which corresponds to an `α` of 4.5e-5.
pub const MAX_KAPPA: f64 = 1e9;

/// Returns `(1 − L)/L` of a von Mises–Fisher lobe of concentration `κ > 0`.
fn vmf_odds(kappa: f64) -> f64 {
    if kappa < 2.0 {
        // The continued fraction L = κ/(3 + κ²/(5 + κ²/(7 + …))) avoids cancellation.
        let square = kappa * kappa;
        let fraction = (1..20).rev().fold(0.0, |tail, k| square / (f64::from(2 * k + 3) + tail));
        return (3.0 + fraction) / kappa - 1.0;
    }
    let shortening = 1.0 / kappa - 2.0 / (2.0 * kappa).exp_m1();
    shortening / (1.0 - shortening)
}

fn held_kappa(kappa: f64) -> f64 {
    held(kappa, 1e-9, MAX_KAPPA)
}

/// Returns `1 − L` of a von Mises–Fisher lobe, with `L = coth κ − 1/κ`, without cancellation. `κ` is clamped to 1e-9..1e9, and NaN counts
/// as 1e-9.
pub fn vmf_shortening(kappa: f64) -> f64 {
    let odds = vmf_odds(held_kappa(kappa));
    odds / (1.0 + odds)
}

/// Returns the `κ`, from 1e-9 to 1e9, of the von Mises–Fisher lobe with this shortening of the mean. The function is the inverse of
/// [`vmf_shortening`]. The shortening is clamped to 0..1, and NaN is treated as 1.
pub fn vmf_kappa(shortening: f64) -> f64 {
    let wanted = odds_of_shortening(held_shortening(shortening)).ln();
    let end = MAX_KAPPA.ln();
    held_kappa((-increasing_root(-end, end, |width| vmf_odds((-width).exp()).ln() - wanted)).exp())
}

/// Returns the usual estimate of [`vmf_kappa`], `L (3 − L²)/(1 − L²)` for `L = 1 − shortening` (Banerjee et al. 2005). The estimate is
/// exact for `L = 0` and `L = 1`, and at most 5 % too large (at `L = .8`).
pub fn vmf_kappa_estimate(shortening: f64) -> f64 {
    let shortening = held_shortening(shortening);
    let length = 1.0 - shortening;
    held_kappa(length * (3.0 - length * length) / (shortening * (1.0 + length)).max(1e-300))
}

/// Returns the roughness `√(α² + c/κ)` of a base of roughness `alpha` under normals with this shortening of the mean. `c` is 2 for relief
/// of small Gaussian slopes.
pub fn vmf_alpha(alpha: f64, shortening: f64, c: f64) -> f64 {
    usable_alpha((alpha * alpha + c / vmf_kappa(shortening)).sqrt())
}

/// Returns Toksvig's factor of a Blinn-Phong exponent, `L/(L + n (1 − L))` for `L = 1 − shortening` (Toksvig 2005). The factor is from 0
/// to 1.
pub fn toksvig_factor(shortening: f64, exponent: f64) -> f64 {
    let shortening = held_shortening(shortening);
    let length = 1.0 - shortening;
    length / (length + held(exponent, 0.0, 1e18) * shortening).max(1e-300)
}

/// Returns Toksvig's variance of normals per axis, `(1 − L)/L` for `L = 1 − shortening`, at most 1e6 (Toksvig 2005).
pub fn toksvig_normal_variance(shortening: f64) -> f64 {
    let shortening = held_shortening(shortening);
    shortening / (1.0 - shortening).max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::shortened_normals::{NormalArea, NormalFacets, Shortening};
    use crate::quadrature::composite_gauss;
    use std::f64::consts::SQRT_2;

    #[test]
    fn a_lobe_has_its_mean() {
        for kappa in [1e-3, 0.3, 1.0, 1.999, 2.001, 8.0, 100.0, 3e4] {
            // Integrate over d = 1 − cos θ, with the density divided by its peak.
            let end = (60.0f64 / kappa).min(2.0);
            let (mut one_minus_length, mut norm) = (0.0, 0.0);
            for (d, w) in composite_gauss(0.0, end, 24, 12) {
                let density = w * (-kappa * d).exp();
                (one_minus_length, norm) = (one_minus_length + density * d, norm + density);
            }
            assert!((vmf_shortening(kappa) / (one_minus_length / norm) - 1.0).abs() < 1e-12, "{kappa}");
            assert!((vmf_kappa(vmf_shortening(kappa)) / kappa - 1.0).abs() < 3e-13 * (1.0 + 1.0 / kappa), "{kappa}");
        }
    }

    #[test]
    fn the_estimate_of_kappa() {
        let mut worst = (0.0f64, 0.0);
        for i in 1..1000 {
            let one_minus_length = f64::from(i) / 1000.0;
            let error = vmf_kappa_estimate(one_minus_length) / vmf_kappa(one_minus_length) - 1.0;
            if error.abs() > worst.0.abs() {
                worst = (error, one_minus_length);
            }
        }
        println!("L (3 - L^2)/(1 - L^2): largest relative error {:.3}, at L = {:.3}", worst.0, 1.0 - worst.1);
        assert!(worst.0.abs() < 0.1 && worst.0.abs() > 0.03);
        for one_minus_length in [1e-6, 1.0 - 1e-6] {
            assert!((vmf_kappa_estimate(one_minus_length) / vmf_kappa(one_minus_length) - 1.0).abs() < 2e-6);
        }
    }

    #[test]
    fn any_number_has_a_lobe() {
        for x in [f64::NAN, f64::NEG_INFINITY, -1.0, 0.0, 1e-300, 1.0, 2.0, f64::INFINITY] {
            for y in [vmf_shortening(x), toksvig_factor(x, 10.0), toksvig_factor(0.5, x)] {
                assert!((0.0..=1.0).contains(&y), "{x}: {y}");
            }
            for y in [vmf_kappa(x), vmf_kappa_estimate(x), toksvig_normal_variance(x), vmf_alpha(0.1, x, 2.0)] {
                assert!(y.is_finite() && y >= 0.0, "{x}: {y}");
            }
        }
        assert!((vmf_kappa(0.0) / MAX_KAPPA - 1.0).abs() < 1e-12 && vmf_kappa_estimate(0.0) == MAX_KAPPA);
    }

    /// Finds the `c` that recovers the roughness of a distribution from the length of its mean normal. The test prints `α² κ`.
    #[test]
    fn roughness_recovery_per_variant() {
        println!("alpha   alpha^2 kappa of GGX   of Beckmann   alpha of GGX by c = 1/2, 3/4, 2   of Beckmann");
        let shortening = |facets| Shortening { facets, area: NormalArea::Macro };
        let ideal = |facets, alpha: f64| alpha * alpha * vmf_kappa(shortening(facets).one_minus_length(alpha));
        for alpha in [0.01, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0] {
            let by = |facets| {
                let factor = ideal(facets, alpha);
                let given = [0.5, 0.75, 2.0].map(|c| vmf_alpha(0.0, shortening(facets).one_minus_length(alpha), c));
                for (c, given) in [0.5, 0.75, 2.0].into_iter().zip(given) {
                    assert!((given / alpha - (c / factor).sqrt()).abs() < 1e-6);
                }
                (factor, given)
            };
            let ((g, of_ggx), (b, of_beckmann)) = (by(NormalFacets::Ggx), by(NormalFacets::Beckmann));
            println!("{alpha:<7} {g:.3} {b:.3} {of_ggx:.4?} {of_beckmann:.4?}");
        }
        // For narrow lobes of Gaussian slopes the best c is 2.
        assert!((ideal(NormalFacets::Beckmann, 1e-3) - 2.0).abs() < 1e-5);
        // No constant c is right for GGX, because its shortening is α² (ln(2/α) − 1).
        for alpha in [1e-3f64, 1e-2] {
            let limit = 1.0 / ((2.0 / alpha).ln() - 1.0);
            assert!((ideal(NormalFacets::Ggx, alpha) / limit - 1.0).abs() < 2e-3);
        }
        let crossing = |c: f64| increasing_root(-6.0, 0.0, |x| ideal(NormalFacets::Ggx, x.exp()) - c).exp();
        println!("c = 1/2, 3/4, 2 are right for GGX of alpha = {:.3?}", [0.5, 0.75, 2.0].map(crossing));
    }

    /// Compares models of the total roughness of a GGX base under relief with Gaussian slopes.
    ///
    /// The reference is the exact slope distribution. GGX is a mixture of Gaussians of covariance `τ A`, where `1/τ` has an exponential
    /// distribution, so the relief changes the covariances to `τ α²/2 + s²`. The nearest single lobe is the GGX lobe that minimises half
    /// the integral of the absolute difference.
    #[test]
    fn relief_over_a_base() {
        let shortening = Shortening::default();
        let relief_shortening = Shortening { facets: NormalFacets::Beckmann, area: NormalArea::Macro };
        println!(
            "base s | difference by 2 s^2, c/kappa (1/2, 3/4, 2), product of lengths, length of all, nearest | their alpha"
        );
        for (base, s) in
            [(0.05, 0.05), (0.05, 0.2), (0.05, 0.5), (0.2, 0.05), (0.2, 0.2), (0.2, 0.5), (0.5, 0.2), (0.5, 0.5)]
        {
            let truth = Sum::new(base, s);
            let one_minus_length = relief_shortening.one_minus_length(SQRT_2 * s);
            let by_slopes = (base * base + 2.0 * s * s).sqrt();
            let others = [0.5, 0.75, 2.0].map(|c| vmf_alpha(base, one_minus_length, c));
            let product = 1.0 - (1.0 - shortening.one_minus_length(base)) * (1.0 - one_minus_length);
            let of_all = truth.mean(|square| 1.0 - 1.0 / (1.0 + square).sqrt());
            let nearest = (0..=200)
                .map(|i| base * 10f64.powf(f64::from(i) * 0.01))
                .min_by(|a, b| truth.difference(*a).total_cmp(&truth.difference(*b)))
                .unwrap();
            let alphas = [
                by_slopes,
                others[0],
                others[1],
                others[2],
                shortening.alpha_of_shortening(product),
                shortening.alpha_of_shortening(of_all),
                nearest,
            ];
            let differences = alphas.map(|alpha| truth.difference(alpha));
            println!("{base} {s} | {differences:.3?} | {alphas:.3?}");
            assert!(differences.iter().all(|d| *d >= differences[6] - 1e-3 && *d < 1.0));
            // The sum of the variances gives a lobe close to the nearest lobe. On a smooth base, c = 1/2 gives a worse lobe.
            assert!(differences[0] < differences[6] + 0.03, "{base} {s}");
            if s > 2.0 * base {
                assert!(differences[1] > 1.5 * differences[0] && differences[4] > differences[0], "{base} {s}");
            }
        }
    }

    /// The slope distribution of a GGX base plus Gaussian relief, as a function of the squared slope length.
    struct Sum {
        /// The nodes `(square, dsquare, density dsquare)`, whose densities sum to 1.
        nodes: Vec<(f64, f64, f64)>,
    }

    impl Sum {
        fn new(base: f64, s: f64) -> Self {
            // The variances per axis and their weights, where 1/τ has an exponential distribution of mean 1.
            let mixture: Vec<(f64, f64)> = composite_gauss(-12.0, 3.7, 24, 6)
                .into_iter()
                .map(|(log, w)| (base * base * 0.5 / log.exp() + s * s, w * (log - log.exp()).exp()))
                .collect();
            let low = (1e-3 * (base * base + s * s)).ln();
            let nodes = composite_gauss(low - 5.0, 12.0, 48, 6)
                .into_iter()
                .map(|(log, w)| {
                    let square = log.exp();
                    let density: f64 = mixture.iter().map(|(v, p)| p * (-0.5 * square / v).exp() / (2.0 * v)).sum();
                    (square, w * square, w * square * density)
                })
                .collect();
            Self { nodes }
        }

        fn mean(&self, f: impl Fn(f64) -> f64) -> f64 {
            let total: f64 = self.nodes.iter().map(|n| n.2).sum();
            assert!((total - 1.0).abs() < 2e-3, "{total}");
            self.nodes.iter().map(|&(square, _, w)| w * f(square)).sum::<f64>() / total
        }

        /// Returns half the integral of the absolute difference from a GGX lobe of roughness `alpha`.
        fn difference(&self, alpha: f64) -> f64 {
            let a = alpha * alpha;
            let ggx = |square: f64| a / (a + square).powi(2);
            self.nodes.iter().map(|&(square, measure, w)| 0.5 * (w - measure * ggx(square)).abs()).sum()
        }
    }
}
