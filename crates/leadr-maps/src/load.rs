//! Loaders for images. The format is determined by the first bytes, not by the file name.

use std::path::Path;

use super::exr_layers::Wanted;
use super::exr_picture::{self, ExrPicture};
use super::image_class::{ImageClass, classify};
use super::image_format::{ImageFormat, unrecognised};
use super::material::{Raster, Samples};
use super::raster_read::{EXPECTED, decode_raster, decode_raster_with_remarks};
use super::srgb::linear_from_srgb;
use super::udim::{Tile, Tiles};
use super::{
    Frame, HeightMap, MapError, MapFault, Picture, Rgb8Image, RgbImage, exr_read, hdr, holes, limits, panorama,
    png_info::{self, PngInfo},
};
use crate::shown::{shown, shown_path};

/// Sentences on what was repaired, converted or left aside in a file.
type Remarks = Vec<String>;

/// Loads a height map from an image of codes (such as PNG, JPEG or TIFF, normalised to 0..1), or of floats or signed integers
/// (EXR and TIFF, values as stored, which may be negative).
///
/// In all formats but EXR, the first channel (grey or red) is the height and alpha is ignored. In EXR, the height is the only
/// channel, or else the first of `height`, `displacement`, `disp`, `Y`, `Z`, `R`. The names may be in upper or lower case
/// and may have a layer prefix. Heights of an EXR that are missing (NaN, infinite, marks such as -9999, or outside the data
/// window) are filled from their neighbours. Fails on unreadable files, files over [`limits`], maps of which more than half is
/// missing, and images that look like normal maps. Coloured images, holes and several layers only log a warning.
///
/// The name of a map in UDIM tiles contains `<UDIM>`, or is that of tile 1001. The result is the atlas of the tiles ([`Tiles`]).
pub fn load_height_map(path: impl AsRef<Path>) -> Result<HeightMap, MapError> {
    load_tiles(path.as_ref(), |file| load(file, decode_heights))
}

/// Loads heights from one channel, 0 to 3, of an image whose other channels have other meanings.
///
/// # Errors
/// Fails if the file is unreadable, over [`limits`], or has values that are not finite.
pub fn load_height_channel(path: impl AsRef<Path>, channel: usize) -> Result<HeightMap, MapError> {
    let raster = load_raster(path.as_ref())?;
    let map = HeightMap::new(raster.width(), raster.height(), channel_of(&raster, channel));
    map.map_err(|fault| fault.in_file(path))
}

/// Loads an equirectangular environment (linear radiance) from Radiance HDR or EXR.
///
/// EXR channels are `R`, `G`, `B` or `Y` of the unnamed layer, or else of a layer that is named as finished pictures are
/// (`Combined`, `beauty`, ...), or else of the only layer with colour. Colours with `chromaticities` are converted to Rec.709.
/// Texels outside the data window are black. Cube crosses and strips, and square light probes (angular maps), are converted to
/// the equirectangular layout. Fails on unreadable files, files over [`limits`], several layers without such a name, and values
/// that are not finite or are negative. The error gives the channel and position of the value. Negative values within
/// [`limits::NEGATIVE_NOISE`] come from lossy compression and become 0. Larger negative values come from resampling or gamut
/// conversion. If the sum of negative values is at most [`limits::NEGATIVE_SHARE`] of the light, all become 0. What was
/// converted, repaired or left aside is logged as a warning.
pub fn load_environment(path: impl AsRef<Path>) -> Result<RgbImage, MapError> {
    load_environment_layer(path, None)
}

/// Like [`load_environment`], from the EXR layer of this name. Case and the first words of the name may be left out if they are
/// not needed.
pub fn load_environment_layer(path: impl AsRef<Path>, layer: Option<&str>) -> Result<RgbImage, MapError> {
    load(path.as_ref(), |bytes, remarks| decode_light(bytes, layer, remarks))
}

/// Loads a colour image of any format of [`decode_raster`] as linear values. The codes are decoded as sRGB, and a gamma chunk
/// is ignored. Floats are linear. Grey fills all three channels, and alpha is ignored. 16-bit files keep their precision.
pub fn load_color(path: impl AsRef<Path>) -> Result<RgbImage, MapError> {
    load(path.as_ref(), |bytes, _| decode_color(bytes))
}

