//! Reader for baked maps in KTX2 or EXR files. Sizes in the header are checked against the file length.

mod exr;
mod keys;
mod ktx2;
mod map;

pub use map::{BakedLevel, BakedMap, HeightUnit};

use std::io::BufReader;
use std::path::Path;

use super::guard::guarded;
use super::{MapError, MapFault, exr_read, limits, reads};

/// Whether `leadr bake` may have written the file. True for any KTX2 file, and for an EXR file with a kind in its header.
///
/// # Errors
/// Fails if the file cannot be read.
pub fn is_baked(path: impl AsRef<Path>) -> Result<bool, MapError> {
    // An EXR file stores the kind in its header.
    let start = limits::open(path.as_ref()).and_then(|(file, _)| limits::first_bytes(&file, 1 << 16));
    let start = start.map_err(|fault| fault.in_file(path.as_ref()))?;
    Ok(start.starts_with(&::ktx2::MAGIC) || exr_read::is_exr(&start) && contains(&start, b"leadr.kind\0string\0"))
}

fn contains(bytes: &[u8], wanted: &[u8]) -> bool {
    bytes.windows(wanted.len()).any(|window| window == wanted)
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
