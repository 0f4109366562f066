//! Encodes small PNG files of square pictures.

use image::ExtendedColorType::{self, L8, L16, Rgb8};
use image::ImageEncoder as _;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};

fn png(side: usize, bytes: &[u8], color: ExtendedColorType) -> Vec<u8> {
    let mut file = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Best, FilterType::Adaptive);
    encoder.write_image(bytes, side as u32, side as u32, color).expect("the texel count matches the size");
    file
}

/// Returns an 8-bit grey PNG of values from 0 to 1.
pub fn grey8(side: usize, values: impl Iterator<Item = f32>) -> Vec<u8> {
    png(side, &values.map(|v| (255.0 * v.clamp(0.0, 1.0) + 0.5) as u8).collect::<Vec<u8>>(), L8)
}

/// Returns a 16-bit grey PNG of values from 0 to 1.
pub fn grey16(side: usize, values: impl Iterator<Item = f32>) -> Vec<u8> {
    let codes = values.map(|v| (65535.0 * v.clamp(0.0, 1.0) + 0.5) as u16);
    png(side, &codes.flat_map(u16::to_ne_bytes).collect::<Vec<u8>>(), L16)
}

/// Returns an 8-bit RGB PNG.
pub fn rgb8(side: usize, texels: impl Iterator<Item = [u8; 3]>) -> Vec<u8> {
    png(side, &texels.flatten().collect::<Vec<u8>>(), Rgb8)
}
