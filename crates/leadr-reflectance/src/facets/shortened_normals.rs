//! The mean normal length of rough facets, and its inverse, the roughness for a given length (Chan 2018, section 2).
//!
//! The mean normal of isotropic facets points along the surface normal, and gets shorter with roughness. Two means are in use, weighted by
//! macrosurface area or by microsurface area:
//!
//! ```text
//! by macrosurface area   L = ∫ D cos² θ dω = E[cos θ]                eq. 18
//! by microsurface area   L = 1 / ∫ D dω   = 1 / E[1 / cos θ]         eq. 12
//! ```
//!
//! The expectation `E` is over the slope density. Let `A = α²` and `e = 1 − A`. All results for GGX use the functions `T` and `S`,
//!
//! ```text
//! T(e) = atanh(√e)/√e   (atan(√−e)/√−e for α > 1)   = Σ eᵏ/(2k + 1)
//! S(e) = (T − 1)/e                                  = Σ eᵏ/(2k + 3)
//! macro:  L = (1 − A T)/e,    1 − L = A S           eq. 26
//! micro:  L = 1/(1 + A T),    1/L − 1 = A T         eq. 24
//! ```
//!
//! Near `α = 1` the closed forms are 0/0, so series replace them. For Beckmann facets, with Mills' ratio `M` at `t = √2/α`,
//!
//! ```text
//! macro:  L = t M(t) = (√π/α) e^(1/α²) erfc(1/α)
//! micro:  L = 1/(1 + A L_macro/2)                   by parts
//! ```
//!
//! **Precision.** The mean normals of smooth facets have lengths near 1. A length near 1 holds few digits of the *shortening* `1 − L`,
//! which is 4e-5 for `α = .0028`. All functions of this module use the *odds* `(1 − L)/L`, which are precise for smooth and for rough
//! facets. The inverse functions take the shortening. Toksvig (2005) used the odds as the variance of normals. The log odds are nearly
//! linear in `ln A`, with slopes from 1 down to ½, so root finding takes few steps.
//!
//! **Ranges.** GGX facets of `α ≤ 1` have lengths from 2/3 (macro) or 1/2 (micro) to 1. Shorter lengths mean rougher facets, up to
//! `α = 100`. A length below 0 or NaN gives the largest roughness, and a length above 1 gives the smallest.

use super::gloss::{Gloss, usable_alpha};
use super::normal_distribution::{mills_ratio, tail_mean_ratio};
use crate::limits::{MAX_SLOPE, MIN_VARIANCE, held, unit};
use crate::roots::increasing_root;
use std::f64::consts::SQRT_2;

/// The value of `|1 − α²|` below which series replace the closed forms.
const SERIES_END: f64 = 0.3;

/// Sums the series `Σ eᵏ c(k)` to rounding error, for `|e| ≤ SERIES_END` and `|c| ≤ 1`.
fn series(e: f64, c: impl Fn(f64) -> f64) -> f64 {
    (0..34).rev().fold(0.0, |sum, k| sum * e + c(f64::from(k)))
}

/// Returns `T = atanh(√e)/√e` for `e = 1 − square` and `square = α² > 0`, or `atan(√−e)/√−e` if `square > 1`.
fn atanh_ratio(square: f64) -> f64 {
    let e = 1.0 - square;
    if e.abs() < SERIES_END {
        series(e, |k| 1.0 / (2.0 * k + 1.0))
    } else if e > 0.0 {
        // The form atanh a = ln((1 + a)/α) avoids cancellation as a → 1.
        let a = e.sqrt();
        ((1.0 + a) / square.sqrt()).ln() / a
    } else {
        let b = (-e).sqrt();
        b.atan() / b
    }
}

/// Returns `(1 − L)/L` of GGX facets weighted by microsurface area, which is `α² T` (Chan eq. 24). `square` is `α²`.
pub fn ggx_normal_odds_micro(square: f64) -> f64 {
    square * atanh_ratio(square)
}

/// Returns `(1 − L)/L` of GGX facets weighted by macrosurface area (Chan eq. 26). `square` is `α²`.
pub fn ggx_normal_odds_macro(square: f64) -> f64 {
    let e = 1.0 - square;
    if e.abs() < SERIES_END {
        let shortening = square * series(e, |k| 1.0 / (2.0 * k + 3.0));
        return shortening / series(e, |k| 2.0 / ((2.0 * k + 1.0) * (2.0 * k + 3.0)));
    }
    let ratio = atanh_ratio(square);
    square * (ratio - 1.0) / (1.0 - square * ratio)
}

