//! Saving files: PNG and EXR with deterministic bytes, written beside their target and renamed into place, so that a
//! killed or failed run leaves either the old file or the new one.

use std::fs::{self, File};
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    SmallVec, Text, Vec2, WritableImage,
};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::png_read::one_line;
use super::tonemap::{Tonemap, display_image};
use super::{HeightMap, MapError, MapFault, Rgb8Image, RgbImage};

/// Writes `bytes` to `path` all or nothing: into a new file in the same folder, synced, then renamed over `path`.
/// On failure the new file is removed and an old `path` is untouched.
pub fn write_atomic(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), MapError> {
    let mut new = NewFile::create(&path)?;
    new.file.write_all(bytes).map_err(|source| MapFault::Io { doing: "cannot be written", source }.in_file(&path))?;
    new.finish()
}

/// A file on its way: written beside its target, and renamed over it when it is finished. Dropped before that, it is removed, and
/// an old file stays as it was.
#[derive(Debug)]
pub struct NewFile {
    /// What is written to.
    pub file: File,
    beside: PathBuf,
    target: PathBuf,
    finished: bool,
}

impl NewFile {
    /// Starts the file, so that a folder that refuses it is found before any work.
    ///
    /// # Errors
    /// If no file can be made in the folder of `target`.
    pub fn create(target: impl AsRef<Path>) -> Result<Self, MapError> {
        let target = target.as_ref().to_path_buf();
        let beside = beside(&target);
        let refused = |source| {
            MapFault::Io { doing: "cannot be written: its folder refuses a new file", source }.in_file(&target)
        };
        let file = File::options().read(true).write(true).create_new(true).open(&beside).map_err(refused)?;
        Ok(Self { file, beside, target, finished: false })
    }

    /// What the file will be called.
    #[must_use]
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Syncs the file and renames it.
    ///
    /// # Errors
    /// If the disk or the folder refuses.
    pub fn finish(mut self) -> Result<(), MapError> {
        let fault = |doing, source| MapFault::Io { doing, source }.in_file(&self.target);
        self.file.sync_all().map_err(|e| fault("cannot be written to disk", e))?;
        fs::rename(&self.beside, &self.target).map_err(|e| fault("cannot be replaced", e))?;
        self.finished = true;
        Ok(())
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        if !self.finished {
            // A second failure changes nothing; the first is the one to report.
            let _ = fs::remove_file(&self.beside);
        }
    }
}

/// A name in the same folder that no other process or thread uses.
fn beside(path: &Path) -> PathBuf {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let unique = COUNT.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{unique}.part", std::process::id()))
}

/// Saves 8-bit sRGB codes as PNG.
pub fn save_png_srgb8(path: impl AsRef<Path>, image: &Rgb8Image) -> Result<(), MapError> {
    let bytes = encode_png_srgb8(image).map_err(|f| f.in_file(&path))?;
    write_atomic(path, &bytes)
}

/// Saves linear radiance as an 8-bit sRGB PNG through `tonemap`, times `exposure`. NaN texels become magenta
/// ([`super::tonemap::display_srgb8`]).
pub fn save_png(path: impl AsRef<Path>, image: &RgbImage, exposure: f32, tonemap: Tonemap) -> Result<(), MapError> {
    save_png_srgb8(path, &display_image(image, exposure, tonemap))
}

/// Saves heights as a 16-bit grey PNG: `low` becomes 0, `high` becomes 65535, the rest is clamped. With `low == high`
/// everything is 0.
pub fn save_png_grey16(path: impl AsRef<Path>, map: &HeightMap, low: f32, high: f32) -> Result<(), MapError> {
    let bytes = encode_png_grey16(map, low, high).map_err(|f| f.in_file(&path))?;
    write_atomic(path, &bytes)
}

