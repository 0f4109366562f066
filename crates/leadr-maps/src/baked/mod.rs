//! Reader for baked maps in KTX2 or EXR files. Sizes in the header are checked against the file length.

mod exr;
mod keys;
mod ktx2;
mod map;

pub use map::{BakedLevel, BakedMap, HeightUnit};

use std::io::BufReader;
use std::path::Path;

use super::guard::guarded;
use super::udim::Tiles;
use super::{ImageFormat, MapError, MapFault, exr_read, ktx2_read, limits, reads};

/// Whether `leadr bake` wrote the file. True for KTX2 and EXR files with a kind in their header.
///
/// # Errors
/// Fails if the file cannot be read.
pub fn is_baked(path: impl AsRef<Path>) -> Result<bool, MapError> {
    // UDIM tiles are pictures.
    if Tiles::find(path.as_ref())?.is_some() {
        return Ok(false);
    }
    let start = limits::open(path.as_ref()).and_then(|(file, _)| limits::first_bytes(&file, 1 << 16));
    let start = start.map_err(|fault| fault.in_file(path.as_ref()))?;
    let is_kind = matches!(ImageFormat::of(&start), Some(ImageFormat::Ktx2 | ImageFormat::Exr));
    Ok(is_kind && ktx2_read::is_baked(&start))
}

impl BakedMap {
    /// Reads a file that `leadr bake` wrote.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is damaged, is not a baked map, or holds a number that is not finite. The error
    /// gives the position of the number.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, MapError> {
        let path = path.as_ref();
        let read = || {
            let (file, length) = limits::open(path)?;
            if exr_read::is_exr(&limits::first_bytes(&file, 4)?) {
                return exr::read(&limits::read_file(path)?);
            }
            reads::note_whole(path).map_err(MapFault::io("cannot be read"))?;
            guarded("KTX2", || ktx2::read(BufReader::new(file), length))
        };
        read().map_err(|fault| fault.in_file(path))
    }

    /// Decodes a file in memory, like [`load`](Self::load).
    ///
    /// # Errors
    /// Returns the errors of [`load`](Self::load).
    pub fn decode(bytes: &[u8]) -> Result<Self, MapFault> {
        if exr_read::is_exr(bytes) {
            return exr::read(bytes);
        }
        guarded("KTX2", || ktx2::read(std::io::Cursor::new(bytes), bytes.len() as u64))
    }
}
