//! What a picture looks like, so that normals and colours are not taken for heights.

/// What three channels look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Looks {
    /// All the same, but for noise of a codec.
    Grey,
    /// Unit vectors, most of which point out of the surface.
    Normals,
    /// Anything else.
    Colors,
}

/// Texels that are looked at.
const SAMPLES: usize = 1 << 16;
/// Largest difference between channels of a grey texel, of 1.
const GREY: f32 = 12.0 / 255.0;
/// Share of texels that must differ for a picture to have colours.
const COLORED: f32 = 0.01;
/// Largest error of a normal's length: of 8 bits in a mip level, or of JPEG.
const LENGTH: f32 = 0.15;
/// Share of texels that must be normals.
const UNIT: f32 = 0.95;

/// Judges `texels` of three channels, 0 to 1 in pictures.
pub(super) fn looks(texels: usize, texel: impl Fn(usize) -> [f32; 3]) -> Looks {
    // Odd, so that it does not run along the columns of textures, whose widths are powers of two.
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
        (false, _) => Looks::Grey,
        (true, true) => Looks::Normals,
        (true, false) => Looks::Colors,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_colours_and_greys_are_told_apart() {
        let of = |texel: fn(f32) -> [f32; 3]| looks(256 * 256, |i| texel((i * 97 % 1009) as f32 / 1009.0));
        let normal = |a: f32| {
            let (x, y) = (0.6 * (6.0 * a).sin(), 0.5 * (9.0 * a).cos());
            [x, y, (1.0 - x * x - y * y).sqrt()].map(|v| ((0.5 * v + 0.5) * 255.0).round() / 255.0)
        };
        assert_eq!(of(normal), Looks::Normals);
        // Flat ones have colours, too: light blue.
        assert_eq!(of(|_| [0.5, 0.5, 1.0]), Looks::Normals);
        assert_eq!(of(|a| [a, a, a]), Looks::Grey);
        assert_eq!(of(|a| [a, a + 0.02, a - 0.02]), Looks::Grey);
        assert_eq!(of(|_| [0.789; 3]), Looks::Grey);
        // Bricks, and a sky.
        assert_eq!(of(|a| [0.3 + 0.5 * a, 0.2 + 0.3 * a, 0.15]), Looks::Colors);
        assert_eq!(of(|a| [0.1 * a, 0.2 * a, 0.5 * a]), Looks::Colors);
    }
}