/// Loads a colour image as 8-bit sRGB codes, like [`load_color`]. 16-bit files are rounded to 8 bits.
///
/// # Errors
/// Fails if the file is unreadable or over [`limits`], or contains floats.
pub fn load_color_srgb8(path: impl AsRef<Path>) -> Result<Rgb8Image, MapError> {
    load(path.as_ref(), |bytes, _| decode_color_srgb8(bytes))
}

/// Loads a picture from display codes (like [`load_color`]) or from an EXR or HDR file (with the channels of [`load_environment`]).
/// Any value is accepted, because a render may contain NaN.
///
/// # Errors
/// Fails on unreadable files, files over [`limits`], animations, and several EXR layers of which none is the finished picture.
pub fn load_picture(path: impl AsRef<Path>) -> Result<Picture, MapError> {
    load_picture_layer(path, None)
}

/// Like [`load_picture`], from the EXR layer of this name. Case and the first words of the name may be left out if they are not
/// needed. A layer with one or three channels of another kind, such as a depth, is shown as grey or as red, green and blue.
///
/// # Errors
/// Fails like [`load_picture`], and if the file has no such layer.
pub fn load_picture_layer(path: impl AsRef<Path>, layer: Option<&str>) -> Result<Picture, MapError> {
    load(path.as_ref(), |bytes, remarks| decode_picture_layer(bytes, layer, remarks))
}

/// Loads the uninterpreted texels of an EXR, or of a format of [`decode_raster`]; UDIM tiles as in [`load_height_map`]. An EXR gives the channels R, G, B or Y (or its only channel) as
/// floats, with its alpha if present.
///
/// # Errors
/// Fails if the file is unreadable, over [`limits`], or has values that are not finite.
pub fn load_raster(path: impl AsRef<Path>) -> Result<Raster, MapError> {
    load_tiles(path.as_ref(), |file| load(file, |bytes, remarks| raster(bytes, Wanted::Numbers, remarks)))
}

/// Like [`load_raster`] for colours: those of an EXR with `chromaticities` are converted to Rec.709, and divided by its alpha.
///
/// # Errors
/// Fails like [`load_raster`].
pub fn load_color_raster(path: impl AsRef<Path>) -> Result<Raster, MapError> {
    load_tiles(path.as_ref(), |file| load(file, |bytes, remarks| raster(bytes, Wanted::Colors(None), remarks)))
}

fn raster(bytes: &[u8], wanted: Wanted<'_>, remarks: &mut Remarks) -> Result<Raster, MapFault> {
    if !exr_read::is_exr(bytes) {
        return raster_of_codes(bytes, remarks);
    }
    let ExrPicture { width, height, mut colors, alpha, .. } = exr_picture::read(bytes, wanted, remarks)?;
    if let (Wanted::Colors(_), Some(alpha)) = (wanted, &alpha) {
        let texels = colors.iter_mut().flat_map(|plane| plane.iter_mut().zip(alpha));
        texels.filter(|(_, alpha)| **alpha > 0.0).for_each(|(value, alpha)| *value /= alpha);
    }
    colors.extend(alpha);
    let samples = (0..colors[0].len()).flat_map(|i| colors.iter().map(move |plane| plane[i])).collect();
    Raster::new(width, height, colors.len(), Samples::F32(samples))
}

/// Like [`decode_raster`]. Adds the remarks.
fn raster_of_codes(bytes: &[u8], remarks: &mut Remarks) -> Result<Raster, MapFault> {
    let (raster, of_file) = decode_raster_with_remarks(bytes)?;
    remarks.extend(of_file);
    Ok(raster)
}

/// Loads a single image, or the atlas of UDIM tiles.
fn load_tiles<T: Tile>(path: &Path, load: impl Fn(&Path) -> Result<T, MapError>) -> Result<T, MapError> {
    match Tiles::find(path)? {
        Some(tiles) => tiles.load(path, load),
        None => load(path),
    }
}

