//! Loaders for images. The format is determined by the first bytes, not by the file name.

use std::path::Path;

use super::image_class::{ImageClass, classify};
use super::image_format::{ImageFormat, unrecognised};
use super::material::{Raster, Samples};
use super::raster_read::{EXPECTED, decode_raster, decode_raster_with_remarks};
use super::srgb::linear_from_srgb;
use super::{HeightMap, MapError, MapFault, Rgb8Image, RgbImage, exr_read, hdr, limits};
use crate::shown::shown_path;

/// Loads a height map from an image of codes (such as PNG, JPEG or TIFF, normalised to 0..1), or of floats or signed integers
/// (EXR and TIFF, values as stored, which may be negative).
///
/// In all formats but EXR, the first channel (grey or red) is the height and alpha is ignored. In EXR, the height is the only
/// channel, or else the first of `height`, `displacement`, `disp`, `Y`, `Z`, `R`. The names may be in upper or lower case
/// and may have a layer prefix. Fails on unreadable files, files over [`limits`], values that are not finite, and images
/// that look like normal maps. Coloured images only log a warning.
pub fn load_height_map(path: impl AsRef<Path>) -> Result<HeightMap, MapError> {
    let (map, class, remarks) = load(path.as_ref(), decode_heights)?;
    remarks.iter().for_each(|text| remark(path.as_ref(), text));
    if class == ImageClass::Colors {
        remark(
            path.as_ref(),
            "it is coloured; its red channel is used as the height. Check that it is not a colour map",
        );
    }
    Ok(map)
}

/// Loads heights from one channel, 0 to 3, of an image whose other channels have other meanings.
///
/// # Errors
/// Fails if the file is unreadable, over [`limits`], or has values that are not finite.
pub fn load_height_channel(path: impl AsRef<Path>, channel: usize) -> Result<HeightMap, MapError> {
    let raster = load_raster(path.as_ref())?;
    heights_of(&raster, channel).map_err(|fault| fault.in_file(path))
}

/// Loads an equirectangular environment (linear radiance) from Radiance HDR or EXR.
///
/// EXR channels are `R`, `G`, `B`, or those of the first layer with all three, or a single `Y` as grey. Fails on unreadable
/// files, files over [`limits`], and values that are not finite or are negative. The error gives the channel and position of
/// the value. Negative values within [`limits::NEGATIVE_NOISE`] come from lossy compression and become 0. Larger negative
/// values come from resampling or gamut conversion. If the sum of negative values is at most [`limits::NEGATIVE_SHARE`] of
/// the light, all become 0, and a warning is logged.
pub fn load_environment(path: impl AsRef<Path>) -> Result<RgbImage, MapError> {
    let (image, clamped) = load(path.as_ref(), decode_light)?;
    if let Some(clamped) = clamped {
        remark(path.as_ref(), &clamped);
    }
    Ok(image)
}

/// Loads a colour image of any format of [`decode_raster`] as linear values. The codes are decoded as sRGB, and a gamma chunk
/// is ignored. Floats are linear. Grey fills all three channels, and alpha is ignored. 16-bit files keep their precision.
pub fn load_color(path: impl AsRef<Path>) -> Result<RgbImage, MapError> {
    load(path.as_ref(), decode_color)
}

/// Loads a colour image as 8-bit sRGB codes, like [`load_color`]. 16-bit files are rounded to 8 bits.
///
/// # Errors
/// Fails if the file is unreadable or over [`limits`], or contains floats.
pub fn load_color_srgb8(path: impl AsRef<Path>) -> Result<Rgb8Image, MapError> {
    load(path.as_ref(), decode_color_srgb8)
}

/// A picture for comparison or display, loaded from any supported format.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// The image in linear Rec.709.
    pub image: RgbImage,
    /// Whether the file contained display codes (such as PNG). [`crate::tonemap::Tonemap::Clamp`] at exposure 1 reproduces the
    /// codes. EXR and HDR files contain radiance instead, which needs tonemapping.
    pub display_referred: bool,
}

/// Loads a picture from display codes (like [`load_color`]) or from an EXR or HDR file (with the channels of [`load_environment`]).
/// Any value is accepted, because a render may contain NaN.
pub fn load_picture(path: impl AsRef<Path>) -> Result<Picture, MapError> {
    load(path.as_ref(), decode_picture)
}

