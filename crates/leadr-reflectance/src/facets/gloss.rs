//! Gloss: texture values from 0 (rough) to 1 (smooth), and their GGX roughness `α`.
//!
//! Two families are in use. The exponential one spaces highlights evenly over the scale. With a curve `(c, r, o)`
//!
//! ```text
//! α² = 2 / (c + 2^(r g + o))
//! ```
//!
//! it is Chan's eq. 1 for `c = 2, r = 16, o = 0` (*Advanced Warfare*), and his eq. 2 for `c = 1, r = 18, o = 0` (*WWII*). For `c = 2` it
//! is the roughness of a Blinn-Phong exponent `n = 2^(r g + o)`, since `α² = 2 / (n + 2)` has the same curvature at the peak (Walter et
//! al. 2007). The perceptual one is `α = (1 − g)²` (Disney, Unreal, glTF).

use crate::limits::{MAX_SLOPE, MIN_VARIANCE, held, unit};
use glam::DVec3;

/// Curve of Chan's eq. 1: `α = √(2 / (2 + 2^(16 g)))`, from .816 to .0055.
pub const GLOSS_ADVANCED_WARFARE: DVec3 = DVec3::new(2.0, 16.0, 0.0);

/// Curve of Chan's eq. 2: `α = √(2 / (1 + 2^(18 g)))`, from 1 to .0028.
pub const GLOSS_WWII: DVec3 = DVec3::new(1.0, 18.0, 0.0);

/// Curve of the Blinn-Phong exponents `2^(10 g + 1)`, 2 to 2048: `α` from .707 to .031.
pub const GLOSS_BLINN_PHONG: DVec3 = DVec3::new(2.0, 10.0, 1.0);

/// The roughness clamped to the usable range, 1e-4 to 100; the smallest for NaN.
pub(super) fn usable_alpha(alpha: f64) -> f64 {
    held(alpha, MIN_VARIANCE.sqrt(), MAX_SLOPE)
}

/// `α = √(2 / (c + 2^(r g + o)))` for a curve `(c, r, o)`, 1e-4 to 100. Gloss is clamped to 0..1; NaN counts as 0.
pub fn gloss_alpha(gloss: f64, curve: DVec3) -> f64 {
    let power = (curve.y * unit(gloss) + curve.z).clamp(-60.0, 60.0).exp2();
    usable_alpha((2.0 / (curve.x + power).max(1e-9)).sqrt())
}

/// The inverse of [`gloss_alpha`], 0 to 1; roughness outside the curve's range gives the nearer end.
pub fn alpha_gloss(alpha: f64, curve: DVec3) -> f64 {
    if alpha.is_nan() {
        return 0.0;
    }
    let square = usable_alpha(alpha).powi(2);
    let power = ((2.0 - curve.x * square) / square).max(1e-30);
    unit((power.log2() - curve.z) / curve.y)
}

/// `α = (1 − g)²`, at least 1e-4 (Burley 2012, as roughness). Gloss is clamped to 0..1; NaN counts as 0.
pub fn perceptual_gloss_alpha(gloss: f64) -> f64 {
    usable_alpha((1.0 - unit(gloss)).powi(2))
}

/// The inverse of [`perceptual_gloss_alpha`], 0 to 1; 0 for `α ≥ 1` and NaN.
pub fn perceptual_alpha_gloss(alpha: f64) -> f64 {
    if alpha.is_nan() { 0.0 } else { unit(1.0 - usable_alpha(alpha).sqrt()) }
}

/// A gloss scale.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Gloss {
    /// [`GLOSS_ADVANCED_WARFARE`], Chan's eq. 1.
    AdvancedWarfare,
    /// [`GLOSS_WWII`], Chan's eq. 2.
    Wwii,
    /// One minus a perceptual roughness, whose square is `α`.
    #[default]
    Perceptual,
    /// One minus `α`.
    Linear,
    /// Blinn-Phong exponents `2^(range g + offset)`; 10 and 1 are [`GLOSS_BLINN_PHONG`].
    Exponent {
        /// Doublings of the exponent from gloss 0 to 1, not 0.
        range: f64,
        /// Base-2 logarithm of the exponent at gloss 0.
        offset: f64,
    },
}

