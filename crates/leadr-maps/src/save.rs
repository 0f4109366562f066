//! Saves pictures as PNG and EXR with deterministic bytes.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    SmallVec, Text, Vec2, WritableImage,
};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::fault::one_line;
use super::new_file::write_atomic;
use super::origin::Origin;
use super::shown::shown;
use super::tonemap::{Tonemap, display_image};
use super::{HeightMap, MapError, MapFault, Rgb8Image, RgbImage};

/// Saves 8-bit sRGB codes as PNG.
pub fn save_png_srgb8(path: impl AsRef<Path>, image: &Rgb8Image) -> Result<(), MapError> {
    let bytes = encode_png_srgb8(image).map_err(|f| f.in_file(&path))?;
    write_atomic(path, &bytes)
}

/// Saves linear radiance as an 8-bit sRGB PNG. The radiance is multiplied by `exposure` and converted by `tonemap`. NaN
/// texels become magenta ([`super::tonemap::display_srgb8`]).
pub fn save_png(path: impl AsRef<Path>, image: &RgbImage, exposure: f32, tonemap: Tonemap) -> Result<(), MapError> {
    save_png_srgb8(path, &display_image(image, exposure, tonemap))
}

/// Saves heights as a 16-bit grey PNG. `low` becomes 0, `high` becomes 65535, and values outside are clamped. If `low == high`,
/// all texels are 0.
pub fn save_png_grey16(path: impl AsRef<Path>, map: &HeightMap, low: f32, high: f32) -> Result<(), MapError> {
    let bytes = encode_png_grey16(map, low, high).map_err(|f| f.in_file(&path))?;
    write_atomic(path, &bytes)
}

/// An EXR channel: a name such as `R`, `depth` or `color.R`, and `width * height` values.
pub type Channel<'a> = (&'a str, &'a [f32]);

/// Saves 32-bit float channels as an EXR (ZIP, scanlines). NaN and infinities are kept. Fails if there are no channels, if a
/// name is empty or duplicate, if a length is wrong, or if the file cannot be written.
pub fn save_exr(path: impl AsRef<Path>, width: u32, height: u32, channels: &[Channel<'_>]) -> Result<(), MapError> {
    let bytes = encode_exr(width, height, channels).map_err(|f| f.in_file(&path))?;
    write_atomic(path, &bytes)
}

/// Saves linear radiance as an EXR with channels `R`, `G`, `B`.
pub fn save_exr_rgb(path: impl AsRef<Path>, image: &RgbImage) -> Result<(), MapError> {
    let [r, g, b] = [0, 1, 2].map(|c| image.texels.iter().map(|t| t[c]).collect::<Vec<f32>>());
    save_exr(path, image.width, image.height, &[("R", &r), ("G", &g), ("B", &b)])
}

/// Encodes the file of [`save_png_srgb8`] in memory.
pub fn encode_png_srgb8(image: &Rgb8Image) -> Result<Vec<u8>, MapFault> {
    encode_png(image.texels.as_flattened(), [image.width, image.height], ExtendedColorType::Rgb8)
}

/// Encodes the file of [`save_png_grey16`] in memory.
pub fn encode_png_grey16(map: &HeightMap, low: f32, high: f32) -> Result<Vec<u8>, MapFault> {
    let scale = if high > low { 65535.0 / (f64::from(high) - f64::from(low)) } else { 0.0 };
    // The cast from float to integer saturates.
    let quantise = |h: f32| ((f64::from(h) - f64::from(low)) * scale).round() as u16;
    let samples: Vec<u8> = map.texels.iter().flat_map(|&h| quantise(h).to_ne_bytes()).collect();
    encode_png(&samples, [map.width, map.height], ExtendedColorType::L16)
}

pub(super) fn encode_png(samples: &[u8], size: [u32; 2], color: ExtendedColorType) -> Result<Vec<u8>, MapFault> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive)
        .write_image(samples, size[0], size[1], color)
        .map_err(|error| MapFault::unsupported(one_line(&error), "give an image of at least 1 x 1"))?;
    Ok(bytes)
}

/// Encodes the file of [`save_exr`] in memory.
pub fn encode_exr(width: u32, height: u32, channels: &[Channel<'_>]) -> Result<Vec<u8>, MapFault> {
    encode_exr_with(width, height, channels, LayerAttributes::default())
}

/// Encodes an EXR like [`save_exr`], with provenance metadata.
///
/// # Errors
/// Returns the errors of [`save_exr`].
pub fn encode_exr_of(origin: &Origin, width: u32, height: u32, channels: &[Channel<'_>]) -> Result<Vec<u8>, MapFault> {
    encode_exr_with(width, height, channels, origin.exr_attributes())
}

fn encode_exr_with(
    width: u32,
    height: u32,
    channels: &[Channel<'_>],
    attributes: LayerAttributes,
) -> Result<Vec<u8>, MapFault> {
    let refuse = |what: String| MapFault::unsupported(what, "give channels with distinct names and equal sizes");
    if width == 0 || height == 0 {
        return Err(MapFault::Empty { width: width.into(), height: height.into() });
    }
    if channels.is_empty() {
        return Err(refuse("no channels were given".into()));
    }
    let mut list = SmallVec::new();
    for (index, &(name, values)) in channels.iter().enumerate() {
        if values.len() as u64 != u64::from(width) * u64::from(height) {
            let what = format!("channel {name} has {} values; the image is {width} x {height}", values.len());
            return Err(MapFault::SizeMismatch { what });
        }
        if channels[..index].iter().any(|&(other, _)| other == name) {
            return Err(refuse(format!("channel {name} was given twice")));
        }
        let text = Text::new_or_none(name).filter(|_| !name.is_empty());
        let text = text.ok_or_else(|| refuse(format!("`{}` is not a valid channel name", shown(name))))?;
        list.push(AnyChannel::new(text, FlatSamples::F32(values.to_vec())));
    }
    // Increasing line order and a single thread make the bytes deterministic.
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let size = Vec2(width as usize, height as usize);
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(list));
    let mut cursor = Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().non_parallel().to_buffered(&mut cursor);
    written.map_err(|error| refuse(one_line(&error)))?;
    Ok(cursor.into_inner())
}