/// Loads the uninterpreted texels of an EXR, or of a format of [`decode_raster`]. An EXR gives the channels R, G, B or a single Y as floats.
///
/// # Errors
/// Fails if the file is unreadable, over [`limits`], or has values that are not finite.
pub fn load_raster(path: impl AsRef<Path>) -> Result<Raster, MapError> {
    let (raster, remarks) = load(path.as_ref(), |bytes| {
        if !exr_read::is_exr(bytes) {
            return decode_raster_with_remarks(bytes);
        }
        let exr_read::Planes { width, height, planes } = exr_read::decode(bytes, choose_rgb, "R, G, B or Y")?;
        let channels = planes.len();
        let samples = (0..planes[0].len()).flat_map(|i| planes.iter().map(move |plane| plane[i])).collect();
        Raster::new(width, height, channels, Samples::F32(samples)).map(|raster| (raster, Vec::new()))
    })?;
    remarks.iter().for_each(|text| remark(path.as_ref(), text));
    Ok(raster)
}

fn remark(file: &Path, text: &str) {
    tracing::warn!("{}: {text}", shown_path(file));
}

fn load<T>(path: &Path, decode: fn(&[u8]) -> Result<T, MapFault>) -> Result<T, MapError> {
    limits::read_file(path).and_then(|bytes| decode(&bytes)).map_err(|fault| fault.in_file(path))
}

/// Like [`load_height_map`], but from bytes in memory.
pub fn decode_height_map(bytes: &[u8]) -> Result<HeightMap, MapFault> {
    decode_heights(bytes).map(|(map, ..)| map)
}

/// Decodes heights. Also returns the class of the image, and remarks about repairs.
fn decode_heights(bytes: &[u8]) -> Result<(HeightMap, ImageClass, Vec<String>), MapFault> {
    if exr_read::is_exr(bytes) {
        let image = exr_read::decode(bytes, choose_height, "named height, displacement, disp, Y, Z or R")?;
        let class = match &image.planes[..] {
            [r, g, b] => classify(r.len(), |i| [r[i], g[i], b[i]]),
            _ => ImageClass::Grey,
        };
        let texels = image.planes.into_iter().next().unwrap_or_default();
        return Ok((HeightMap::new(image.width, image.height, texels)?, refuse_normals(class)?, Vec::new()));
    }
    if !is_raster(bytes) {
        return Err(unrecognised(bytes, EXPECTED, "-depth 16 FILE.png"));
    }
    let (raster, remarks) = decode_raster_with_remarks(bytes)?;
    let (width, height) = (raster.width(), raster.height());
    let color = |i: usize| {
        let [x, y] = [i % width as usize, i / width as usize].map(|k| k as u32);
        [0, 1, 2].map(|channel| raster.value(x, y, channel))
    };
    let class =
        if raster.channels() >= 3 { classify(width as usize * height as usize, color) } else { ImageClass::Grey };
    refuse_normals(class)?;
    Ok((heights_of(&raster, 0)?, class, remarks))
}

fn heights_of(raster: &Raster, channel: usize) -> Result<HeightMap, MapFault> {
    let [width, height] = raster.size();
    let positions = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    HeightMap::new(width, height, positions.map(|(x, y)| raster.value(x, y, channel)).collect())
}

fn refuse_normals(class: ImageClass) -> Result<ImageClass, MapFault> {
    if class != ImageClass::Normals {
        return Ok(class);
    }
    let remedy = "give it as --normal-map (leadr bake: --normal), or convert it to heights: leadr bake --normal FILE --kind height";
    Err(MapFault::unsupported("it looks like a normal map, and a height map is expected", remedy))
}

/// Like [`load_environment`], but from bytes in memory.
pub fn decode_environment(bytes: &[u8]) -> Result<RgbImage, MapFault> {
    decode_light(bytes).map(|(image, _)| image)
}

