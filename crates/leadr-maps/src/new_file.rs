//! Atomic file writes. A temporary file beside the target is renamed to the target. After a killed or failed run, the target
//! is either the old or the new file.

use std::collections::BTreeSet;
use std::fs::{self, File, Metadata};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{MapError, MapFault};

/// Temporary files are named `.leadr-`, 16 hexadecimal digits, `.part`.
const PREFIX: &str = ".leadr-";
const PART: &str = ".part";

/// Maximum number of symbolic links between a path and its file, as in Linux.
const MOST_LINKS: usize = 40;

/// The unfinished temporary files of this process.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn unfinished() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all unfinished temporary files of this process. Call it before an early end of the process, from any thread: other
/// threads that create or finish a file afterwards wait for the end. A file that is being finished is finished first.
pub fn abandon_all() {
    let parts = unfinished();
    for part in &*parts {
        // The process ends, so nobody could react to a failure.
        let _ = fs::remove_file(part);
    }
    std::mem::forget(parts);
}

/// Runs a short piece of `work` that [`abandon_all`] waits for, such as writing a frame to a pipe.
pub fn undivided<T>(work: impl FnOnce() -> T) -> T {
    let _parts = unfinished();
    work()
}

/// Writes `bytes` to `path` atomically: into a temporary file, synced, then renamed over `path`. Creates missing folders.
/// [`NewFile`] lists the files that are written in place instead.
///
/// # Errors
/// Fails if the folder or the disk cannot be written. The temporary file is then removed, and an existing file at `path`
/// stays unchanged.
pub fn write_atomic(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), MapError> {
    NewFile::create(path)?.write(bytes)
}

/// A temporary file beside its target, renamed over the target by [`NewFile::finish`]. Dropping this value earlier removes the
/// file and keeps the old target. A file lock distinguishes the file from files of killed processes.
///
/// Symbolic links are followed, and a replaced file keeps its permissions. Pipes, devices, files with several names (hard links)
/// and files of other owners cannot be replaced: [`finish`](NewFile::finish) copies the content into them.
#[derive(Debug)]
pub struct NewFile {
    /// The temporary file, open for writing.
    pub file: File,
    part: PathBuf,
    target: PathBuf,
    /// Permissions of the file that is replaced.
    mode: Option<u32>,
}

impl NewFile {
    /// Creates the temporary file, so that an unwritable folder is detected before any work. Missing folders of the target are
    /// created by [`finish`](NewFile::finish); until then, the file is in the nearest folder that exists.
    ///
    /// # Errors
    /// Fails if the folder of `target` is not writable, or `target` is a folder.
    pub fn create(target: impl AsRef<Path>) -> Result<Self, MapError> {
        let target = target.as_ref().to_path_buf();
        let refused = |doing, source| MapFault::io(doing)(source).in_file(&target);
        let there = existing(&target).map_err(|e| refused("cannot be written", e))?;
        if there.as_ref().is_some_and(Metadata::is_dir) {
            return Err(refused("cannot be written", ErrorKind::IsADirectory.into()));
        }
        let is_special = there.as_ref().is_some_and(|there| !there.is_file());
        let folder = if is_special { std::env::temp_dir() } else { nearest_folder(&target) };
        let mode = there.as_ref().and_then(unix::mode);
        loop {
            // The name is random, so that nobody can block it, and short, so that the target may have the longest possible name.
            let part = folder.join(format!("{PREFIX}{:016x}{PART}", RandomState::new().build_hasher().finish()));
            let mut parts = unfinished();
            let file = match unix::new_options(mode.is_some()).open(&part) {
                Err(taken) if taken.kind() == ErrorKind::AlreadyExists => continue,
                file => file.map_err(|e| refused("cannot be written: its folder refuses a new file", e))?,
            };
            // If file locks are unsupported, `remove_abandoned` removes no files.
            let locked = file.lock().is_ok();
            // Another process may have removed the file as abandoned before the lock.
            if !locked || part.exists() {
                parts.insert(part.clone());
                drop(parts);
                let new = Self { file, part, target, mode };
                new.check_kept(there.as_ref())?;
                return Ok(new);
            }
        }
    }

    /// Checks that an existing target that must be kept is writable.
    fn check_kept(&self, there: Option<&Metadata>) -> Result<(), MapError> {
        let Some(there) = there.filter(|there| there.is_file()) else { return Ok(()) };
        if self.must_keep(there).map_err(|e| self.fault("cannot be written", e))? {
            File::options().write(true).open(&self.target).map_err(|e| self.fault("cannot be written", e))?;
        }
        Ok(())
    }

    /// Whether the target is a file that a new file cannot replace.
    fn must_keep(&self, there: &Metadata) -> io::Result<bool> {
        Ok(!there.is_file() || is_open(&self.target) || unix::is_shared(there, &self.file.metadata()?))
    }

