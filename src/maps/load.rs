//! The loaders. The format is recognised by the first bytes, not by the file's name.

use std::path::Path;

use super::material::{self, Raster};
use super::png_read::{Png, Samples};
use super::srgb::linear_from_srgb;
use super::{HeightMap, MapError, MapFault, Rgb8Image, RgbImage, exr_read, hdr, limits, png_read, raster_read};

/// Loads a height map from PNG or JPEG (8 or 16-bit, normalised to 0..1) or EXR (as stored, may be negative).
///
/// In a PNG or JPEG the first channel (grey, or red) is the height and alpha is ignored. In an EXR it is the only channel, or
/// else the first of `height`, `displacement`, `disp`, `Y`, `Z`, `R`, whatever its case, with or without a layer
/// prefix. Fails on anything unreadable, over [`limits`], or not finite.
pub fn load_height_map(path: impl AsRef<Path>) -> Result<HeightMap, MapError> {
    load(path.as_ref(), decode_height_map)
}

/// Loads an equirectangular environment (linear radiance) from Radiance HDR or EXR.
///
/// In an EXR the channels are `R`, `G`, `B`, or those of the first layer that has all three, or a lone `Y` as grey.
/// Fails on anything unreadable, over [`limits`], not finite or negative (channel and place are named); negative values
/// within [`limits::NEGATIVE_NOISE`] are what lossy compression leaves of black, and become 0.
pub fn load_environment(path: impl AsRef<Path>) -> Result<RgbImage, MapError> {
    load(path.as_ref(), decode_environment)
}

/// Loads a colour PNG as linear 0..1. The codes are taken as sRGB whatever the file's gamma chunk says; grey is
/// spread to the three channels; alpha is ignored. 16-bit files keep their precision.
pub fn load_color(path: impl AsRef<Path>) -> Result<RgbImage, MapError> {
    load(path.as_ref(), decode_color)
}

/// Loads a colour PNG as 8-bit sRGB codes; like [`load_color`], 16-bit files are rounded to 8.
pub fn load_color_srgb8(path: impl AsRef<Path>) -> Result<Rgb8Image, MapError> {
    load(path.as_ref(), decode_color_srgb8)
}

/// A picture to be compared or shown, from any accepted format.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Linear Rec.709.
    pub image: RgbImage,
    /// True for PNG: the file held display codes, which [`crate::maps::tonemap::Tonemap::Clamp`] at exposure 1 gives
    /// back. False for EXR and HDR: the file held radiance, which a tonemap takes to the display.
    pub display_referred: bool,
}

/// Loads a picture from PNG (as [`load_color`]), EXR or HDR (channels as [`load_environment`], but any texel value is
/// let through: a render may hold NaN).
pub fn load_picture(path: impl AsRef<Path>) -> Result<Picture, MapError> {
    load(path.as_ref(), decode_picture)
}

/// Texels of a PNG, JPEG or EXR (its R, G, B or a lone Y; floats) as they are, whatever they mean.
///
/// # Errors
/// On anything unreadable, over [`limits`], or not finite.
pub fn load_raster(path: impl AsRef<Path>) -> Result<Raster, MapError> {
    load(path.as_ref(), |bytes| {
        if !exr_read::is_exr(bytes) {
            return raster_read::decode_raster(bytes);
        }
        let exr_read::Planes { width, height, planes } = exr_read::decode(bytes, choose_rgb, "R, G, B or Y")?;
        let channels = planes.len();
        let samples = (0..planes[0].len()).flat_map(|i| planes.iter().map(move |plane| plane[i])).collect();
        Raster::new(width, height, channels, material::Samples::F32(samples))
    })
}

fn load<T>(path: &Path, decode: fn(&[u8]) -> Result<T, MapFault>) -> Result<T, MapError> {
    limits::read_file(path).and_then(|bytes| decode(&bytes)).map_err(|fault| fault.in_file(path))
}

/// [`load_height_map`] from bytes in memory.
pub fn decode_height_map(bytes: &[u8]) -> Result<HeightMap, MapFault> {
    if exr_read::is_exr(bytes) {
        let image = exr_read::decode(bytes, choose_height, "named height, displacement, disp, Y, Z or R")?;
        let texels = image.planes.into_iter().next().unwrap_or_default();
        return HeightMap::new(image.width, image.height, texels);
    }
    if !raster_read::is_raster(bytes) {
        return Err(MapFault::Unrecognised { expected: "a PNG, JPEG or EXR height map" });
    }
    let raster = raster_read::decode_raster(bytes)?;
    let places = (0..raster.height()).flat_map(|y| (0..raster.width()).map(move |x| (x, y)));
    HeightMap::new(raster.width(), raster.height(), places.map(|(x, y)| raster.value(x, y, 0)).collect())
}

