//! PNG and JPEG of any kind to a [`Raster`], with the size checked before anything is unpacked.

use std::io::Cursor;

use image::codecs::jpeg::JpegDecoder;
use image::{ColorType, ImageDecoder};

use super::foreign::unrecognised;
use super::guard::guarded;
use super::material::{Raster, Samples};
use super::png_read::{self, fault};
use super::{MapFault, limits};

const REMEDY: &str = "save it as an 8-bit grey or RGB JPEG";

/// Whether it begins as a PNG or a JPEG does.
pub(super) fn is_raster(bytes: &[u8]) -> bool {
    is_jpeg(bytes) || png_read::is_png(bytes)
}

fn is_jpeg(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xff, 0xd8])
}

/// Decodes a PNG (8 or 16 bits, grey or colour, with or without alpha) or a JPEG (grey or colour; CMYK becomes RGB). The format is
/// recognised by the first bytes.
///
/// # Errors
/// On anything else, anything damaged, and anything over [`limits`].
pub fn decode_raster(bytes: &[u8]) -> Result<Raster, MapFault> {
    if is_jpeg(bytes) {
        return guarded("JPEG", || decode_jpeg(bytes));
    }
    if !png_read::is_png(bytes) {
        return Err(unrecognised(bytes, "a PNG, JPEG or EXR image", "FILE.png"));
    }
    let png = png_read::decode(bytes)?;
    let samples = match png.samples {
        png_read::Samples::U8(samples) => Samples::U8(samples),
        png_read::Samples::U16(samples) => Samples::U16(samples),
    };
    Raster::new(png.width, png.height, png.channels, samples)
}

fn decode_jpeg(bytes: &[u8]) -> Result<Raster, MapFault> {
    // The decoder would fill the rest with grey.
    if !has_end(bytes) {
        return Err(MapFault::damaged("its JPEG data end early"));
    }
    let decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(|error| fault(error, REMEDY))?;
    let (width, height) = decoder.dimensions();
    let channels = match decoder.color_type() {
        ColorType::L8 => 1,
        ColorType::Rgb8 => 3,
        other => {
            let what = format!("its texels are {other:?}");
            return Err(MapFault::Unsupported { what, remedy: REMEDY.into() });
        }
    };
    limits::check_size(width.into(), height.into(), channels as u64, bytes.len())?;
    let mut samples = limits::zeroed(width as usize * height as usize * channels)?;
    decoder.read_image(&mut samples).map_err(|error| fault(error, REMEDY))?;
    Raster::new(width, height, channels, Samples::U8(samples))
}

/// Whether the end marker of a JPEG stands behind its first scan. The segments before the scan may hold other JPEGs, as thumbnails.
fn has_end(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some(&[0xff, marker]) = bytes.get(at..at + 2) {
        match marker {
            // Start of scan: its data hold no marker but those of restarts.
            0xda => return bytes[at..].windows(2).any(|pair| pair == [0xff, 0xd9]),
            0xff => at += 1,
            0x01 | 0xd0..=0xd8 => at += 2,
            _ => {
                let Some(length) = bytes.get(at + 2..at + 4) else { return false };
                at += 2 + usize::from(u16::from_be_bytes([length[0], length[1]]));
            }
        }
    }
    false
}
