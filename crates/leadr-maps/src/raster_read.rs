//! Decodes PNG and JPEG files to a [`Raster`] through the `image` crate. The size is checked before decompression. Palettes,
//! and greys of 1, 2 or 4 bits, are expanded to 8 bits. Interlacing and 16 bits are supported. Only the first frame of an
//! animation is read.

use std::io::Cursor;

use image::codecs::jpeg::JpegDecoder;
use image::codecs::png::PngDecoder;
use image::{ImageDecoder, ImageError, Limits};

use super::fault::one_line;
use super::foreign::unrecognised;
use super::guard::guarded;
use super::material::{Raster, Samples};
use super::{MapFault, limits};

const PNG_REMEDY: &str = "save it as 8 or 16-bit grey or RGB PNG";
const JPEG_REMEDY: &str = "save it as an 8-bit grey or RGB JPEG";

pub(super) fn is_raster(bytes: &[u8]) -> bool {
    is_jpeg(bytes) || is_png(bytes)
}

/// Whether the bytes start like a PNG. Only the letters `PNG` are checked, so that a file whose signature was damaged in
/// transfer is reported as damaged instead of unknown.
pub(super) fn is_png(bytes: &[u8]) -> bool {
    bytes.len() >= 4 && &bytes[1..4] == b"PNG"
}

fn is_jpeg(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xff, 0xd8])
}

/// Decodes a PNG (8 or 16 bits, grey or colour, with or without alpha) or a JPEG (grey or colour; CMYK becomes RGB). The first
/// bytes determine the format.
///
/// # Errors
/// Fails if the format is unsupported, or if the file is damaged or exceeds [`limits`].
pub fn decode_raster(bytes: &[u8]) -> Result<Raster, MapFault> {
    if is_jpeg(bytes) {
        return guarded("JPEG", || decode_jpeg(bytes));
    }
    if is_png(bytes) {
        return decode_png(bytes);
    }
    Err(unrecognised(bytes, "a PNG, JPEG or EXR image", "FILE.png"))
}

/// Returns the width, the height and the bytes per texel in the header of a PNG or JPEG.
pub(super) fn declared_size(bytes: &[u8]) -> Result<(u64, u64, u64), MapFault> {
    fn size(decoder: impl ImageDecoder) -> (u64, u64, u64) {
        let (width, height) = decoder.dimensions();
        (width.into(), height.into(), decoder.color_type().bytes_per_pixel().into())
    }
    if is_png(bytes) {
        return png_decoder(bytes).map(size);
    }
    guarded("JPEG", || jpeg_decoder(bytes).map(size))
}

fn png_decoder(bytes: &[u8]) -> Result<PngDecoder<Cursor<&[u8]>>, MapFault> {
    let mut cap = Limits::no_limits();
    cap.max_image_width = Some(limits::MAX_SIDE as u32);
    cap.max_image_height = Some(limits::MAX_SIDE as u32);
    cap.max_alloc = Some(limits::MAX_DECODED_BYTES);
    PngDecoder::with_limits(Cursor::new(bytes), cap).map_err(|error| fault(error, PNG_REMEDY))
}

fn jpeg_decoder(bytes: &[u8]) -> Result<JpegDecoder<Cursor<&[u8]>>, MapFault> {
    JpegDecoder::new(Cursor::new(bytes)).map_err(|error| fault(error, JPEG_REMEDY))
}

pub(super) fn decode_png(bytes: &[u8]) -> Result<Raster, MapFault> {
    unpack(png_decoder(bytes)?, bytes.len(), PNG_REMEDY)
}

fn decode_jpeg(bytes: &[u8]) -> Result<Raster, MapFault> {
    // The decoder fills missing rows with grey, so a truncated file is refused first.
    if !has_end(bytes) {
        return Err(MapFault::damaged("its JPEG data end early"));
    }
    unpack(jpeg_decoder(bytes)?, bytes.len(), JPEG_REMEDY)
}

fn unpack(decoder: impl ImageDecoder, file_bytes: usize, remedy: &str) -> Result<Raster, MapFault> {
    let ((width, height), color) = (decoder.dimensions(), decoder.color_type());
    let channels = usize::from(color.channel_count());
    limits::check_size(width.into(), height.into(), color.bytes_per_pixel().into(), file_bytes)?;
    let count = width as usize * height as usize * channels;
    let samples = match usize::from(color.bytes_per_pixel()) / channels {
        1 => {
            let mut samples = limits::zeroed::<u8>(count)?;
            decoder.read_image(&mut samples).map_err(|error| fault(error, remedy))?;
            Samples::U8(samples)
        }
        2 => {
            let mut samples = limits::zeroed::<u16>(count)?;
            decoder.read_image(bytemuck::cast_slice_mut(&mut samples)).map_err(|error| fault(error, remedy))?;
            Samples::U16(samples)
        }
        _ => return Err(MapFault::unsupported(format!("its texels are {color:?}"), remedy)),
    };
    Raster::new(width, height, channels, samples)
}

/// Converts a decoder error to a `MapFault`. `remedy` is used for unsupported features.
fn fault(error: ImageError, remedy: &str) -> MapFault {
    match error {
        ImageError::Unsupported(reason) => MapFault::unsupported(one_line(&reason), remedy),
        ImageError::Limits(reason) => MapFault::too_large(one_line(&reason)),
        ImageError::IoError(reason) => MapFault::damaged(one_line(&reason)),
        other => MapFault::damaged(one_line(&other)),
    }
}

/// Whether a JPEG has its end marker after the first scan. Segments before the scan may contain other JPEGs, such as thumbnails.
fn has_end(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some(&[0xff, marker]) = bytes.get(at..at + 2) {
        match marker {
            // After a start of scan, the only markers in the data are restarts.
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
