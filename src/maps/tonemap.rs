//! From linear radiance to display codes, as pure functions.

use super::srgb::srgb_from_linear;
use super::{Rgb8Image, RgbImage};

/// Filmic curve, linear 0 to infinity onto 0 to 1: Narkowicz's rational fit (2015) of the ACES reference rendering,
/// per channel. Slope at 0 is 0.03/0.14; 0.18 maps to 0.267, 1 to 0.80; monotone. Negative values map to 0.
pub fn filmic(x: f32) -> f32 {
    // Beyond 1e4 the fraction equals its limit to 32 bits, and x² could overflow.
    let x = x.clamp(0.0, 1e4);
    (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
}

/// How linear radiance becomes display light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Tonemap {
    /// The [`filmic`] curve.
    #[default]
    Filmic,
    /// Clamped to 0..1.
    Clamp,
}

/// sRGB codes of one linear colour times `exposure` (a factor, not stops). A NaN channel makes the whole texel
/// magenta, so that it is seen and not hidden as black; infinity is white.
pub fn display_srgb8(color: [f32; 3], exposure: f32, tonemap: Tonemap) -> [u8; 3] {
    if color.iter().any(|v| v.is_nan()) {
        return [255, 0, 255];
    }
    color.map(|v| {
        let exposed = v * exposure;
        let display = match tonemap {
            Tonemap::Filmic => filmic(exposed),
            Tonemap::Clamp => exposed,
        };
        (srgb_from_linear(display) * 255.0).round() as u8
    })
}

/// [`display_srgb8`] over an image.
pub fn display_image(image: &RgbImage, exposure: f32, tonemap: Tonemap) -> Rgb8Image {
    let texels = image.texels.iter().map(|&t| display_srgb8(t, exposure, tonemap)).collect();
    Rgb8Image { width: image.width, height: image.height, texels }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filmic_rises_from_zero_to_one() {
        assert_eq!(filmic(0.0), 0.0);
        assert_eq!(filmic(-3.0), 0.0);
        let mut last = 0.0;
        for i in 1..2000 {
            let y = filmic(i as f32 * 0.01);
            assert!(y >= last && y <= 1.0, "falls at {i}");
            last = y;
        }
        assert!((filmic(0.18) - 0.267).abs() < 2e-3, "{}", filmic(0.18));
        assert!((filmic(1.0) - 0.804).abs() < 2e-3, "{}", filmic(1.0));
        assert_eq!(filmic(f32::INFINITY), 1.0);
    }

    #[test]
    fn nan_is_magenta_and_infinity_is_white() {
        assert_eq!(display_srgb8([0.0, f32::NAN, 0.0], 1.0, Tonemap::Filmic), [255, 0, 255]);
        assert_eq!(display_srgb8([f32::INFINITY; 3], 1.0, Tonemap::Filmic), [255; 3]);
        assert_eq!(display_srgb8([f32::INFINITY; 3], 1.0, Tonemap::Clamp), [255; 3]);
        assert_eq!(display_srgb8([0.5; 3], 0.0, Tonemap::Filmic), [0; 3]);
    }
}