/// Decodes an environment. Also returns a warning if negative values exceed the noise limit.
fn decode_light(bytes: &[u8]) -> Result<(RgbImage, Option<String>), MapFault> {
    let mut image = decode_radiance(bytes, "a Radiance HDR (.hdr) or EXR environment")?;
    let (mut light, mut missing, mut count, mut least) = (0.0f64, 0.0f64, 0u64, 0.0f32);
    for value in image.texels.as_flattened_mut() {
        if (limits::NEGATIVE_NOISE..0.0).contains(value) {
            *value = 0.0;
        } else if *value < 0.0 {
            (missing, count, least) = (missing - f64::from(*value), count + 1, least.min(*value));
        } else if *value > 0.0 {
            light += f64::from(*value);
        }
    }
    let mut clamped = None;
    if count > 0 && missing <= limits::NEGATIVE_SHARE * light {
        image.texels.as_flattened_mut().iter_mut().filter(|value| **value < 0.0).for_each(|value| *value = 0.0);
        let percent = 100.0 * missing / light;
        clamped = Some(format!(
            "{count} negative values, down to {least}, are read as 0; their sum is {percent:.2} % of the light"
        ));
    }
    image.check_radiance()?;
    Ok((image, clamped))
}

/// Like [`load_picture`], but from bytes in memory.
pub fn decode_picture(bytes: &[u8]) -> Result<Picture, MapFault> {
    let display_referred = is_raster(bytes);
    let image = if display_referred { decode_color(bytes)? } else { decode_radiance(bytes, EXPECTED)? };
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
        Err(unrecognised(bytes, expected, "FILE.exr"))
    }
}

/// Like [`load_color`], but from bytes in memory.
pub fn decode_color(bytes: &[u8]) -> Result<RgbImage, MapFault> {
    let raster = decode_raster(bytes)?;
    let texels = match raster.samples() {
        Samples::U8(_) => return Ok(srgb8_of(&raster)?.to_linear()),
        Samples::U16(codes) => {
            let linear = |code: u16| linear_from_srgb(f32::from(code) / 65535.0);
            colors(codes, raster.channels()).map(|t| t.map(linear)).collect()
        }
        Samples::F32(values) => colors(values, raster.channels()).collect(),
    };
    RgbImage::new(raster.width(), raster.height(), texels)
}

/// Like [`load_color_srgb8`], but from bytes in memory.
pub fn decode_color_srgb8(bytes: &[u8]) -> Result<Rgb8Image, MapFault> {
    srgb8_of(&decode_raster(bytes)?)
}

fn is_raster(bytes: &[u8]) -> bool {
    ImageFormat::of(bytes).is_some_and(ImageFormat::is_raster)
}

fn srgb8_of(raster: &Raster) -> Result<Rgb8Image, MapFault> {
    let texels = match raster.samples() {
        Samples::U8(codes) => colors(codes, raster.channels()).collect(),
        // 65535 = 257 * 255, so the division rounds to the nearest 8-bit code.
        Samples::U16(codes) => {
            let nearest = |code: u16| ((u32::from(code) + 128) / 257) as u8;
            colors(codes, raster.channels()).map(|t| t.map(nearest)).collect()
        }
        Samples::F32(_) => return Err(MapFault::unsupported("its samples are floats", "save it as an 8-bit PNG")),
    };
    Rgb8Image::new(raster.width(), raster.height(), texels)
}

/// Converts samples of grey or RGB images, with or without alpha, to RGB.
fn colors<T: Copy>(samples: &[T], channels: usize) -> impl Iterator<Item = [T; 3]> {
    samples.chunks_exact(channels).map(move |t| if channels < 3 { [t[0]; 3] } else { [t[0], t[1], t[2]] })
}

/// Returns the channel name in lower case, without the layer prefix.
fn last_part(name: &str) -> String {
    name.rsplit('.').next().unwrap_or(name).to_ascii_lowercase()
}

fn choose_height(names: &[String]) -> Option<Vec<usize>> {
    if names.len() == 1 {
        return Some(vec![0]);
    }
    let wanted = ["height", "displacement", "disp", "y", "z", "r"];
    let height = wanted.iter().find_map(|w| names.iter().position(|n| last_part(n) == *w))?;
    // All three colours are selected, because they may form a normal map.
    let colors = choose_rgb(names).filter(|rgb| rgb.first() == Some(&height));
    Some(colors.unwrap_or(vec![height]))
}

fn choose_rgb(names: &[String]) -> Option<Vec<usize>> {
    let rgb_of = |prefix: &str| -> Option<Vec<usize>> {
        ["R", "G", "B"].iter().map(|c| names.iter().position(|n| *n == format!("{prefix}{c}"))).collect()
    };
    rgb_of("")
        .or_else(|| names.iter().filter_map(|n| n.strip_suffix('R')).find_map(rgb_of))
        .or_else(|| (names.len() == 1 && last_part(&names[0]) == "y").then(|| vec![0]))
}
