//! Which files were read, and what they said then.
//!
//! All readers of untrusted files use [`limits`](super::limits), which notes each read here. The record does not depend on the
//! thread: a model's images are read on all cores.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::checksum::checksum;

type Record = Arc<Mutex<Vec<FileRead>>>;

/// The records that are open, of the whole process: a scene is read by many threads.
static OPEN: Mutex<Vec<Record>> = Mutex::new(Vec::new());

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FileRead {
    /// The file.
    pub path: PathBuf,
    /// A checksum of what was read of it.
    pub checksum: u64,
}

/// Does `work` and returns the files that were read meanwhile, by any thread, sorted.
pub fn recorded<T>(work: impl FnOnce() -> T) -> (T, Vec<FileRead>) {
    /// Closes the record, also if `work` panics.
    struct Close(Record);
    impl Drop for Close {
        fn drop(&mut self) {
            locked(&OPEN).retain(|open| !Arc::ptr_eq(open, &self.0));
        }
    }
    let record = Record::default();
    locked(&OPEN).push(record.clone());
    let close = Close(record.clone());
    let result = work();
    drop(close);
    let mut read = std::mem::take(&mut *locked(&record));
    read.sort();
    read.dedup();
    (result, read)
}

/// Notes in all open records that `bytes` of `path` were read.
pub(super) fn note(path: &Path, bytes: &[u8]) {
    if !locked(&OPEN).is_empty() {
        add(path, checksum(bytes));
    }
}

/// Notes the whole of a file that is not read at once.
pub(super) fn note_whole(path: &Path) -> std::io::Result<()> {
    if locked(&OPEN).is_empty() {
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
    add(path, sum);
    Ok(())
}

fn add(path: &Path, checksum: u64) {
    for record in &*locked(&OPEN) {
        locked(record).push(FileRead { path: path.to_path_buf(), checksum });
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