    fn fault(&self, doing: &'static str, source: io::Error) -> MapError {
        MapFault::io(doing)(source).in_file(&self.target)
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
        self.file.write_all(bytes).map_err(|e| self.fault("cannot be written", e))?;
        self.finish()
    }

    /// Syncs the file, creates the missing folders of the target, and renames the file or copies it into the target.
    ///
    /// # Errors
    /// Fails if the file or the folder cannot be written.
    pub fn finish(mut self) -> Result<(), MapError> {
        self.file.sync_all().map_err(|e| self.fault("cannot be written to disk", e))?;
        self.put_in_place().map_err(|e| self.fault("cannot be replaced", e))
    }

    fn put_in_place(&mut self) -> io::Result<()> {
        let there = existing(&self.target)?;
        if let Some(there) = there
            && self.must_keep(&there)?
        {
            // A pipe is opened outside of `undivided`, because opening waits for its reader.
            let mut kept = File::options().write(true).truncate(true).open(&self.target)?;
            self.file.rewind()?;
            undivided(|| io::copy(&mut self.file, &mut kept))?;
            return if there.is_file() { kept.sync_all() } else { Ok(()) };
        }
        let file = followed(&self.target);
        if let Some(folder) = file.parent() {
            fs::create_dir_all(folder)?;
        }
        unix::set_mode(&self.file, self.mode)?;
        let mut parts = unfinished();
        fs::rename(&self.part, file)?;
        parts.remove(&self.part);
        Ok(())
    }
}

impl Drop for NewFile {
    fn drop(&mut self) {
        let mut parts = unfinished();
        // `finish` has renamed a file that is no longer listed.
        if parts.remove(&self.part) {
            // Only the first failure is reported.
            let _ = fs::remove_file(&self.part);
        }
    }
}

/// Returns the metadata of the file behind the links of `path`; `None` if there is none.
fn existing(path: &Path) -> io::Result<Option<Metadata>> {
    match fs::metadata(path) {
        Err(fault) if fault.kind() == ErrorKind::NotFound => Ok(None),
        found => found.map(Some),
    }
}

/// Paths on the way from `path` along symbolic links, which may end at a missing file.
fn links(path: &Path) -> impl Iterator<Item = PathBuf> {
    let next = |path: &PathBuf| {
        let to = fs::read_link(path).ok()?;
        Some(path.parent().map_or_else(|| to.clone(), |folder| folder.join(&to)))
    };
    std::iter::successors(Some(path.to_path_buf()), next).take(MOST_LINKS)
}

fn followed(path: &Path) -> PathBuf {
    links(path).last().unwrap_or_default()
}

/// Whether a path names a file that a process has opened, as `/dev/stdout` does. The process keeps that file when its name is
/// replaced.
fn is_open(path: &Path) -> bool {
    cfg!(unix) && links(path).any(|path| path.starts_with("/proc") || path.starts_with("/dev/fd"))
}

/// Returns the existing folder that is nearest above the file of `path`.
fn nearest_folder(path: &Path) -> PathBuf {
    let file = followed(path);
    let mut folders = file.ancestors().skip(1);
    // A folder that cannot be examined exists, and refuses the file.
    let nearest = folders.find(|folder| folder.try_exists().unwrap_or(true)).filter(|f| !f.as_os_str().is_empty());
    nearest.map_or_else(|| PathBuf::from("."), Path::to_path_buf)
}

/// Properties of files that only Unix has.
#[cfg(unix)]
mod unix {
    use std::fs::{File, Metadata, OpenOptions, Permissions};
    use std::io;
    use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt};

    /// Returns the permissions of a regular file.
    pub fn mode(there: &Metadata) -> Option<u32> {
        there.is_file().then(|| there.permissions().mode() & 0o777)
    }

    /// Options that create a file. A `private` file is only for its owner, like the file that it may replace.
    pub fn new_options(private: bool) -> OpenOptions {
        let mut options = File::options();
        options.read(true).write(true).create_new(true).mode(if private { 0o600 } else { 0o666 });
        options
    }

    pub fn set_mode(file: &File, mode: Option<u32>) -> io::Result<()> {
        mode.map_or(Ok(()), |mode| file.set_permissions(Permissions::from_mode(mode)))
    }

    /// Whether a file has several names or another owner than `mine`.
    pub fn is_shared(there: &Metadata, mine: &Metadata) -> bool {
        there.nlink() > 1 || (there.uid(), there.gid()) != (mine.uid(), mine.gid())
    }
}

#[cfg(not(unix))]
mod unix {
    use std::fs::{File, Metadata, OpenOptions};
    use std::io;

    pub fn mode(_: &Metadata) -> Option<u32> {
        None
    }