/// [`load_environment`] from bytes in memory.
pub fn decode_environment(bytes: &[u8]) -> Result<RgbImage, MapFault> {
    let mut image = decode_radiance(bytes, "a Radiance HDR (.hdr) or EXR environment")?;
    for value in image.texels.as_flattened_mut() {
        if (limits::NEGATIVE_NOISE..0.0).contains(value) {
            *value = 0.0;
        }
    }
    image.check_radiance()?;
    Ok(image)
}

/// [`load_picture`] from bytes in memory.
pub fn decode_picture(bytes: &[u8]) -> Result<Picture, MapFault> {
    let display_referred = png_read::is_png(bytes);
    let image =
        if display_referred { decode_color(bytes)? } else { decode_radiance(bytes, "a PNG, EXR or HDR picture")? };
    Ok(Picture { image, display_referred })
}

fn decode_radiance(bytes: &[u8], expected: &'static str) -> Result<RgbImage, MapFault> {
    if hdr::is_hdr(bytes) {
        hdr::decode(bytes)
    } else if exr_read::is_exr(bytes) {
        let exr_read::Planes { width, height, planes } = exr_read::decode(bytes, choose_rgb, "R, G, B or Y")?;
        let plane = |c: usize| &planes[c.min(planes.len() - 1)];
        let (r, g, b) = (plane(0), plane(1), plane(2));
        let texels = (0..r.len()).map(|i| [r[i], g[i], b[i]]).collect();
        RgbImage::new(width, height, texels)
    } else {
        Err(MapFault::Unrecognised { expected })
    }
}

/// [`load_color`] from bytes in memory.
pub fn decode_color(bytes: &[u8]) -> Result<RgbImage, MapFault> {
    let Png { width, height, channels, samples } = decode_color_png(bytes)?;
    let texels = match samples {
        Samples::U8(s) => {
            return Ok(Rgb8Image::new(width, height, spread(&s, channels))?.to_linear());
        }
        Samples::U16(s) => spread(&s, channels),
    };
    let texels = texels.into_iter().map(|t| t.map(|v| linear_from_srgb(f32::from(v) / 65535.0))).collect();
    RgbImage::new(width, height, texels)
}

/// [`load_color_srgb8`] from bytes in memory.
pub fn decode_color_srgb8(bytes: &[u8]) -> Result<Rgb8Image, MapFault> {
    let Png { width, height, channels, samples } = decode_color_png(bytes)?;
    let texels = match samples {
        Samples::U8(s) => spread(&s, channels),
        // 65535 = 257 * 255, so this rounds to the nearest code.
        Samples::U16(s) => {
            spread(&s, channels).into_iter().map(|t| t.map(|v| ((u32::from(v) + 128) / 257) as u8)).collect()
        }
    };
    Rgb8Image::new(width, height, texels)
}

fn decode_color_png(bytes: &[u8]) -> Result<Png, MapFault> {
    if !png_read::is_png(bytes) {
        return Err(MapFault::Unrecognised { expected: "a PNG colour map" });
    }
    png_read::decode(bytes)
}

/// Grey or RGB, with or without alpha, to RGB.
fn spread<T: Copy>(samples: &[T], channels: usize) -> Vec<[T; 3]> {
    let texels = samples.chunks_exact(channels);
    if channels < 3 { texels.map(|t| [t[0]; 3]).collect() } else { texels.map(|t| [t[0], t[1], t[2]]).collect() }
}

/// The name without its layer, in lower case.
fn last_part(name: &str) -> String {
    name.rsplit('.').next().unwrap_or(name).to_ascii_lowercase()
}

fn choose_height(names: &[String]) -> Option<Vec<usize>> {
    if names.len() == 1 {
        return Some(vec![0]);
    }
    let wanted = ["height", "displacement", "disp", "y", "z", "r"];
    wanted.iter().find_map(|w| names.iter().position(|n| last_part(n) == *w)).map(|i| vec![i])
}

fn choose_rgb(names: &[String]) -> Option<Vec<usize>> {
    let rgb_of = |prefix: &str| -> Option<Vec<usize>> {
        ["R", "G", "B"].iter().map(|c| names.iter().position(|n| *n == format!("{prefix}{c}"))).collect()
    };
    rgb_of("")
        .or_else(|| names.iter().filter_map(|n| n.strip_suffix('R')).find_map(rgb_of))
        .or_else(|| (names.len() == 1 && last_part(&names[0]) == "y").then(|| vec![0]))
}