/// Returns `(1 − L)/L` of Beckmann facets weighted by macrosurface area. `square` is `α²`.
pub fn beckmann_normal_odds_macro(square: f64) -> f64 {
    let t = SQRT_2 / square.sqrt();
    tail_mean_ratio(t) / (t * mills_ratio(t))
}

/// Returns `(1 − L)/L` of Beckmann facets weighted by microsurface area. The value is `α²/2` times the length that is weighted by
/// macrosurface area. `square` is `α²`.
pub fn beckmann_normal_odds_micro(square: f64) -> f64 {
    let t = SQRT_2 / square.sqrt();
    0.5 * square * (t * mills_ratio(t))
}

/// Clamps a shortening to 0..1. NaN gives 1.
pub(super) fn held_shortening(shortening: f64) -> f64 {
    if shortening.is_nan() { 1.0 } else { shortening.clamp(0.0, 1.0) }
}

/// Returns the odds `(1 − L)/L` of a shortening in 0..1, clamped to 1e-300..1e300.
pub(super) fn odds_of_shortening(shortening: f64) -> f64 {
    (shortening / (1.0 - shortening).max(1e-300)).max(1e-300)
}

/// The area measure over which normals are averaged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NormalArea {
    /// The microsurface area, which is the area of the facets (Chan's Algorithm 1, eq. 12).
    Micro,
    /// The macrosurface area, by which texture filters weight their texels (Chan's Algorithm 2, eq. 18).
    #[default]
    Macro,
}

/// The slope distribution of the facets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NormalFacets {
    /// The Beckmann distribution, with Gaussian slopes.
    Beckmann,
    /// The GGX distribution, with Student's t slopes of two degrees of freedom.
    #[default]
    Ggx,
}

/// A model that relates roughness and mean normal length. The default is Chan's model, GGX weighted by macrosurface area.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shortening {
    /// The slope distribution of the facets.
    pub facets: NormalFacets,
    /// The area measure of the mean normal.
    pub area: NormalArea,
}

impl Shortening {
    /// All four combinations of a slope distribution and an area measure.
    pub const ALL: [Self; 4] = [
        Self { facets: NormalFacets::Ggx, area: NormalArea::Macro },
        Self { facets: NormalFacets::Ggx, area: NormalArea::Micro },
        Self { facets: NormalFacets::Beckmann, area: NormalArea::Macro },
        Self { facets: NormalFacets::Beckmann, area: NormalArea::Micro },
    ];

    /// Returns `(1 − L)/L` for `α`, which is clamped to 1e-4..100.
    pub fn odds(self, alpha: f64) -> f64 {
        self.odds_of_square(usable_alpha(alpha).powi(2))
    }

    fn odds_of_square(self, square: f64) -> f64 {
        match (self.facets, self.area) {
            (NormalFacets::Ggx, NormalArea::Micro) => ggx_normal_odds_micro(square),
            (NormalFacets::Ggx, NormalArea::Macro) => ggx_normal_odds_macro(square),
            (NormalFacets::Beckmann, NormalArea::Micro) => beckmann_normal_odds_micro(square),
            (NormalFacets::Beckmann, NormalArea::Macro) => beckmann_normal_odds_macro(square),
        }
    }

    /// Returns the shortening of the mean normal, `1 − L`, without cancellation.
    pub fn one_minus_length(self, alpha: f64) -> f64 {
        let odds = self.odds(alpha);
        odds / (1.0 + odds)
    }

    /// Returns the length `L` of the mean normal, from 0 to 1.
    pub fn length(self, alpha: f64) -> f64 {
        1.0 / (1.0 + self.odds(alpha))
    }

    /// Returns the roughness `α`, from 1e-4 to 100, for a shortening of the mean normal. The function is the inverse of
    /// [`Self::one_minus_length`].
    pub fn alpha_of_shortening(self, shortening: f64) -> f64 {
        let wanted = odds_of_shortening(held_shortening(shortening)).ln();
        let (low, high) = (MIN_VARIANCE.ln(), 2.0 * MAX_SLOPE.ln());
        let square = increasing_root(low, high, |log| self.odds_of_square(log.exp()).ln() - wanted).exp();
        usable_alpha(square.sqrt())
    }

