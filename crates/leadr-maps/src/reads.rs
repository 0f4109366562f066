//! Records of the files that were read, with their checksums.
//!
//! Every reader of untrusted files uses [`limits`](super::limits), which records each file here. Records cover all threads,
//! since images of a model are read in parallel.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::checksum::checksum;

type Record = Arc<Mutex<Vec<FileRead>>>;

/// The records in progress, which all threads of the process share.
static OPEN: Mutex<Vec<Record>> = Mutex::new(Vec::new());

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FileRead {
    /// The path of the file.
    pub path: PathBuf,
    /// The checksum of the bytes that were read.
    pub checksum: u64,
}

/// Runs `work`. Returns its result, and a sorted list of the files that any thread read meanwhile.
pub fn recorded<T>(work: impl FnOnce() -> T) -> (T, Vec<FileRead>) {
    /// A guard that closes the record even if `work` panics.
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

/// Adds a read of `bytes` from `path` to all records in progress.
pub(super) fn note(path: &Path, bytes: &[u8]) {
    if !locked(&OPEN).is_empty() {
        add(path, checksum(bytes));
    }
}

/// Records a whole file that is read in parts.
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
