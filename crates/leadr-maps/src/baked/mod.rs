//! Baked maps read back, level by level, from KTX2 or EXR, with nothing believed that the file is too short to hold.

mod exr;
mod keys;
mod ktx2;
mod map;

pub use map::{BakedLevel, BakedMap, HeightUnit};

use std::io::BufReader;
use std::path::Path;

use super::guard::guarded;
use super::{MapError, MapFault, exr_read, limits, reads};

/// Whether a file is, by its content, one that `leadr bake` may have written: any KTX2, or an EXR that names a kind.
///
/// # Errors
/// If it cannot be read.
pub fn is_baked(path: impl AsRef<Path>) -> Result<bool, MapError> {
    // An EXR says it in its header.
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
    /// If it cannot be read, is damaged, is a picture of another kind, or holds a number that is not finite (its place is named).
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

    /// Reads it from memory; as [`load`](Self::load).
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn decode(bytes: &[u8]) -> Result<Self, MapFault> {
        if exr_read::is_exr(bytes) {
            return exr::read(bytes);
        }
        guarded("KTX2", || ktx2::read(std::io::Cursor::new(bytes), bytes.len() as u64))
    }
}
