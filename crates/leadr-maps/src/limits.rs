//! Limits on the resources that an untrusted file can request.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use super::{MapFault, reads};

/// The maximum number of texels in one image: 16384 x 16384.
pub const MAX_TEXELS: u64 = 1 << 28;
/// The maximum width or height in texels.
pub const MAX_SIDE: u64 = 1 << 16;
/// The maximum size in bytes of one decoded image, with all stored channels.
pub const MAX_DECODED_BYTES: u64 = 2 << 30;
/// Maximum size of all images of a model or a material together in bytes, encoded and decoded.
pub const MAX_IMAGE_BYTES: u64 = 4 << 30;
/// Maximum size of a file that is read, in bytes.
pub const MAX_FILE_BYTES: u64 = 1 << 30;
/// The number of decoded bytes that any file may declare, regardless of its length.
const FREE_DECODED_BYTES: u64 = 64 << 20;
/// The number of further decoded bytes that are allowed per byte of the file. Deflate, the strongest common coder, reaches
/// 1032.
const MAX_EXPANSION: u64 = 1100;
/// The largest accepted height. With this limit, slopes over 16384 texels can still be squared in 32 bits.
pub const MAX_HEIGHT: f32 = 1e12;
/// The largest accepted radiance. Sums and products of three colours stay finite in 32 bits.
pub const MAX_RADIANCE: f32 = 1e18;
/// The lowest negative radiance that counts as rounding of a lossy codec or resampling filter and is read as 0.
pub const NEGATIVE_NOISE: f32 = -0.01;

/// The maximum ratio of the sum of negative radiance to the sum of positive radiance. Up to the maximum ratio, values below
/// [`NEGATIVE_NOISE`] are also read as 0.
pub const NEGATIVE_SHARE: f64 = 0.01;

/// Checks the image size in a header before memory is allocated.
///
/// `bytes_per_texel` counts every channel that the decoder decompresses. `file_bytes` is the length of the file.
pub(crate) fn check_size(width: u64, height: u64, bytes_per_texel: u64, file_bytes: usize) -> Result<(), MapFault> {
    if width == 0 || height == 0 {
        return Err(MapFault::Empty { width, height });
    }
    let texels = width.checked_mul(height).filter(|&n| n <= MAX_TEXELS && width <= MAX_SIDE && height <= MAX_SIDE);
    let Some(texels) = texels else {
        return Err(MapFault::too_large(format!(
            "{width} x {height} texels; the limit is 16384 x 16384 texels in total and {MAX_SIDE} per side"
        )));
    };
    let bytes = texels.saturating_mul(bytes_per_texel);
    let [decoded, most, file] = [bytes, MAX_DECODED_BYTES, file_bytes as u64].map(format_bytes);
    if bytes > MAX_DECODED_BYTES {
        return Err(MapFault::too_large(format!("{decoded} when decoded; the limit is {most}")));
    }
    if bytes > FREE_DECODED_BYTES.saturating_add(MAX_EXPANSION.saturating_mul(file_bytes as u64)) {
        let what = format!("the header claims {decoded} when decoded, and the file has only {file}");
        return Err(MapFault::too_large(what));
    }
    Ok(())
}

/// Remaining memory for images that are kept together, shared by all threads. It is reserved before images are decoded.
#[derive(Debug)]
pub struct ImageBudget(AtomicU64);

impl Default for ImageBudget {
    /// Creates a budget of [`MAX_IMAGE_BYTES`].
    fn default() -> Self {
        Self(AtomicU64::new(MAX_IMAGE_BYTES))
    }
}

impl ImageBudget {
    /// Reserves memory.
    ///
    /// # Errors
    /// Returns [`MapFault::TooLarge`] if less is left.
    pub fn take(&self, bytes: u64) -> Result<(), MapFault> {
        let taken = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(bytes));
        let most = format_bytes(MAX_IMAGE_BYTES);
        taken
            .map(drop)
            .map_err(|_| MapFault::too_large(format!("with the images before it, it needs more than {most}")))
    }
}

/// Formats a byte count with a unit, such as "1.5 GiB".
pub fn format_bytes(bytes: u64) -> String {
    const UNITS: [(u64, &str); 3] = [(1 << 30, "GiB"), (1 << 20, "MiB"), (1 << 10, "KiB")];
    match UNITS.iter().find(|(unit, _)| bytes >= *unit) {
        Some((unit, name)) if bytes.is_multiple_of(*unit) => format!("{} {name}", bytes / unit),
        Some((unit, name)) => format!("{:.1} {name}", bytes as f64 / *unit as f64),
        None => format!("{bytes} bytes"),
    }
}

/// Returns a zeroed buffer. If memory runs out, returns an error instead of aborting.
pub fn zeroed<T: bytemuck::Zeroable + Copy>(len: usize) -> Result<Vec<T>, MapFault> {
    let mut buffer = Vec::new();
    buffer.try_reserve_exact(len).map_err(|_| {
        MapFault::too_large(format!("no memory for {}", format_bytes(len.saturating_mul(size_of::<T>()) as u64)))
    })?;
    buffer.resize(len, T::zeroed());
    Ok(buffer)
}

/// Reads a whole regular file of at most [`MAX_FILE_BYTES`].
pub fn read_file(path: &Path) -> Result<Vec<u8>, MapFault> {
    read_start(path, MAX_FILE_BYTES)
}

/// Reads up to `most` bytes from the start of a regular file of at most [`MAX_FILE_BYTES`].
pub fn read_start(path: &Path, most: u64) -> Result<Vec<u8>, MapFault> {
    let (file, length) = open(path)?;
    if length > MAX_FILE_BYTES {
        let [length, most] = [length, MAX_FILE_BYTES].map(format_bytes);
        return Err(MapFault::too_large(format!("{length}; the limit is {most}")));
    }
    let bytes = first_bytes(&file, most.min(MAX_FILE_BYTES))?;
    reads::note(path, &bytes);
    Ok(bytes)
}

/// Opens a regular file and returns its length in bytes.
pub(crate) fn open(path: &Path) -> Result<(File, u64), MapFault> {
    // The file type is checked first, because opening a pipe would wait for its writer.
    let metadata = std::fs::metadata(path).map_err(MapFault::io("cannot be found"))?;
    if !metadata.is_file() {
        return Err(MapFault::NotAFile);
    }
    Ok((File::open(path).map_err(MapFault::io("cannot be opened"))?, metadata.len()))
}

/// Reads up to `most` bytes of a file. Refuses the pointers that Git LFS leaves in place of files.
pub(crate) fn first_bytes(file: &File, most: u64) -> Result<Vec<u8>, MapFault> {
    let mut bytes = Vec::new();
    file.take(most).read_to_end(&mut bytes).map_err(MapFault::io("cannot be read"))?;
    if bytes.starts_with(b"version https://git-lfs") || bytes.starts_with(b"version https://hawser") {
        let what = "it is a pointer of Git LFS, and the file itself was not downloaded";
        return Err(MapFault::unsupported(what, "run `git lfs pull` in its repository"));
    }
    Ok(bytes)
}