fn load<T>(path: &Path, decode: impl FnOnce(&[u8], &mut Remarks) -> Result<T, MapFault>) -> Result<T, MapError> {
    let mut remarks = Vec::new();
    let decoded = limits::read_file(path).and_then(|bytes| decode(&bytes, &mut remarks));
    let loaded = decoded.map_err(|fault| fault.in_file(path))?;
    remarks.iter().for_each(|text| tracing::warn!("{}: {text}", shown_path(path)));
    Ok(loaded)
}

/// Like [`load_height_map`], but from bytes in memory, and without warnings.
pub fn decode_height_map(bytes: &[u8]) -> Result<HeightMap, MapFault> {
    decode_heights(bytes, &mut Vec::new())
}

/// Like [`decode_height_map`]. Adds remarks on what was repaired or left aside.
pub fn decode_heights(bytes: &[u8], remarks: &mut Vec<String>) -> Result<HeightMap, MapFault> {
    if exr_read::is_exr(bytes) {
        let image = exr_picture::read(bytes, Wanted::Heights, remarks)?;
        let class = match &image.colors[..] {
            [r, g, b] => classify(r.len(), |i| [r[i], g[i], b[i]]),
            _ => ImageClass::Grey,
        };
        check_class(class, remarks)?;
        let mut texels = image.colors.into_iter().next().unwrap_or_default();
        remarks.extend(holes::fill(image.width, &mut texels, image.missing, image.is_cropped)?);
        return HeightMap::new(image.width, image.height, texels);
    }
    if !is_raster(bytes) {
        return Err(unrecognised(bytes, EXPECTED, "-depth 16 FILE.png"));
    }
    let raster = raster_of_codes(bytes, remarks)?;
    let (width, height) = (raster.width(), raster.height());
    let color = |i: usize| {
        let [x, y] = [i % width as usize, i / width as usize].map(|k| k as u32);
        [0, 1, 2].map(|channel| raster.value(x, y, channel))
    };
    let class =
        if raster.channels() >= 3 { classify(width as usize * height as usize, color) } else { ImageClass::Grey };
    check_class(class, remarks)?;
    let mut texels = channel_of(&raster, 0);
    if matches!(raster.samples(), Samples::F32(_)) {
        remarks.extend(holes::fill(width, &mut texels, None, false)?);
    }
    HeightMap::new(width, height, texels)
}

fn channel_of(raster: &Raster, channel: usize) -> Vec<f32> {
    let [width, height] = raster.size();
    let positions = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    positions.map(|(x, y)| raster.value(x, y, channel)).collect()
}

fn check_class(class: ImageClass, remarks: &mut Remarks) -> Result<(), MapFault> {
    match class {
        ImageClass::Grey => {}
        ImageClass::Colors => {
            let text = "it is coloured; its red channel is used as the height. Check that it is not a colour map";
            remarks.push(text.to_owned());
        }
        ImageClass::Normals => {
            let remedy = "give it as --normal-map (leadr bake: --normal), or convert it to heights: leadr bake --normal FILE --kind height";
            return Err(MapFault::unsupported("it looks like a normal map, and a height map is expected", remedy));
        }
    }
    Ok(())
}

/// Like [`load_environment`], but from bytes in memory, and without warnings.
pub fn decode_environment(bytes: &[u8]) -> Result<RgbImage, MapFault> {
    decode_light(bytes, None, &mut Vec::new())
}

fn decode_light(bytes: &[u8], layer: Option<&str>, remarks: &mut Remarks) -> Result<RgbImage, MapFault> {
    let expected = "a Radiance HDR (.hdr) or EXR environment";
    let Radiance { mut image, is_cube, .. } = decode_radiance(bytes, layer, expected, remarks)?;
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
    if count > 0 && missing <= limits::NEGATIVE_SHARE * light {
        image.texels.as_flattened_mut().iter_mut().filter(|value| **value < 0.0).for_each(|value| *value = 0.0);
        let percent = 100.0 * missing / light;
        remarks.push(format!(
            "{count} negative values, down to {least}, are read as 0; their sum is {percent:.2} % of the light"
        ));
    }
    image.check_radiance()?;
    let (panorama, remark) = panorama::equirectangular(image, is_cube);
    remarks.extend(remark);
    Ok(panorama)
}

