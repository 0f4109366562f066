//! PNG and JPEG of any kind to a [`Raster`], with the size checked before anything is unpacked.

use std::io::Cursor;

use image::codecs::jpeg::JpegDecoder;
use image::{ColorType, ImageDecoder, ImageError};

use super::guard::guarded;
use super::material::{Raster, Samples};
use super::png_read::{self, one_line};
use super::{MapFault, limits};

/// Decodes a PNG (8 or 16 bits, grey or colour, with or without alpha) or a JPEG (grey or colour; CMYK becomes RGB). The format is
/// recognised by the first bytes.
///
/// # Errors
/// On anything else, anything damaged, and anything over [`limits`].
pub fn decode_raster(bytes: &[u8]) -> Result<Raster, MapFault> {
    if bytes.starts_with(&[0xff, 0xd8]) {
        return guarded("JPEG", || decode_jpeg(bytes));
    }
    if !png_read::is_png(bytes) {
        return Err(MapFault::Unrecognised { expected: "a PNG or JPEG image" });
    }
    let png = png_read::decode(bytes)?;
    let samples = match png.samples {
        png_read::Samples::U8(samples) => Samples::U8(samples),
        png_read::Samples::U16(samples) => Samples::U16(samples),
    };
    Raster::new(png.width, png.height, png.channels, samples)
}

fn decode_jpeg(bytes: &[u8]) -> Result<Raster, MapFault> {
    let decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(fault)?;
    let (width, height) = decoder.dimensions();
    let channels = match decoder.color_type() {
        ColorType::L8 => 1,
        ColorType::Rgb8 => 3,
        other => {
            let what = format!("its texels are {other:?}");
            return Err(MapFault::Unsupported { what, remedy: "save it as an 8-bit grey or RGB JPEG".into() });
        }
    };
    limits::check_size(width.into(), height.into(), channels as u64, bytes.len())?;
    let mut samples = limits::zeroed(width as usize * height as usize * channels)?;
    decoder.read_image(&mut samples).map_err(fault)?;
    Raster::new(width, height, channels, Samples::U8(samples))
}

/// The decoder's error, worded as one of our sentences.
fn fault(error: ImageError) -> MapFault {
    match error {
        ImageError::Unsupported(reason) => {
            MapFault::Unsupported { what: one_line(&reason), remedy: "save it as an 8-bit grey or RGB JPEG".into() }
        }
        ImageError::Limits(reason) => MapFault::TooLarge { what: one_line(&reason) },
        ImageError::IoError(reason) => MapFault::damaged(one_line(&reason)),
        other => MapFault::damaged(one_line(&other)),
    }
}
