//! Baked maps read back, level by level, from KTX2 or EXR, with nothing believed that the file is too short to hold.

mod exr;
mod keys;
mod ktx2;
mod map;

pub use map::{BakedLevel, BakedMap, HeightUnit};

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use super::guard::guarded;
use super::{MapError, MapFault, exr_read, limits, reads};

/// Whether a file is, by its content, one that `leadr bake` may have written: any KTX2, or an EXR that names a kind.
///
/// # Errors
/// If it cannot be read.
pub fn is_baked(path: impl AsRef<Path>) -> Result<bool, MapError> {
    // An EXR says it in its header.
    let start = open(path.as_ref()).and_then(|(file, _)| start(&file, 1 << 16));
    let start = start.map_err(|fault| fault.in_file(path.as_ref()))?;
    Ok(start.starts_with(&::ktx2::MAGIC) || exr_read::is_exr(&start) && contains(&start, b"leadr.kind\0string\0"))
}

/// A regular file, and its length.
fn open(path: &Path) -> Result<(File, u64), MapFault> {
    let io = |doing| move |source| MapFault::Io { doing, source };
    // Asked before opening: opening a pipe would wait for its writer.
    let metadata = std::fs::metadata(path).map_err(io("cannot be found"))?;
    if !metadata.is_file() {
        return Err(MapFault::NotAFile);
    }
    Ok((File::open(path).map_err(io("cannot be opened"))?, metadata.len()))
}

/// Its first bytes.
fn start(file: &File, most: u64) -> Result<Vec<u8>, MapFault> {
    let mut bytes = Vec::new();
    let read = file.take(most).read_to_end(&mut bytes);
    read.map_err(|source| MapFault::Io { doing: "cannot be read", source })?;
    Ok(bytes)
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
            let (file, length) = open(path)?;
            if exr_read::is_exr(&start(&file, 4)?) {
                return exr::read(&limits::read_file(path)?);
            }
            reads::note_whole(path).map_err(|source| MapFault::Io { doing: "cannot be read", source })?;
            guarded("KTX2", || ktx2::read(&mut BufReader::new(file), length))
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
        guarded("KTX2", || ktx2::read(&mut std::io::Cursor::new(bytes), bytes.len() as u64))
    }
}
