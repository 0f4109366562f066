//! Classifies images, so that normal and colour maps are not read as heights.

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ImageClass {
    /// The three channels are equal, up to codec noise.
    Grey,
    /// Most texels are unit vectors that point outwards.
    Normals,
    /// The image is neither grey nor a normal map.
    Colors,
}

const SAMPLES: usize = 1 << 16;
/// The largest difference between the channels of a grey texel, from 0 to 1.
const GREY: f32 = 12.0 / 255.0;
/// An image counts as coloured if more than this fraction of its texels is coloured.
const COLORED: f32 = 0.01;
/// The largest difference between the length of a normal and 1. The limit allows for 8-bit mip levels and JPEG.
const LENGTH: f32 = 0.15;
/// An image is a normal map if more than this fraction of its texels are unit vectors.
const UNIT: f32 = 0.95;

/// Classifies an image of `texels` texels with three channels. The channels of pictures are from 0 to 1.
pub(super) fn classify(texels: usize, texel: impl Fn(usize) -> [f32; 3]) -> ImageClass {
    // The step is odd, so that samples do not align with columns. The number of columns is usually a power of two.
    let step = (texels / SAMPLES) | 1;
    let (mut seen, mut colored, mut unit) = (0.0f32, 0.0, 0.0);
    for color in (0..texels).step_by(step).map(texel) {
        let [low, high] = [f32::min, f32::max].map(|pick| color.into_iter().reduce(pick).unwrap_or(0.0));
        let vector = color.map(|c| 2.0 * c - 1.0);
        let length = vector.iter().map(|v| v * v).sum::<f32>().sqrt();
        seen += 1.0;
        colored += f32::from(u8::from(high - low > GREY));
        unit += f32::from(u8::from((length - 1.0).abs() < LENGTH && vector[2] > 0.0));
    }
    match (colored >= COLORED * seen, unit >= UNIT * seen) {
        (false, _) => ImageClass::Grey,
        (true, true) => ImageClass::Normals,
        (true, false) => ImageClass::Colors,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_colours_and_greys_are_classified() {
        let of = |texel: fn(f32) -> [f32; 3]| classify(256 * 256, |i| texel((i * 97 % 1009) as f32 / 1009.0));
        let normal = |a: f32| {
            let (x, y) = (0.6 * (6.0 * a).sin(), 0.5 * (9.0 * a).cos());
            [x, y, (1.0 - x * x - y * y).sqrt()].map(|v| ((0.5 * v + 0.5) * 255.0).round() / 255.0)
        };
        assert_eq!(of(normal), ImageClass::Normals);
        // Flat normals are light blue, not grey.
        assert_eq!(of(|_| [0.5, 0.5, 1.0]), ImageClass::Normals);
        assert_eq!(of(|a| [a, a, a]), ImageClass::Grey);
        assert_eq!(of(|a| [a, a + 0.02, a - 0.02]), ImageClass::Grey);
        assert_eq!(of(|_| [0.789; 3]), ImageClass::Grey);
        // The colours are those of bricks and of the sky.
        assert_eq!(of(|a| [0.3 + 0.5 * a, 0.2 + 0.3 * a, 0.15]), ImageClass::Colors);
        assert_eq!(of(|a| [0.1 * a, 0.2 * a, 0.5 * a]), ImageClass::Colors);
    }
}