/// Like [`load_picture`], but from bytes in memory, and without warnings.
pub fn decode_picture(bytes: &[u8]) -> Result<Picture, MapFault> {
    decode_picture_layer(bytes, None, &mut Vec::new())
}

fn decode_picture_layer(bytes: &[u8], layer: Option<&str>, remarks: &mut Remarks) -> Result<Picture, MapFault> {
    refuse_layer(bytes, layer)?;
    let (image, alpha, frame, display_referred) = if is_raster(bytes) {
        let raster = raster_of_codes(bytes, remarks)?;
        let info = match ImageFormat::of(bytes) {
            Some(ImageFormat::Png) => png_info::read(bytes),
            _ => PngInfo::default(),
        };
        let PngInfo { color_space, pixel_aspect, orientation, frames } = info;
        if frames > 1 {
            let what = format!("it is an animation of {frames} frames");
            return Err(MapFault::unsupported(what, "save the frames as single pictures"));
        }
        if color_space != "sRGB" {
            remarks.push(format!("its colour space ({color_space}) is not applied; its codes are read as sRGB"));
        }
        let positions = (0..raster.height()).flat_map(|y| (0..raster.width()).map(move |x| (x, y)));
        let alpha =
            raster.channels().is_multiple_of(2).then(|| positions.map(|(x, y)| raster.value(x, y, 3)).collect());
        let frame = Frame { pixel_aspect, orientation, color_space, ..Frame::default() };
        (color_of(&raster)?, alpha, frame, true)
    } else {
        let Radiance { image, alpha, frame, .. } = decode_radiance(bytes, layer, EXPECTED, remarks)?;
        (image, alpha, frame, false)
    };
    let alpha = alpha.filter(|alpha: &Vec<f32>| alpha.iter().any(|&a| a != 1.0));
    Ok(Picture { image, display_referred, alpha, frame })
}

/// Refuses the name of a layer for a file of another format than EXR.
fn refuse_layer(bytes: &[u8], layer: Option<&str>) -> Result<(), MapFault> {
    let Some(layer) = layer.filter(|_| !exr_read::is_exr(bytes)) else { return Ok(()) };
    let what = format!("only EXR files have layers, such as `{}`", shown(layer));
    Err(MapFault::unsupported(what, "leave the name of the layer out"))
}

/// Linear radiance, as a file stores it.
struct Radiance {
    image: RgbImage,
    alpha: Option<Vec<f32>>,
    frame: Frame,
    /// Whether the file declares the faces of a cube, or a panorama.
    is_cube: Option<bool>,
}

fn decode_radiance(
    bytes: &[u8],
    layer: Option<&str>,
    expected: &'static str,
    remarks: &mut Remarks,
) -> Result<Radiance, MapFault> {
    refuse_layer(bytes, layer)?;
    if hdr::is_hdr(bytes) {
        let image = hdr::decode(bytes, remarks)?;
        return Ok(Radiance { image, alpha: None, frame: Frame::default(), is_cube: None });
    }
    if !exr_read::is_exr(bytes) {
        return Err(unrecognised(bytes, expected, "FILE.exr"));
    }
    let picture = exr_picture::read(bytes, Wanted::Colors(layer), remarks)?;
    let texels = (0..picture.colors[0].len()).map(|index| picture.color(index)).collect();
    let image = RgbImage::new(picture.width, picture.height, texels)?;
    let ExrPicture { alpha, origin, pixel_aspect, layer, view, is_cube, .. } = picture;
    let frame = Frame { origin, pixel_aspect, layer, view, ..Frame::default() };
    Ok(Radiance { image, alpha, frame, is_cube })
}

/// Like [`load_color`], but from bytes in memory.
pub fn decode_color(bytes: &[u8]) -> Result<RgbImage, MapFault> {
    color_of(&decode_raster(bytes)?)
}

fn color_of(raster: &Raster) -> Result<RgbImage, MapFault> {
    let texels = match raster.samples() {
        Samples::U8(_) => return Ok(srgb8_of(raster)?.to_linear()),
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