impl Gloss {
    /// The curve of an exponential scale.
    fn curve(self) -> Option<DVec3> {
        match self {
            Self::AdvancedWarfare => Some(GLOSS_ADVANCED_WARFARE),
            Self::Wwii => Some(GLOSS_WWII),
            Self::Exponent { range, offset } => Some(DVec3::new(2.0, range, offset)),
            Self::Perceptual | Self::Linear => None,
        }
    }

    /// GGX roughness `α` of a gloss, 1e-4 to 100. Gloss is clamped to 0..1; NaN counts as 0.
    pub fn alpha(self, gloss: f64) -> f64 {
        match self.curve() {
            Some(curve) => gloss_alpha(gloss, curve),
            None if self == Self::Linear => usable_alpha(1.0 - unit(gloss)),
            None => perceptual_gloss_alpha(gloss),
        }
    }

    /// Gloss of a GGX roughness `α`, 0 to 1: the nearest if none is exact; 0 for NaN.
    pub fn gloss(self, alpha: f64) -> f64 {
        match self.curve() {
            Some(curve) => alpha_gloss(alpha, curve),
            None if self == Self::Linear => unit(1.0 - alpha),
            None => perceptual_alpha_gloss(alpha),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Gloss; 6] = [
        Gloss::AdvancedWarfare,
        Gloss::Wwii,
        Gloss::Perceptual,
        Gloss::Linear,
        Gloss::Exponent { range: 10.0, offset: 1.0 },
        Gloss::Exponent { range: 13.0, offset: 0.0 },
    ];

    #[test]
    fn the_ends_of_the_scales() {
        let ends = |gloss: Gloss| [gloss.alpha(0.0), gloss.alpha(1.0)];
        let near = |got: [f64; 2], want: [f64; 2]| got.iter().zip(want).all(|(g, w)| (g / w - 1.0).abs() < 1e-12);
        assert!(near(ends(Gloss::AdvancedWarfare), [(2.0f64 / 3.0).sqrt(), (2.0f64 / 65_538.0).sqrt()]));
        assert!(near(ends(Gloss::Wwii), [1.0, (2.0f64 / 262_145.0).sqrt()]));
        assert!(near(ends(Gloss::Perceptual), [1.0, 1e-4]));
        assert!(near(ends(ALL[4]), [0.5f64.sqrt(), (2.0f64 / 2050.0).sqrt()]));
        assert_eq!(Gloss::Perceptual.alpha(0.25), 0.5625);
    }

    #[test]
    fn gloss_comes_back() {
        for kind in ALL {
            for i in 0..=255 {
                let gloss = f64::from(i) / 255.0;
                let alpha = kind.alpha(gloss);
                // The last steps of the perceptual and the linear scale are below the smallest roughness.
                if alpha > 1e-4 {
                    assert!((kind.gloss(alpha) - gloss).abs() < 1e-12, "{kind:?} {gloss}");
                }
            }
        }
    }

    #[test]
    fn exponents_are_those_of_blinn_phong() {
        for gloss in [0.0, 0.3, 1.0] {
            // The exponent of Walter et al. 2007.
            let exponent = 2.0 / gloss_alpha(gloss, GLOSS_BLINN_PHONG).powi(2) - 2.0;
            assert!((exponent / (10.0 * gloss + 1.0).exp2() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn any_numbers_have_a_gloss_and_a_roughness() {
        let odd = [Gloss::Exponent { range: 0.0, offset: 0.0 }, Gloss::Exponent { range: f64::NAN, offset: 1e300 }];
        for kind in ALL.into_iter().chain(odd) {
            for x in [f64::NAN, f64::NEG_INFINITY, -1.0, 0.0, 1e-300, 0.5, 1.0, 2.0, 1e300, f64::INFINITY] {
                let (alpha, gloss) = (kind.alpha(x), kind.gloss(x));
                assert!((1e-4..=100.0).contains(&alpha) && (0.0..=1.0).contains(&gloss), "{kind:?} {x}");
            }
            assert_eq!(kind.alpha(f64::NAN), kind.alpha(0.0));
        }
        assert_eq!(Gloss::Wwii.gloss(f64::NAN), 0.0);
        assert_eq!(Gloss::AdvancedWarfare.gloss(1.0), 0.0);
    }
}