/// Saves full 32-bit float channels of one size as an EXR (ZIP, scanlines): pairs of a channel name such as `R`,
/// `depth` or `color.R`, and `width * height` values. Fails when there is no channel, a name is empty or given
/// twice, a length is wrong, or the file cannot be written. NaN and infinities are kept.
pub fn save_exr(path: impl AsRef<Path>, width: u32, height: u32, channels: &[(&str, &[f32])]) -> Result<(), MapError> {
    let bytes = encode_exr(width, height, channels).map_err(|f| f.in_file(&path))?;
    write_atomic(path, &bytes)
}

/// Saves linear radiance as an EXR with channels `R`, `G`, `B`.
pub fn save_exr_rgb(path: impl AsRef<Path>, image: &RgbImage) -> Result<(), MapError> {
    let [r, g, b] = [0, 1, 2].map(|c| image.texels.iter().map(|t| t[c]).collect::<Vec<f32>>());
    save_exr(path, image.width, image.height, &[("R", &r), ("G", &g), ("B", &b)])
}

/// The bytes of [`save_png_srgb8`].
pub fn encode_png_srgb8(image: &Rgb8Image) -> Result<Vec<u8>, MapFault> {
    encode_png(image.texels.as_flattened(), image.width, image.height, ExtendedColorType::Rgb8)
}

/// The bytes of [`save_png_grey16`].
pub fn encode_png_grey16(map: &HeightMap, low: f32, high: f32) -> Result<Vec<u8>, MapFault> {
    let scale = if high > low { 65535.0 / (f64::from(high) - f64::from(low)) } else { 0.0 };
    // The float-to-integer cast saturates.
    let quantise = |h: f32| ((f64::from(h) - f64::from(low)) * scale).round() as u16;
    let samples: Vec<u8> = map.texels.iter().flat_map(|&h| quantise(h).to_ne_bytes()).collect();
    encode_png(&samples, map.width, map.height, ExtendedColorType::L16)
}

pub(super) fn encode_png(
    samples: &[u8],
    width: u32,
    height: u32,
    color: ExtendedColorType,
) -> Result<Vec<u8>, MapFault> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Adaptive)
        .write_image(samples, width, height, color)
        .map_err(|error| MapFault::Unsupported {
            what: one_line(&error),
            remedy: "give an image of at least 1 x 1".into(),
        })?;
    Ok(bytes)
}

/// The bytes of [`save_exr`].
pub fn encode_exr(width: u32, height: u32, channels: &[(&str, &[f32])]) -> Result<Vec<u8>, MapFault> {
    let refuse = |what: String| MapFault::Unsupported { what, remedy: "give named, equally large channels".into() };
    if width == 0 || height == 0 {
        return Err(MapFault::Empty { width: width.into(), height: height.into() });
    }
    if channels.is_empty() {
        return Err(refuse("no channels were given".into()));
    }
    let mut list = SmallVec::new();
    for (index, &(name, values)) in channels.iter().enumerate() {
        if values.len() as u64 != u64::from(width) * u64::from(height) {
            let what = format!("channel {name} has {} values, the image {width} x {height}", values.len());
            return Err(MapFault::SizeMismatch { what });
        }
        if channels[..index].iter().any(|&(other, _)| other == name) {
            return Err(refuse(format!("channel {name} was given twice")));
        }
        let text = Text::new_or_none(name).filter(|_| !name.is_empty());
        let text = text.ok_or_else(|| refuse(format!("`{}` is no channel name", name.escape_debug())))?;
        list.push(AnyChannel::new(text, FlatSamples::F32(values.to_vec())));
    }
    // Increasing lines and one thread: the same input gives the same bytes.
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let size = Vec2(width as usize, height as usize);
    let layer = Layer::new(size, LayerAttributes::default(), encoding, AnyChannels::sort(list));
    let mut cursor = Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().non_parallel().to_buffered(&mut cursor);
    written.map_err(|error| refuse(one_line(&error)))?;
    Ok(cursor.into_inner())
}
