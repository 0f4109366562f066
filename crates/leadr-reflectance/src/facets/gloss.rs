//! Conversions between gloss, a texture value from 0 (rough) to 1 (smooth), and GGX roughness `α`.
//!
//! Two families of scales are in use. The exponential family spaces highlights evenly over the scale. For a curve `(c, r, o)`, the
//! roughness follows from
//!
//! ```text
//! α² = 2 / (c + 2^(r g + o))
//! ```
//!
//! This formula is Chan's eq. 1 for `c = 2, r = 16, o = 0` (*Advanced Warfare*), and Chan's eq. 2 for `c = 1, r = 18, o = 0` (*WWII*). For
//! `c = 2` the result is the roughness of a Blinn-Phong exponent `n = 2^(r g + o)`, since `α² = 2 / (n + 2)` has the same curvature at the
//! peak (Walter et al. 2007). The perceptual family is `α = (1 − g)²` (Disney, Unreal, glTF).

use crate::limits::{MAX_SLOPE, MIN_VARIANCE, held, unit};
use glam::DVec3;

/// The curve of Chan's eq. 1, `α = √(2 / (2 + 2^(16 g)))`, with `α` from .816 to .0055.
pub const GLOSS_ADVANCED_WARFARE: DVec3 = DVec3::new(2.0, 16.0, 0.0);

/// The curve of Chan's eq. 2, `α = √(2 / (1 + 2^(18 g)))`, with `α` from 1 to .0028.
pub const GLOSS_WWII: DVec3 = DVec3::new(1.0, 18.0, 0.0);

/// The curve of the Blinn-Phong exponents `2^(10 g + 1)`, 2 to 2048, with `α` from .707 to .031.
pub const GLOSS_BLINN_PHONG: DVec3 = DVec3::new(2.0, 10.0, 1.0);

/// Clamps a roughness to the usable range, from 1e-4 to 100. NaN gives 1e-4.
pub(super) fn usable_alpha(alpha: f64) -> f64 {
    held(alpha, MIN_VARIANCE.sqrt(), MAX_SLOPE)
}

/// Returns `α = √(2 / (c + 2^(r g + o)))` for a curve `(c, r, o)`, clamped to 1e-4..100. Gloss is clamped to 0..1, and NaN counts as 0.
pub fn gloss_alpha(gloss: f64, curve: DVec3) -> f64 {
    let power = (curve.y * unit(gloss) + curve.z).clamp(-60.0, 60.0).exp2();
    usable_alpha((2.0 / (curve.x + power).max(1e-9)).sqrt())
}

/// Returns the gloss of a roughness, from 0 to 1. This function is the inverse of [`gloss_alpha`]. A roughness outside the range of the
/// curve gives the nearer end, 0 or 1.
pub fn alpha_gloss(alpha: f64, curve: DVec3) -> f64 {
    if alpha.is_nan() {
        return 0.0;
    }
    let square = usable_alpha(alpha).powi(2);
    let power = ((2.0 - curve.x * square) / square).max(1e-30);
    unit((power.log2() - curve.z) / curve.y)
}

/// Returns `α = (1 − g)²`, at least 1e-4 (Burley 2012, who uses roughness `1 − g`). Gloss is clamped to 0..1, and NaN counts as 0.
pub fn perceptual_gloss_alpha(gloss: f64) -> f64 {
    usable_alpha((1.0 - unit(gloss)).powi(2))
}

/// Computes the inverse of [`perceptual_gloss_alpha`], a gloss from 0 to 1. The result is 0 for `α ≥ 1` and for NaN.
pub fn perceptual_alpha_gloss(alpha: f64) -> f64 {
    if alpha.is_nan() { 0.0 } else { unit(1.0 - usable_alpha(alpha).sqrt()) }
}

/// A scale that relates gloss to roughness.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Gloss {
    /// The scale of the curve [`GLOSS_ADVANCED_WARFARE`] (Chan's eq. 1).
    AdvancedWarfare,
    /// The scale of the curve [`GLOSS_WWII`] (Chan's eq. 2).
    Wwii,
    /// The gloss is one minus the perceptual roughness `√α`.
    #[default]
    Perceptual,
    /// The gloss is one minus the roughness `α`.
    Linear,
    /// The gloss `g` gives the Blinn-Phong exponent `2^(range g + offset)`. A range of 10 and an offset of 1 give [`GLOSS_BLINN_PHONG`].
    Exponent {
        /// The number of times that the exponent doubles from gloss 0 to gloss 1. It must not be zero.
        range: f64,
        /// The base-2 logarithm of the exponent at gloss 0.
        offset: f64,
    },
}

impl Gloss {
    /// Returns the curve of an exponential scale, or `None` for other scales.
    fn curve(self) -> Option<DVec3> {
        match self {
            Self::AdvancedWarfare => Some(GLOSS_ADVANCED_WARFARE),
            Self::Wwii => Some(GLOSS_WWII),
            Self::Exponent { range, offset } => Some(DVec3::new(2.0, range, offset)),
            Self::Perceptual | Self::Linear => None,
        }
    }

    /// Returns the GGX roughness `α` of a gloss, from 1e-4 to 100. Gloss is clamped to 0..1, and NaN counts as 0.
    pub fn alpha(self, gloss: f64) -> f64 {
        match self.curve() {
            Some(curve) => gloss_alpha(gloss, curve),
            None if self == Self::Linear => usable_alpha(1.0 - unit(gloss)),
            None => perceptual_gloss_alpha(gloss),
        }
    }

    /// Returns the gloss of a GGX roughness `α`, from 0 to 1. If no gloss is exact, the result is the nearest one. NaN gives 0.
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
                // The highest gloss values of the perceptual and the linear scale are below the smallest roughness.
                if alpha > 1e-4 {
                    assert!((kind.gloss(alpha) - gloss).abs() < 1e-12, "{kind:?} {gloss}");
                }
            }
        }
    }

    #[test]
    fn exponents_are_those_of_blinn_phong() {
        for gloss in [0.0, 0.3, 1.0] {
            // Walter et al. 2007 relate the exponent to the roughness in this way.
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
