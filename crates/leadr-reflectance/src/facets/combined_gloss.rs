//! Gloss of facets that stand on other facets, as a detail map does on its base: the ways of Chan (2018, section 2.4) and what they err by.
//!
//! Lengths of mean normals multiply, and [`Shortening::combine_gloss`] is that in closed form: it bakes maps and is the truth here. Shaders that
//! know gloss alone have three ways, by error in gloss for GGX facets by macrosurface area and [`Gloss::Wwii`]:
//!
//! * [`combine_gloss_short`], 3e-5: the product itself, with a fit of one variable for the way back. One logarithm each for the two lengths and
//!   for the gloss; none of the latter where `α` is wanted anyway. **Use this one**, and the closed form where time does not matter.
//! * [`CombinedGloss`], 32 × 32 texels, .009 in 8 bits: a texture of 1 KiB. One lookup, and any gloss or facets. It errs along the edge beyond which the
//!   sum is rougher than gloss can tell, where it is linear across a kink.
//! * Fits of the table ([`CombinedGloss::fit`], [`combine_gloss_fit`]): neither lookup nor logarithm. Nothing of the printed degree errs less than .017 at
//!   most, of degrees 3 and 3 less than .012: at gloss 1 beside 0 and along that edge.

use super::gloss::Gloss;
use super::shortened_normals::{Shortening, ggx_alpha_of_lack_fit};
use crate::limits::held;
use crate::rational_fit::{Norm, Rational, RationalFault, RationalForm, RationalSample, fit_rational};
use glam::DVec2;

/// A table of the gloss of a detail on a base.
#[derive(Clone, Debug, PartialEq)]
pub struct CombinedGloss {
    size: usize,
    texels: Vec<f64>,
}

impl CombinedGloss {
    /// Texels in a row of the paper's table.
    pub const PAPER_SIZE: usize = 32;

    /// Of `size²` texels, at least 2²: texel `(x, y)` is of gloss `x / (size − 1)` and `y / (size − 1)`, so the ends are met.
    #[must_use]
    pub fn new(shortening: Shortening, gloss: Gloss, size: usize) -> Self {
        let size = size.max(2);
        let at = |k: usize| k as f64 / (size - 1) as f64;
        let texels = (0..size * size).map(|i| shortening.combine_gloss(at(i % size), at(i / size), gloss)).collect();
        Self { size, texels }
    }

    /// The same in the 8 bits of a texture.
    #[must_use]
    pub fn in_8_bits(&self) -> Self {
        Self { size: self.size, texels: self.texels.iter().map(|t| (t * 255.0).round() / 255.0).collect() }
    }

    /// Texels, row by row.
    #[must_use]
    pub fn texels(&self) -> &[f64] {
        &self.texels
    }

    /// What a bilinear filter reads. Gloss outside 0..1 is held there; a NaN is 0.
    #[must_use]
    pub fn at(&self, base: f64, detail: f64) -> f64 {
        let [(x, tx), (y, ty)] = [base, detail].map(|gloss| {
            let place = held(gloss, 0.0, 1.0) * (self.size - 1) as f64;
            let texel = (place as usize).min(self.size - 2);
            (texel, place - texel as f64)
        });
        let row = |y: usize| {
            let [a, b] = [0, 1].map(|k| self.texels[x + k + self.size * y]);
            a + (b - a) * tx
        };
        row(y) + (row(y + 1) - row(y)) * ty
    }

    /// A rational function of the table, to be clamped to 0..1. Texels whose sum is rougher than gloss can tell weigh nothing: below 0 it may go as it likes.
    ///
    /// # Errors
    /// As [`fit_rational`].
    pub fn fit(&self, form: &RationalForm, norm: Norm) -> Result<Rational, RationalFault> {
        let samples = self.texels.iter().enumerate().map(|(i, &value)| {
            let at = DVec2::new((i % self.size) as f64, (i / self.size) as f64) / (self.size - 1) as f64;
            RationalSample { at, value, weight: if value > 0.0 { 1.0 } else { 0.0 } }
        });
        fit_rational(form, &samples.collect::<Vec<_>>(), &[], norm)
    }
}