    /// Returns the roughness `α`, from 1e-4 to 100, for a mean normal length. The function is the inverse of [`Self::length`]. Near a
    /// length of 1 the precision is limited by the digits of `1 − length`.
    pub fn alpha_of_length(self, length: f64) -> f64 {
        self.alpha_of_shortening(1.0 - length)
    }

    /// Returns the combined `α` of facets of roughness `alpha` on top of facets of roughness `other`. Their mean normal lengths multiply
    /// (Chan eq. 34).
    ///
    /// The result is exact if the finer normals rotate with the coarser ones and either distribution is isotropic. The mean of the finer
    /// normals then lies along the coarser normal.
    pub fn combine(self, alpha: f64, other: f64) -> f64 {
        let [a, b] = [alpha, other].map(|alpha| self.one_minus_length(if alpha.is_nan() { MAX_SLOPE } else { alpha }));
        self.alpha_of_shortening(a + b - a * b)
    }

    /// Returns the gloss of facets of gloss `detail` on top of facets of gloss `base`, by [`Self::combine`]. [`chan_combine_gloss`] is the
    /// published fit to this function.
    pub fn combine_gloss(self, base: f64, detail: f64, gloss: Gloss) -> f64 {
        gloss.gloss(self.combine(gloss.alpha(base), gloss.alpha(detail)))
    }
}

/// The coefficients of Chan 2018, eq. 35 and 36, in the order of [`combined_gloss_quotient`].
pub const CHAN_COMBINED_GLOSS: [f64; 7] =
    [-0.535_580, 1.002_204, -0.223_910, 13.323_150, 8.259_559, 9.896_132, -22.015_902];

/// Returns the numerator and the denominator of a function of the form of Chan 2018, eq. 35 and 36, of two glosses `a` and `b`. The numerator
/// has four coefficients, of `1, a + b, a² + b², ab`. The denominator has three, because its constant is 1.
///
/// # Panics
/// With fewer than 7 coefficients.
pub fn combined_gloss_quotient(a: f64, b: f64, coefficients: &[f64]) -> [f64; 2] {
    let terms = [a + b, a * a + b * b, a * b];
    let sum = |c: &[f64]| terms.iter().zip(c).map(|(term, c)| term * c).sum::<f64>();
    [coefficients[0] + sum(&coefficients[1..4]), 1.0 + sum(&coefficients[4..7])]
}

/// Returns the published fit to [`Shortening::combine_gloss`] for GGX facets weighted by macrosurface area and [`Gloss::Wwii`] (Chan 2018, eq.
/// 35 to 37 and listing 2). Both glosses are clamped to 0..1, and NaN is treated as 0. The function is symmetric.
///
/// The fit differs from the product of the lengths by up to .0167 in gloss, .0049 RMS. The function serves comparisons with the paper, because
/// the product of the lengths is exact.
pub fn chan_combine_gloss(base: f64, detail: f64) -> f64 {
    let [above, below] = combined_gloss_quotient(unit(base), unit(detail), &CHAN_COMBINED_GLOSS);
    unit(above / below)
}

