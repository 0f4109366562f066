//! New files, written beside their target and renamed into place, so that a killed or failed run leaves either the old file or the
//! new one.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use super::{MapError, MapFault};

/// What the names of files on their way end with.
const PART: &str = ".part";

/// Writes `bytes` to `path` all or nothing: into a new file in the same folder, synced, then renamed over `path`.
///
/// # Errors
/// If the folder or the disk refuses; then the new file is removed and an old `path` is untouched.
pub fn write_atomic(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), MapError> {
    NewFile::create(path)?.write(bytes)
}

/// A file on its way: written beside its target, and renamed over it when it is finished. Dropped before that, it is removed, and
/// an old file stays as it was. Until then it is locked, which tells it from what a killed process left.
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
    /// If no file can be made in the folder of `target`, or `target` is a folder itself.
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
            // Where files cannot be locked nothing is taken for abandoned either.
            let locked = file.lock().is_ok();
            // Before it was locked, another process may have taken it for abandoned.
            if !locked || beside.exists() {
                return Ok(Self { file, beside, target, finished: false });
            }
        }
    }

    /// What the file will be called.
    pub fn target(&self) -> &Path {
        &self.target
    }

    /// Writes all of the file and finishes it.
    ///
    /// # Errors
    /// If the disk or the folder refuses.
    pub fn write(mut self, bytes: &[u8]) -> Result<(), MapError> {
        let written = self.file.write_all(bytes).map_err(MapFault::io("cannot be written"));
        written.map_err(|fault| fault.in_file(&self.target))?;
        self.finish()
    }

    /// Syncs the file and renames it.
    ///
    /// # Errors
    /// If the disk or the folder refuses.
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
    path.with_file_name(format!(".{name}.{}-{unique}{PART}", std::process::id()))
}

/// The name of the file that would have become of one with this name.
fn target_of(part: &str) -> Option<&str> {
    let (target, unique) = part.strip_prefix('.')?.strip_suffix(PART)?.rsplit_once('.')?;
    let (process, count) = unique.split_once('-')?;
    let number = |text: &str| !text.is_empty() && text.bytes().all(|digit| digit.is_ascii_digit());
    (number(process) && number(count)).then_some(target)
}

/// Removes what killed processes left of `targets`. Files that a living process writes stay, and so does whatever cannot be removed.
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
            // Opened only if it is a file: opening a pipe would wait.
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
    fn what_a_killed_process_left_goes_and_nothing_else() {
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
    fn a_folder_is_no_target() {
        let folder = tempfile::tempdir().unwrap();
        let fault = NewFile::create(folder.path()).unwrap_err().to_string();
        assert!(fault.contains("directory"), "{fault}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