/// The product of lengths of GGX facets by macrosurface area, with [`ggx_alpha_of_lack_fit`] for the way back. A sum rougher than `α = 1` counts as that.
#[must_use]
pub fn combine_gloss_short(base: f64, detail: f64, gloss: Gloss) -> f64 {
    let [a, b] = [base, detail].map(|g| Shortening::default().lack(gloss.alpha(g)));
    gloss.gloss(ggx_alpha_of_lack_fit(a + b - a * b))
}

/// Chan's fit of the combined gloss of GGX facets by macrosurface area, for [`Gloss::Wwii`] (eq. 35–37): up to .017 off.
#[must_use]
pub fn combine_gloss_fit(a: f64, b: f64) -> f64 {
    let [a, b] = [a, b].map(|x| held(x, 0.0, 1.0));
    let (sum, squares, product) = (a + b, a * a + b * b, a * b);
    let p = -0.535_580 + 1.002_204 * sum - 0.223_910 * squares + 13.323_150 * product;
    let q = 1.0 + 8.259_559 * sum + 9.896_132 * squares - 22.015_902 * product;
    (p / q).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest error and the root mean square over 129 × 129 pairs.
    fn errors(f: impl Fn(f64, f64) -> f64) -> (f64, f64) {
        let at = |k: u32| f64::from(k) / 128.0;
        let pairs = (0..129 * 129).map(|i| (at(i % 129), at(i / 129)));
        let errors = pairs.map(|(a, b)| (f(a, b) - Shortening::default().combine_gloss(a, b, Gloss::Wwii)).abs());
        let (most, squares) = errors.fold((0.0f64, 0.0), |(most, sum), e| (most.max(e), sum + e * e));
        (most, (squares / 129.0 / 129.0).sqrt())
    }

    #[test]
    fn every_way_is_as_near_as_it_says() {
        let table = CombinedGloss::new(Shortening::default(), Gloss::Wwii, CombinedGloss::PAPER_SIZE);
        let eight = table.in_8_bits();
        let fit = |degree: i32, norm| {
            let f = table.fit(&RationalForm::symmetric(degree, degree), norm).unwrap();
            errors(move |a, b| f.eval(DVec2::new(a, b)).clamp(0.0, 1.0))
        };
        for (name, (most, rms), range) in [
            ("product, short way back", errors(|a, b| combine_gloss_short(a, b, Gloss::Wwii)), 1e-6..4e-5),
            ("table of 32 x 32", errors(|a, b| table.at(a, b)), 1e-3..0.01),
            ("table of 32 x 32, 8 bits", errors(|a, b| eight.at(a, b)), 1e-3..0.012),
            ("eq. 35-37", errors(combine_gloss_fit), 0.005..0.02),
            ("degrees 2, 2", fit(2, Norm::Largest), 0.01..0.02),
            ("degrees 3, 3", fit(3, Norm::Largest), 0.005..0.02),
        ] {
            println!("{name}: off by {most:.6} at most, rms {rms:.6}");
            assert!(range.contains(&most), "{name}: {most}");
        }
    }

    #[test]
    fn tables_meet_their_texels_and_are_symmetric() {
        let shortening = Shortening::default();
        let table = CombinedGloss::new(shortening, Gloss::Perceptual, 9);
        for (a, b) in [(0.0, 0.0), (0.125, 0.75), (1.0, 0.5), (1.0, 1.0)] {
            assert!((table.at(a, b) - shortening.combine_gloss(a, b, Gloss::Perceptual)).abs() < 1e-12);
        }
        for (a, b) in [(0.3, 0.61), (0.99, 0.01)] {
            assert!((table.at(a, b) - table.at(b, a)).abs() < 1e-12);
        }
        assert_eq!(CombinedGloss::new(shortening, Gloss::Wwii, 0).texels().len(), 4);
    }

    #[test]
    fn finite_for_anything() {
        let table = CombinedGloss::new(Shortening::default(), Gloss::Wwii, 8);
        for x in [f64::NAN, -1.0, 2.0, f64::INFINITY] {
            for y in [f64::NAN, 0.5] {
                let all = [table.at(x, y), combine_gloss_fit(x, y), combine_gloss_short(x, y, Gloss::Wwii)];
                assert!(all.iter().all(|g| (0.0..=1.0).contains(g)), "{x} {y}: {all:?}");
            }
        }
    }
}
