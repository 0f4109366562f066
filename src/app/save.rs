//! Writes a frame to PNG or EXR: beside its place first, then renamed, so that a killed run leaves no half file.

use std::fs::{self, File};
use std::io::{BufReader, Cursor, Write};
use std::path::Path;

use exr::prelude as ex;
use image::{ExtendedColorType, ImageDecoder, ImageEncoder};

use super::error::AppError;
use super::frame_source::Frame;
use super::frames::FileKind;
use super::values::Size;

/// Writes `frame` to `path`, making the folders above it. `exposure` in stops applies to PNG alone.
///
/// # Errors
/// If the frame cannot be encoded or the file not written; then `path` is what it was.
pub fn save(path: &Path, kind: FileKind, frame: &Frame, exposure: f32) -> Result<(), AppError> {
    let bytes = match kind {
        FileKind::Png => png(frame, exposure).map_err(|e| e.to_string()),
        FileKind::Exr => exr(frame).map_err(|e| e.to_string()),
    }
    .map_err(|e| AppError::io("encode", path, e))?;
    write_atomically(path, &bytes).map_err(|e| AppError::io("write", path, e))
}

/// Writes beside `path` and renames; on failure nothing is left behind.
fn write_atomically(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    let beside = path.with_file_name(name);
    let written = File::create(&beside).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    written.and_then(|()| fs::rename(&beside, path)).inspect_err(|_| {
        let _ = fs::remove_file(&beside);
    })
}

fn png(frame: &Frame, exposure: f32) -> Result<Vec<u8>, image::ImageError> {
    let scale = exposure.exp2();
    let rgb: Vec<u8> = frame.color.iter().flat_map(|c| [c[0], c[1], c[2]].map(|v| srgb_byte(v * scale))).collect();
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes).write_image(
        &rgb,
        frame.width,
        frame.height,
        ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}

/// The sRGB transfer function (IEC 61966-2-1), to 8 bits.
fn srgb_byte(linear: f32) -> u8 {
    let v = linear.clamp(0.0, 1.0);
    let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

fn exr(frame: &Frame) -> Result<Vec<u8>, ex::Error> {
    let plane = |i: usize| frame.color.iter().map(|c| c[i]).collect::<Vec<_>>();
    let channel = |name: &str, values: Vec<f32>| ex::AnyChannel::new(name, ex::FlatSamples::F32(values));
    let mut channels: Vec<_> =
        ["R", "G", "B", "A"].iter().enumerate().map(|(i, name)| channel(name, plane(i))).collect();
    for (layer, planes) in &frame.layers {
        channels.extend(layer.channels().iter().zip(planes).map(|(name, values)| channel(name, values.clone())));
    }
    let encoding = ex::Encoding {
        compression: ex::Compression::ZIP16,
        blocks: ex::Blocks::ScanLines,
        // Left open, the order of blocks would depend on which thread is first.
        line_order: ex::LineOrder::Increasing,
    };
    let size = (frame.width as usize, frame.height as usize);
    let channels = ex::AnyChannels::sort(channels.into_iter().collect());
    let layer = ex::Layer::new(size, ex::LayerAttributes::default(), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    ex::WritableImage::write(&ex::Image::from_layer(layer)).to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

/// Whether `path` is a whole picture of this kind and size: it decodes to its end.
#[must_use]
pub fn is_complete(path: &Path, kind: FileKind, size: Size) -> bool {
    match kind {
        FileKind::Png => png_is_complete(path, size).is_some(),
        FileKind::Exr => exr_is_complete(path, size).is_some(),
    }
}

fn png_is_complete(path: &Path, size: Size) -> Option<()> {
    let decoder = image::codecs::png::PngDecoder::new(BufReader::new(File::open(path).ok()?)).ok()?;
    // The size is checked before a decoder takes memory for it.
    (decoder.dimensions() == (size.width, size.height)).then_some(())?;
    let mut pixels = vec![0; usize::try_from(decoder.total_bytes()).ok()?];
    decoder.read_image(&mut pixels).ok()
}

fn exr_is_complete(path: &Path, size: Size) -> Option<()> {
    use ex::{ReadChannels, ReadLayers};
    let meta = exr::meta::MetaData::read_from_file(path, false).ok()?;
    let right =
        |header: &exr::meta::header::Header| header.layer_size == ex::Vec2(size.width as usize, size.height as usize);
    meta.headers.iter().all(right).then_some(())?;
    ex::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_file(path)
        .ok()?;
    Some(())
}