/// Returns the `α` of GGX facets for a shortening of their mean normal, weighted by macrosurface area. The function is a fit for shaders.
/// Its relative error is 1e-4 for `α` from .0027 to 1, the range of [`Gloss::Wwii`] from gloss 1 to 0. The shortening is clamped to
/// 4.08e-5..1/3, and NaN is treated as 4.08e-5.
pub fn ggx_alpha_of_shortening_fit(shortening: f64) -> f64 {
    let shortening = held(shortening, 4.08e-5, 1.0 / 3.0);
    let x = shortening.sqrt().sqrt();
    let p = 0.099_672_9 + x * (1.653_836_5 + x * (-0.339_655_5 - x * 0.712_937_3));
    let q = 1.0 + x * (4.549_649_7 + x * (-12.735_986_7 + x * 7.245_809_4));
    (shortening * p / q).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::beckmann::Beckmann;
    use crate::facets::ggx::Ggx;
    use crate::facets::slope_distribution::SlopeDistribution;
    use crate::quadrature::composite_gauss;
    use glam::{DVec2, DVec3};
    use std::f64::consts::{FRAC_PI_2, PI};

    /// Integrates `(1 − L, L)` from the slope density. For GGX, `x²` is the fraction of steeper slopes, with `tan² = A (1 − x²)/x²`.
    /// Beckmann facets have `tan² = A x²` with the density `2x exp(−x²)`. Panels are finer towards the ends of the range, where very smooth
    /// or very rough facets need more nodes.
    fn by_quadrature(shortening: Shortening, alpha: f64) -> (f64, f64) {
        let square = alpha * alpha;
        // Returns (1 − cos, cos, 1/cos − 1) for the tan² of an angle.
        let parts = |tan2: f64| {
            let root = (1.0 + tan2).sqrt();
            DVec3::new(tan2 / (root * (1.0 + root)), 1.0 / root, tan2 / (1.0 + root))
        };
        let edges: Vec<f64> = (0..=20).map(|i| 2f64.powi(i - 21)).collect();
        let panels = std::iter::once((0.0, edges[0])).chain(edges.windows(2).map(|w| (w[0], w[1])));
        let mut sum = DVec3::ZERO;
        // The distance y from the nearer end of the range is at most 1/2.
        for (y, w) in panels.flat_map(|(low, high)| composite_gauss(low, high, 1, 16)) {
            for (x, rest) in [(y, 1.0 - y), (1.0 - y, y)] {
                sum += match shortening.facets {
                    NormalFacets::Ggx => 2.0 * x * w * parts(square * rest * (1.0 + x) / (x * x)),
                    NormalFacets::Beckmann => 98.0 * x * w * (-49.0 * x * x).exp() * parts(square * 49.0 * x * x),
                };
            }
        }
        match shortening.area {
            NormalArea::Macro => (sum.x, sum.y),
            NormalArea::Micro => (sum.z / (1.0 + sum.z), 1.0 / (1.0 + sum.z)),
        }
    }

    #[test]
    fn closed_forms_are_the_integrals() {
        let mut worst = 0.0f64;
        for shortening in Shortening::ALL {
            for i in 0..=120 {
                let alpha = 10f64.powf(-4.0 + 0.05 * f64::from(i));
                let (one_minus_length, length) = by_quadrature(shortening, alpha);
                let errors = [
                    shortening.one_minus_length(alpha) / one_minus_length - 1.0,
                    shortening.length(alpha) / length - 1.0,
                ];
                worst = errors.into_iter().fold(worst, |w, e| w.max(e.abs()));
            }
        }
        println!("relative difference of closed forms and quadrature: {worst:.1e}");
        assert!(worst < 1e-11);
    }

    /// Evaluates eq. 12 and 18 as printed, over the hemisphere, with the normal densities of the modules `ggx` and `beckmann`.
    #[test]
    fn lengths_are_integrals_of_the_distribution() {
        for alpha in [0.2, 0.6, 1.0, 3.0] {
            let polar = |ndf: &dyn Fn(DVec3) -> f64, power: i32| -> f64 {
                let rule = composite_gauss(0.0, FRAC_PI_2, 60, 8);
                let term = |(t, w): (f64, f64)| {
                    2.0 * PI * w * t.sin() * t.cos().powi(power) * ndf(DVec3::new(t.sin(), 0.0, t.cos()))
                };
                rule.into_iter().map(term).sum()
            };
            let ggx = Ggx::isotropic(DVec2::ZERO, alpha);
            let beckmann = Beckmann::new(DVec2::ZERO, DVec3::new(1.0, 1.0, 0.0) * 0.5 * alpha * alpha);
            for shortening in Shortening::ALL {
                let ndf = |wn: DVec3| match shortening.facets {
                    NormalFacets::Ggx => ggx.ndf(wn),
                    NormalFacets::Beckmann => beckmann.ndf(wn),
                };
                let want = match shortening.area {
                    NormalArea::Macro => polar(&ndf, 2),
                    NormalArea::Micro => 1.0 / polar(&ndf, 0),
                };
                let error = shortening.length(alpha) / want - 1.0;
                assert!(error.abs() < 1e-7, "{shortening:?} {alpha}: {error:e}");
            }
        }
    }

    /// The series and the closed forms agree to the last digit where they meet. At `α = 1` the limits are 2/3 and 1/2.
    #[test]
    fn series_and_closed_forms_meet() {
        for edge in [1.0 - SERIES_END, 1.0 + SERIES_END] {
            for odds in [ggx_normal_odds_micro, ggx_normal_odds_macro] {
                let step = 1e-9;
                let [below, at, above] = [-1.0, 0.0, 1.0].map(|s| odds(edge + s * step));
                assert!((below - 2.0 * at + above).abs() < 2e-14, "{edge}");
            }
        }
        assert!((Shortening::ALL[0].length(1.0) - 2.0 / 3.0).abs() < 1e-15);
        assert!((Shortening::ALL[1].length(1.0) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn roughness_comes_back() {
        for shortening in Shortening::ALL {
            for i in 0..=600 {
                let alpha = 10f64.powf(-4.0 + 0.01 * f64::from(i));
                let found = shortening.alpha_of_shortening(shortening.one_minus_length(alpha));
                assert!((found / alpha - 1.0).abs() < 1e-12, "{shortening:?} {alpha}: {found}");
            }
            // Rounding a length loses the digits of 1 − L below about 2e-16.
            for alpha in [0.003, 0.1, 0.9, 1.0, 7.0] {
                let found = shortening.alpha_of_length(shortening.length(alpha));
                assert!((found / alpha - 1.0).abs() < 1e-15 / shortening.one_minus_length(alpha) + 1e-12);
            }
        }
    }

    #[test]
    fn any_length_has_a_roughness() {
        for shortening in Shortening::ALL {
            for (length, alpha) in [
                (f64::NAN, 100.0),
                (f64::NEG_INFINITY, 100.0),
                (-0.5, 100.0),
                (0.0, 100.0),
                (1.0, 1e-4),
                (1.5, 1e-4),
                (f64::INFINITY, 1e-4),
            ] {
                assert_eq!(shortening.alpha_of_length(length), alpha, "{shortening:?} {length}");
            }
            for alpha in [f64::NAN, -1.0, 0.0, 1e-300, 1e300, f64::INFINITY] {
                let (one_minus_length, length) = (shortening.one_minus_length(alpha), shortening.length(alpha));
                assert!(one_minus_length > 0.0 && length > 0.0 && (one_minus_length + length - 1.0).abs() < 1e-15);
                assert!(shortening.combine(alpha, alpha).is_finite());
            }
            assert_eq!(shortening.combine(0.5, f64::NAN), 100.0);
        }
    }

    /// Compares the lengths with Chan's Listing 8. Its sampled lengths are too long by up to 3.5e-6. Gloss 95/255 to 102/255 is illegible in
    /// the copy at hand.
    #[test]
    fn the_table_of_the_paper() {
        let entry = |line: &str| {
            let (gloss, length) = line.split_once(' ').unwrap();
            let [gloss, length]: [f64; 2] = [gloss, length].map(|text| text.parse().unwrap());
            // Printed glosses are 255ths rounded to six digits.
            let gloss = (255.0 * gloss).round() / 255.0;
            length - Shortening::default().length(Gloss::Wwii.alpha(gloss))
        };
        let errors: Vec<f64> = include_str!("chan_listing_8.txt").lines().map(entry).collect();
        assert_eq!(errors.len(), 248);
        let (least, largest) = errors.iter().fold((f64::MAX, f64::MIN), |(a, b), &e| (a.min(e), b.max(e)));
        let mean = errors.iter().sum::<f64>() / 248.0;
        println!("Listing 8 less eq. 26: least {least:.2e}, mean {mean:.2e}, largest {largest:.2e}");
        assert!(least > 5.4e-7 && largest < 3.5e-6 && (mean - 2.03e-6).abs() < 1e-8);
    }

    /// Compares Chan's fit of combined gloss with the product of the lengths.
    #[test]
    fn the_published_fit_of_combined_gloss() {
        let pairs = || (0..129 * 129).map(|i| [i % 129, i / 129].map(|k| f64::from(k) / 128.0));
        let exact = |[a, b]: [f64; 2]| Shortening::default().combine_gloss(a, b, Gloss::Wwii);
        let errors: Vec<f64> = pairs().map(|p| (chan_combine_gloss(p[0], p[1]) - exact(p)).abs()).collect();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        println!("eq. 35 to 37: largest error {worst:.4}, rms {rms:.4}");
        assert!((worst - 0.0167).abs() < 1e-4 && (rms - 0.0049).abs() < 1e-4);
        assert!(pairs().all(|[a, b]| chan_combine_gloss(a, b) == chan_combine_gloss(b, a)));
        assert_eq!(chan_combine_gloss(f64::NAN, 2.0), chan_combine_gloss(0.0, 1.0));
    }

    /// If the normals of one distribution are rotated by the normals of another, and all facets are equally likely, the lengths multiply.
    #[test]
    fn lengths_multiply() {
        let shortening = Shortening::default();
        // The normals are quantiles of GGX slopes and azimuths, on a grid that integrates low harmonics exactly.
        let normals = |alpha: f64| -> Vec<DVec3> {
            (0..60 * 12)
                .map(|i| {
                    let u = (f64::from(i / 12) + 0.5) / 60.0;
                    let slope = alpha * (u / (1.0 - u)).sqrt();
                    let (sin, cos) = (f64::from(i % 12) / 12.0 * 2.0 * PI).sin_cos();
                    DVec3::new(slope * cos, slope * sin, 1.0).normalize()
                })
                .collect()
        };
        let (a, b) = (normals(0.5), normals(0.3));
        let mean = |n: &[DVec3]| n.iter().sum::<DVec3>() / n.len() as f64;
        let rotated: DVec3 = a
            .iter()
            .flat_map(|base| b.iter().map(|n| glam::DQuat::from_rotation_arc(DVec3::Z, *base) * *n))
            .sum::<DVec3>()
            / (a.len() * b.len()) as f64;
        assert!((rotated.length() - mean(&a).length() * mean(&b).length()).abs() < 1e-12);
        let combined = shortening.combine(0.5, 0.3);
        assert!((shortening.length(combined) - shortening.length(0.5) * shortening.length(0.3)).abs() < 1e-14);
        assert!(combined > 0.5 && (shortening.combine(0.5, 1e-4) / 0.5 - 1.0).abs() < 1e-6);
    }

    /// Chan blends normals with BlendXY, but combines gloss as if the normals were rotated, because the results are "very similar". This
    /// test compares BlendXY, rotation and the sum of slopes over GGX quantiles.
    #[test]
    fn gloss_by_other_blends() {
        use crate::slopes::normal_blending::{blend_partial_derivatives, blend_reoriented, blend_xy};
        let shortening = Shortening::default();
        let normals = |gloss: f64, steps: u32| -> Vec<DVec2> {
            let alpha = Gloss::Wwii.alpha(gloss);
            let slope = |i: u32| {
                let u = (f64::from(i) + 0.5) / f64::from(steps);
                alpha * (u / (1.0 - u)).sqrt()
            };
            (0..steps).map(|i| DVec2::new(slope(i), 1.0) / slope(i).hypot(1.0)).collect()
        };
        let mut worst = [(0.0f64, 0.0, 0.0); 2];
        for i in 0..=8 {
            for j in 0..=8 {
                let (a, b) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                let mut means = [0.0; 3];
                for base in normals(a, 60) {
                    for detail in normals(b, 61) {
                        for k in 0..16 {
                            let (sin, cos) = ((f64::from(k) + 0.5) / 16.0 * PI).sin_cos();
                            let (base, detail) =
                                (DVec3::new(base.x, 0.0, base.y), DVec3::new(cos * detail.x, sin * detail.x, detail.y));
                            for (mean, blend) in
                                means.iter_mut().zip([blend_reoriented, blend_xy, blend_partial_derivatives])
                            {
                                *mean += blend(base, detail).z / (60.0 * 61.0 * 16.0);
                            }
                        }
                    }
                }
                let [rotated, xy, slopes] = means.map(|mean| Gloss::Wwii.gloss(shortening.alpha_of_length(mean)));
                for (worst, error) in worst.iter_mut().zip([(xy - rotated).abs(), (slopes - rotated).abs()]) {
                    if error > worst.0 {
                        *worst = (error, a, b);
                    }
                }
            }
        }
        println!("gloss by BlendXY and by sums of slopes against rotation: largest error {worst:.3?} (base, detail)");
        assert!(worst[0].0 > 0.005 && worst[0].0 < 0.08 && worst[1].0 < 0.08, "{worst:?}");
    }

    #[test]
    fn the_fit_for_shaders_is_near() {
        let shortening = Shortening::default();
        let alphas = (0..=1000).map(|i| 0.0027f64.powf(f64::from(i) / 1000.0));
        let errors =
            alphas.map(|alpha| (ggx_alpha_of_shortening_fit(shortening.one_minus_length(alpha)) / alpha - 1.0).abs());
        let worst = errors.fold(0.0, f64::max);
        println!("alpha from the fit: largest relative error {worst:.1e}");
        assert!(worst < 1e-4 && worst > 1e-6);
        for one_minus_length in [f64::NAN, -1.0, 0.0, 1.0, f64::INFINITY] {
            assert!((0.0026..1.001).contains(&ggx_alpha_of_shortening_fit(one_minus_length)));
        }
    }
}
