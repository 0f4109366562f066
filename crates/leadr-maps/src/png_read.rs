//! PNG through the `image` crate, with the size checked before anything is unpacked. Palettes and greys of 1, 2 or 4 bits
//! arrive expanded to 8 bits; interlacing and 16 bits are handled; only the first frame of an animation is read.

use std::io::Cursor;

use image::codecs::png::PngDecoder;
use image::{ColorType, ImageDecoder, ImageError, Limits};

use super::{MapFault, limits};

/// Samples of a PNG: `channels` interleaved per texel (1 grey, 2 grey and alpha, 3 RGB, 4 RGBA).
pub(crate) struct Png {
    pub width: u32,
    pub height: u32,
    pub channels: usize,
    pub samples: Samples,
}

/// The two depths that remain after expansion.
pub(crate) enum Samples {
    U8(Vec<u8>),
    U16(Vec<u16>),
}

/// Whether the bytes start like a PNG. Only the letters `PNG` are checked, so that a PNG whose signature was damaged in transfer
/// is called damaged rather than unknown.
pub(crate) fn is_png(bytes: &[u8]) -> bool {
    bytes.len() >= 4 && &bytes[1..4] == b"PNG"
}

/// Decodes a whole PNG.
pub(crate) fn decode(bytes: &[u8]) -> Result<Png, MapFault> {
    let mut cap = Limits::no_limits();
    cap.max_image_width = Some(limits::MAX_SIDE as u32);
    cap.max_image_height = Some(limits::MAX_SIDE as u32);
    cap.max_alloc = Some(limits::MAX_DECODED_BYTES);
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), cap).map_err(|error| fault(error, REMEDY))?;
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    let (channels, wide) = match color {
        ColorType::L8 => (1, false),
        ColorType::La8 => (2, false),
        ColorType::Rgb8 => (3, false),
        ColorType::Rgba8 => (4, false),
        ColorType::L16 => (1, true),
        ColorType::La16 => (2, true),
        ColorType::Rgb16 => (3, true),
        ColorType::Rgba16 => (4, true),
        other => {
            let what = format!("its texels are {other:?}");
            return Err(MapFault::Unsupported { what, remedy: "save it as 8 or 16-bit grey or RGB".into() });
        }
    };
    limits::check_size(width.into(), height.into(), u64::from(color.bytes_per_pixel()), bytes.len())?;
    let count = width as usize * height as usize * channels;
    let samples = if wide {
        let mut samples = limits::zeroed::<u16>(count)?;
        decoder.read_image(bytemuck::cast_slice_mut(&mut samples)).map_err(|error| fault(error, REMEDY))?;
        Samples::U16(samples)
    } else {
        let mut samples = limits::zeroed::<u8>(count)?;
        decoder.read_image(&mut samples).map_err(|error| fault(error, REMEDY))?;
        Samples::U8(samples)
    };
    Ok(Png { width, height, channels, samples })
}

const REMEDY: &str = "save it as 8 or 16-bit grey or RGB PNG";

/// A decoder's error, worded as one of our sentences. `remedy`: for what it does not support.
pub(super) fn fault(error: ImageError, remedy: &str) -> MapFault {
    match error {
        ImageError::Unsupported(reason) => MapFault::Unsupported { what: one_line(&reason), remedy: remedy.into() },
        ImageError::Limits(reason) => MapFault::TooLarge { what: one_line(&reason) },
        ImageError::IoError(reason) => MapFault::damaged(one_line(&reason)),
        other => MapFault::damaged(one_line(&other)),
    }
}

/// A foreign error message without line breaks.
pub(crate) fn one_line(message: &dyn std::fmt::Display) -> String {
    message.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