    pub fn new_options(_: bool) -> OpenOptions {
        let mut options = File::options();
        options.read(true).write(true).create_new(true);
        options
    }

    pub fn set_mode(_: &File, _: Option<u32>) -> io::Result<()> {
        Ok(())
    }

    pub fn is_shared(_: &Metadata, _: &Metadata) -> bool {
        false
    }
}

/// Whether a file name is that of a temporary file.
fn is_part(name: &str) -> bool {
    let digits = name.strip_prefix(PREFIX).and_then(|name| name.strip_suffix(PART));
    digits.is_some_and(|digits| digits.len() == 16 && digits.bytes().all(|digit| digit.is_ascii_hexdigit()))
}

/// Removes temporary files that killed processes left behind in the folder of `target`. Keeps files that a running process has
/// locked or that cannot be removed.
pub fn remove_abandoned(target: &Path) {
    for entry in fs::read_dir(nearest_folder(target)).into_iter().flatten().flatten() {
        if !entry.file_name().to_str().is_some_and(is_part) {
            continue;
        }
        let part = entry.path();
        // Opening a pipe would block, and a link would lead to the file of someone else.
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        let left = is_file && File::options().write(true).open(&part).is_ok_and(|file| file.try_lock().is_ok());
        if left {
            let _ = fs::remove_file(&part);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sorted names in a folder.
    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn leftovers_of_killed_processes_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let others = [".leadr-0123.part", ".leadr-0123456789abcdeg.part", "0123456789abcdef.part", "a.png"];
        for name in others.iter().chain(&[".leadr-0123456789abcdef.part"]) {
            fs::write(at(name), "part").unwrap();
        }
        let living = NewFile::create(at("a.png")).unwrap();
        remove_abandoned(&at("a.png"));
        // The folder of this target is missing, so its temporary files would be in the same folder.
        remove_abandoned(&at("missing/c.png"));
        let mut expected: Vec<String> = others.map(str::to_owned).to_vec();
        expected.push(living.part.file_name().unwrap().to_str().unwrap().to_owned());
        expected.sort();
        assert_eq!(names(folder.path()), expected);
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

    #[test]
    fn folders_are_made_with_their_first_file() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("out/of/a.png");
        drop(NewFile::create(&target).unwrap());
        assert_eq!(names(folder.path()), [""; 0]);
        write_atomic(&target, b"a").unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"a");
        assert_eq!(names(folder.path()), ["out"]);
        let fault = NewFile::create(target.join("b.png")).unwrap_err().to_string();
        assert!(fault.contains("b.png"), "{fault}");
    }

    #[test]
    fn the_longest_names_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join(format!("{}.png", "n".repeat(251)));
        write_atomic(&target, b"a").unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"a");
    }

    #[cfg(unix)]
    #[test]
    fn replaced_files_keep_their_permissions_and_links() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a"), "old and longer").unwrap();
        fs::set_permissions(at("a"), PermissionsExt::from_mode(0o600)).unwrap();
        symlink("a", at("link")).unwrap();
        symlink("none", at("dangling")).unwrap();
        for (name, file) in [("a", "a"), ("link", "a"), ("dangling", "none")] {
            write_atomic(at(name), name.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(at(file)).unwrap(), name);
        }
        assert_eq!(fs::metadata(at("a")).unwrap().mode() & 0o777, 0o600);
        assert!(at("link").is_symlink() && at("dangling").is_symlink());
        fs::hard_link(at("a"), at("twin")).unwrap();
        write_atomic(at("twin"), b"both").unwrap();
        assert_eq!(fs::read_to_string(at("a")).unwrap(), "both");
        assert_eq!(names(folder.path()), ["a", "dangling", "link", "none", "twin"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn pipes_and_devices_are_written_through() {
        use std::os::fd::AsRawFd;
        use std::os::unix::fs::{FileTypeExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (pipe, null) = (folder.path().join("pipe.png"), folder.path().join("null.png"));
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        symlink("/dev/null", &null).unwrap();
        write_atomic(&null, b"nothing").unwrap();
        write_atomic("/dev/null", b"nothing").unwrap();
        let (open, descriptor) = (folder.path().join("open.png"), folder.path().join("descriptor.png"));
        let mut file = File::options().read(true).write(true).create_new(true).open(&open).unwrap();
        symlink(format!("/proc/self/fd/{}", file.as_raw_fd()), &descriptor).unwrap();
        write_atomic(&descriptor, b"through").unwrap();
        assert_eq!(io::read_to_string(&mut file).unwrap(), "through");
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || fs::read(pipe).unwrap()
        });
        write_atomic(&pipe, b"through").unwrap();
        assert_eq!(reader.join().unwrap(), b"through");
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        assert_eq!(names(folder.path()), ["descriptor.png", "null.png", "open.png", "pipe.png"]);
    }
}
