//! Atomic file writes: a temporary file beside the target is renamed into place. A killed or failed run leaves the old file or
//! the new one.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use super::{MapError, MapFault};

const PART: &str = ".part";

/// Writes `bytes` to `path` atomically: into a temporary file in the same folder, synced, then renamed over `path`.
///
/// # Errors
/// Fails if the folder or the disk cannot be written. The temporary file is then removed and an existing `path` stays
/// unchanged.
pub fn write_atomic(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), MapError> {
    NewFile::create(path)?.write(bytes)
}

/// A temporary file beside its target, renamed over the target by [`NewFile::finish`]. Dropping this value earlier removes the
/// file and keeps the old target. A file lock distinguishes the file from files of killed processes.
#[derive(Debug)]
pub struct NewFile {
    /// The temporary file, open for writing.
    pub file: File,
    beside: PathBuf,
    target: PathBuf,
    finished: bool,
}

impl NewFile {
    /// Creates the temporary file, so that an unwritable folder is detected before any work.
    ///
    /// # Errors
    /// Fails if the folder of `target` is not writable, or `target` is a folder.
    pub fn create(target: impl AsRef<Path>) -> Result<Self, MapError> {
        let target = target.as_ref().to_path_buf();
        let refused = |doing, source| MapFault::io(doing)(source).in_file(&target);
        if target.is_dir() {
            return Err(refused("cannot be written", std::io::ErrorKind::IsADirectory.into()));
        }
        loop {
            let beside = beside(&target);
            let file = File::options().read(true).write(true).create_new(true).open(&beside);
            let file = file.map_err(|e| refused("cannot be written: its folder refuses a new file", e))?;
            // If file locks are unsupported, `remove_abandoned` removes no files.
            let locked = file.lock().is_ok();
            // Another process may have removed the file as abandoned before the lock.
            if !locked || beside.exists() {
                return Ok(Self { file, beside, target, finished: false });
            }
        }
    }

    /// Path of the finished file.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Writes the whole content and finishes the file.
    ///
    /// # Errors
    /// Fails if the file or the folder cannot be written.
    pub fn write(mut self, bytes: &[u8]) -> Result<(), MapError> {
        let written = self.file.write_all(bytes).map_err(MapFault::io("cannot be written"));
        written.map_err(|fault| fault.in_file(&self.target))?;
        self.finish()
    }

    /// Syncs the file and renames it.
    ///
    /// # Errors
    /// Fails if the file or the folder cannot be written.
    pub fn finish(mut self) -> Result<(), MapError> {
        let fault = |doing, source| MapFault::io(doing)(source).in_file(&self.target);
        self.file.sync_all().map_err(|e| fault("cannot be written to disk", e))?;
        fs::rename(&self.beside, &self.target).map_err(|e| fault("cannot be replaced", e))?;
        self.finished = true;
        Ok(())
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        if !self.finished {
            // Only the first failure is reported.
            let _ = fs::remove_file(&self.beside);
        }
    }
}

/// Returns a name in the same folder that no other process or thread uses.
fn beside(path: &Path) -> PathBuf {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let unique = COUNT.fetch_add(1, Ordering::Relaxed);
    path.with_file_name(format!(".{name}.{}-{unique}{PART}", std::process::id()))
}

/// Returns the target name of a temporary file with this name.
fn target_of(part: &str) -> Option<&str> {
    let (target, unique) = part.strip_prefix('.')?.strip_suffix(PART)?.rsplit_once('.')?;
    let (process, count) = unique.split_once('-')?;
    let number = |text: &str| !text.is_empty() && text.bytes().all(|digit| digit.is_ascii_digit());
    (number(process) && number(count)).then_some(target)
}

/// Removes temporary files of `targets` that killed processes left behind. Keeps files that a running process has locked or
/// that cannot be removed.
pub fn remove_abandoned<'a>(targets: impl IntoIterator<Item = &'a Path>) {
    let targets: BTreeSet<&Path> = targets.into_iter().collect();
    let folders: BTreeSet<&Path> = targets.iter().filter_map(|target| target.parent()).collect();
    for folder in folders {
        let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        for entry in fs::read_dir(here).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let target = name.to_str().and_then(target_of).map(|target| folder.join(OsStr::new(target)));
            if !target.is_some_and(|target| targets.contains(target.as_path())) {
                continue;
            }
            let part = entry.path();
            // Opening a pipe would block.
            let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
            let left = is_file && File::options().write(true).open(&part).is_ok_and(|file| file.try_lock().is_ok());
            if left {
                let _ = fs::remove_file(&part);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leftovers_of_killed_processes_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let others =
            ["a.png", ".a.png.part", ".a.png.12.part", ".b.png.12-0.part", "a.png.12-0.part", ".a.png.x-0.part"];
        for name in others.iter().chain(&[".a.png.12-0.part", ".a.png.999999-17.part"]) {
            fs::write(at(name), "part").unwrap();
        }
        let living = NewFile::create(at("a.png")).unwrap();
        remove_abandoned([at("a.png").as_path(), &at("missing/c.png")]);
        let mut left: Vec<_> =
            fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        left.sort();
        let mut expected: Vec<String> = others.map(str::to_owned).to_vec();
        expected.push(living.beside.file_name().unwrap().to_str().unwrap().to_owned());
        expected.sort();
        assert_eq!(left, expected);
        living.finish().unwrap();
        assert_eq!(fs::read(at("a.png")).unwrap(), b"");
    }

    #[test]
    fn folder_as_target_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let fault = NewFile::create(folder.path()).unwrap_err().to_string();
        assert!(fault.contains("directory"), "{fault}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
