//! Tonemapping of linear radiance to display codes, as pure functions.

use super::srgb::srgb_from_linear;
use super::{Rgb8Image, RgbImage};

/// Maps linear 0..∞ to 0..1 per channel by a filmic curve, Narkowicz's rational fit (2015) of the ACES reference rendering.
/// The curve is monotone and has slope 0.03/0.14 at 0. The curve maps 0.18 to 0.267, 1 to 0.80, and negative values to 0.
pub fn filmic(x: f32) -> f32 {
    // Above 1e4 the 32-bit fraction equals its limit, and a much larger x² would overflow.
    let x = x.clamp(0.0, 1e4);
    (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
}

/// A tonemapping operator, with the number that the shader uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
#[repr(i32)]
pub enum Tonemap {
    /// Clamps values to 0..1.
    Clamp = 0,
    /// The [`filmic`] curve per channel, which image comparisons use.
    #[default]
    Filmic = 1,
    /// The [`aces`] operator.
    Aces = 2,
    /// The [`agx`] operator.
    Agx = 3,
}

impl Tonemap {
    /// The default operator for display.
    pub const SHOWN: Self = Self::Agx;

    /// All operators.
    pub const ALL: [Self; 4] = [Self::Agx, Self::Aces, Self::Filmic, Self::Clamp];

    /// Returns the name that the command line uses.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clamp => "clamp",
            Self::Filmic => "filmic",
            Self::Aces => "aces",
            Self::Agx => "agx",
        }
    }

    /// Returns one line of help text.
    pub fn help(self) -> &'static str {
        match self {
            Self::Clamp => "Linear, clipped at white",
            Self::Filmic => "Narkowicz's fit of ACES, per channel",
            Self::Aces => "Hill's fit of the ACES reference rendering in wide primaries; bright colours desaturate",
            Self::Agx => "Sobotka's AgX with its punchy look; bright colours desaturate without hue shifts",
        }
    }

    /// Converts linear radiance after exposure to linear display values from 0 to 1.
    pub fn display(self, color: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Clamp => color.map(|v| v.clamp(0.0, 1.0)),
            Self::Filmic => color.map(filmic),
            Self::Aces => aces(color),
            Self::Agx => agx(color),
        }
    }
}

fn times(rows: [[f32; 3]; 3], color: [f32; 3]) -> [f32; 3] {
    rows.map(|row| row[0] * color[0] + row[1] * color[1] + row[2] * color[2])
}

/// Applies Stephen Hill's fit of the ACES reference rendering and its sRGB output transform. The curve is applied in wide
/// primaries, so bright saturated colours desaturate instead of clipping per channel. The exposure matches [`filmic`], so
/// 0.18 maps to about the same grey.
pub fn aces(color: [f32; 3]) -> [f32; 3] {
    const INTO: [[f32; 3]; 3] = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    const OUT: [[f32; 3]; 3] =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let curve = |v: f32| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    let wide = times(INTO, color.map(|v| ACES_EXPOSURE * v.clamp(0.0, 1e4)));
    times(OUT, wide.map(curve)).map(|v| v.clamp(0.0, 1.0))
}

/// The exposure at which [`aces`] is as bright as [`filmic`] at 0.18.
const ACES_EXPOSURE: f32 = 2.01;

/// Applies Troy Sobotka's AgX with the "punchy" look, in Benjamin Wrensch's polynomial form. A logarithmic curve covers 16.5
/// stops. Primaries are compressed before the curve and expanded after it.
pub fn agx(color: [f32; 3]) -> [f32; 3] {
    const INTO: [[f32; 3]; 3] = [
        [0.842_479_06, 0.078_433_6, 0.079_223_745],
        [0.042_328_242, 0.878_468_64, 0.079_166_13],
        [0.042_375_655, 0.078_433_6, 0.879_143],
    ];
    const OUT: [[f32; 3]; 3] = [
        [1.196_879, -0.098_020_88, -0.099_029_74],
        [-0.052_896_85, 1.151_903_1, -0.098_961_18],
        [-0.052_971_64, -0.098_043_45, 1.151_073_7],
    ];
    const STOPS: (f32, f32) = (-12.473_93, 4.026_069);
    let curve = |v: f32| {
        let x = ((v.clamp(1e-10, 1e10).log2() - STOPS.0) / (STOPS.1 - STOPS.0)).clamp(0.0, 1.0);
        [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.002_32].into_iter().fold(0.0, |sum, k| sum * x + k)
    };
    let even = times(INTO, color.map(|v| AGX_EXPOSURE * v.clamp(0.0, 1e4))).map(curve);
    let strong = even.map(|v| v.max(0.0).powf(AGX_POWER));
    let grey = 0.2126 * strong[0] + 0.7152 * strong[1] + 0.0722 * strong[2];
    let vivid = strong.map(|v| grey + AGX_SATURATION * (v - grey));
    // The result is encoded for a display gamma of 2.2 and must be decoded.
    times(OUT, vivid).map(|v| v.clamp(0.0, 1.0).powf(2.2))
}

const AGX_POWER: f32 = 1.35;
const AGX_SATURATION: f32 = 1.4;
/// The exposure at which [`agx`] is as bright as [`filmic`] at 0.18.
const AGX_EXPOSURE: f32 = 2.24;

/// Returns the sRGB codes of a linear colour multiplied by `exposure`, which is not in stops. A colour with a NaN channel
/// becomes magenta, which makes it visible. Infinity becomes white.
pub fn display_srgb8(color: [f32; 3], exposure: f32, tonemap: Tonemap) -> [u8; 3] {
    rounded_srgb8(color, exposure, tonemap, [0.0; 3])
}

