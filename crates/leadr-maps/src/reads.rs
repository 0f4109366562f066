//! Which files were read, and what they said then.
//!
//! All readers of untrusted files go through one door ([`limits`](super::limits)), so whatever a scene is made from is known there,
//! the pictures beside a model included.

use std::cell::RefCell;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::checksum::checksum;

thread_local! {
    /// What this thread has read since it was asked to remember.
    static RECORD: RefCell<Option<Vec<FileRead>>> = const { RefCell::new(None) };
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FileRead {
    /// The file.
    pub path: PathBuf,
    /// A checksum of what was read of it.
    pub checksum: u64,
}

/// Does `work` and tells which files this thread has read for it, sorted.
pub fn recorded<T>(work: impl FnOnce() -> T) -> (T, Vec<FileRead>) {
    let before = RECORD.replace(Some(Vec::new()));
    let result = work();
    let mut read = RECORD.replace(before).unwrap_or_default();
    read.sort();
    read.dedup();
    (result, read)
}

/// Remembers that `bytes` of `path` were read, if somebody asked.
pub(super) fn note(path: &Path, bytes: &[u8]) {
    RECORD.with_borrow_mut(|record| {
        if let Some(record) = record {
            record.push(FileRead { path: path.to_path_buf(), checksum: checksum(bytes) });
        }
    });
}

/// Remembers the whole of a file that is not read at once.
pub(super) fn note_whole(path: &Path) -> std::io::Result<()> {
    if RECORD.with_borrow(Option::is_none) {
        return Ok(());
    }
    let (mut file, mut sum, mut block) = (File::open(path)?, 0, vec![0; 1 << 20]);
    loop {
        let length = file.read(&mut block)?;
        if length == 0 {
            break;
        }
        sum = checksum(&[&block[..length], &u64::to_le_bytes(sum)].concat());
    }
    RECORD.with_borrow_mut(|record| {
        record.get_or_insert_default().push(FileRead { path: path.to_path_buf(), checksum: sum });
    });
    Ok(())
}