/// Like [`display_srgb8`] for the pixel at column `pixel[0]` and row `pixel[1]`, with [`dither`] before rounding. A smooth
/// gradient then shows no bands, because the mean of neighbouring codes follows the gradient.
pub fn dithered_srgb8(color: [f32; 3], exposure: f32, tonemap: Tonemap, pixel: [u32; 2]) -> [u8; 3] {
    rounded_srgb8(color, exposure, tonemap, dither(pixel))
}

fn rounded_srgb8(color: [f32; 3], exposure: f32, tonemap: Tonemap, offsets: [f32; 3]) -> [u8; 3] {
    if color.iter().any(|v| v.is_nan()) {
        return [255, 0, 255];
    }
    let shown = tonemap.display(color.map(|v| v * exposure));
    std::array::from_fn(|i| (srgb_from_linear(shown[i]) * 255.0 + offsets[i]).round() as u8)
}

/// Returns the offsets, from −0.5 to 0.5 codes, that are added to the red, green and blue code of a pixel before rounding. They
/// follow the two-dimensional low-discrepancy sequence of Roberts (2018), so their error has only high spatial frequencies. The
/// offsets of the channels differ by thirds of a code, which keeps the error of the luminance small.
pub fn dither([x, y]: [u32; 2]) -> [f32; 3] {
    // The steps are fractions of 2³², so that the sum wraps exactly. `passes/tonemap.glsl` has the same steps.
    let first = x.wrapping_mul(0xc13f_a9a9).wrapping_add(y.wrapping_mul(0x91e1_0da5));
    [0, 0x5555_5555, 0xaaaa_aaaa].map(|shift| (first.wrapping_add(shift) >> 8) as f32 / 16_777_216.0 - 0.5)
}

/// Applies [`display_srgb8`] to every texel of an image.
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
    #[test]
    fn every_curve_rises_from_black_to_white_and_keeps_grey_grey() {
        for tonemap in Tonemap::ALL {
            let mut last = -1.0;
            for step in 0..400 {
                let v = (f64::from(step) / 400.0 * 22.0 - 14.0).exp2() as f32;
                let [r, g, b] = tonemap.display([v; 3]);
                assert!((r - g).abs() < 4e-3 && (b - g).abs() < 4e-3, "{tonemap:?} {v}: {r} {g} {b}");
                assert!(g >= last - 2e-4 && (0.0..=1.0).contains(&g), "{tonemap:?} falls at {v}");
                last = g;
            }
            assert!(last > 0.97, "{tonemap:?}: {last}");
            assert!(tonemap.display([0.0; 3]).iter().all(|v| *v < 2e-3), "{tonemap:?}");
            assert!(tonemap.display([f32::INFINITY; 3]).iter().all(|v| *v > 0.97), "{tonemap:?}");
        }
    }

    #[test]
    fn middle_grey_is_as_bright_under_every_filmic_curve() {
        let grey = filmic(0.18);
        for tonemap in [Tonemap::Aces, Tonemap::Agx] {
            let [_, g, _] = tonemap.display([0.18; 3]);
            assert!((g / grey - 1.0).abs() < 0.03, "{tonemap:?}: {g} of {grey}");
        }
    }

    #[test]
    fn dithered_gradients_have_no_bands_and_keep_their_means() {
        // A gradient of two codes over 512 rows: without dithering, 256 rows have one code.
        let value = |row: u32| (100.2 + 2.0 * row as f32 / 512.0) / 255.0;
        let linear = |code: f32| ((code + 0.055) / 1.055f32).powf(2.4);
        let code = |x: u32, row: u32, dithered: bool| -> [u8; 3] {
            let color = [linear(value(row)); 3];
            let show = |pixel| dithered_srgb8(color, 1.0, Tonemap::Clamp, pixel);
            if dithered { show([x, row]) } else { display_srgb8(color, 1.0, Tonemap::Clamp) }
        };
        let worst = |dithered: bool| {
            let block = |bx: u32, by: u32, channel: usize| {
                let pixels = (0..8).flat_map(|y| (0..8).map(move |x| (8 * bx + x, 8 * by + y)));
                let error = |(x, y)| f32::from(code(x, y, dithered)[channel]) - 255.0 * value(y);
                (pixels.map(error).sum::<f32>() / 64.0).abs()
            };
            let blocks = (0..64).flat_map(|y| (0..8).map(move |x| (x, y)));
            blocks.flat_map(|(x, y)| [0, 1, 2].map(|c| block(x, y, c))).fold(0.0, f32::max)
        };
        assert!(worst(true) < 0.06 && worst(false) > 0.4, "{} {}", worst(true), worst(false));
        // Exact codes stay as they are, so flat areas stay flat.
        for code in 0..=255u8 {
            let color = [linear(f32::from(code) / 255.0); 3];
            let color = if code > 10 { color } else { [f32::from(code) / 255.0 / 12.92; 3] };
            let shown = (0..4096).map(|i| dithered_srgb8(color, 1.0, Tonemap::Clamp, [i % 64, i / 64]));
            let others = shown.filter(|shown| *shown != [code; 3]).count();
            assert!(others < 8, "{code}: {others}");
        }
    }

    #[test]
    fn bright_colours_pale() {
        let saturation = |[r, g, b]: [f32; 3]| r.max(g).max(b) - r.min(g).min(b);
        let bright = [40.0, 8.0, 1.0];
        for tonemap in [Tonemap::Aces, Tonemap::Agx] {
            let shown = tonemap.display(bright);
            assert!(
                saturation(shown) < 0.5 * saturation(tonemap.display([0.4, 0.08, 0.01])) + 0.2,
                "{tonemap:?} {shown:?}"
            );
        }
    }
}
