//! A cache folder for results computed from maps. Files are written atomically and read as untrusted input. The total size
//! of the files is limited.
//!
//! A file is little endian and contains a magic number, the key, a checksum of the content, and the content. The key depends
//! on all inputs, including the program text. A file with a different key counts as missing.

use std::convert::Infallible;
use std::fmt::Display;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use bytemuck::Pod;
use rayon::prelude::*;

use super::checksum::checksum;
use super::new_file::{NewFile, remove_abandoned};
use super::{MapError, MapFault, limits};
use crate::shown::shown_path;

const MAGIC: u64 = u64::from_le_bytes(*b"LEADRBAK");
/// The size of the header in bytes.
const HEADER: usize = 3 * 8;
/// The maximum total size in bytes of the files that are named by key. Beyond this size, the least recently used files are
/// removed.
const MOST_BYTES: u64 = 1 << 30;

fn damaged(path: &Path, fault: impl Display) -> String {
    format!("cache file {} is damaged ({fault}); it will be replaced", shown_path(path))
}

/// A cache folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapCache {
    folder: PathBuf,
}

fn variable(name: &str) -> Option<PathBuf> {
    std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from)
}

/// A folder of the user in which programs store files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UserFolder {
    /// Files that can be made again.
    Cache,
    /// Settings.
    Settings,
}

/// Returns the folder `leadr` in a folder of the user. It is in `$XDG_CACHE_HOME` or `$XDG_CONFIG_HOME` if set, and else where the
/// platform has such files: `%LOCALAPPDATA%` and `%APPDATA%` on Windows, `~/Library/Caches` and `~/Library/Application Support` on macOS,
/// `~/.cache` and `~/.config` elsewhere. `None` if the variables are not set.
pub fn user_folder(folder: UserFolder) -> Option<PathBuf> {
    folder_on(std::env::consts::OS, folder, variable)
}

fn folder_on(system: &str, folder: UserFolder, variable: impl Fn(&str) -> Option<PathBuf>) -> Option<PathBuf> {
    let (xdg, windows, mac, usual) = match folder {
        UserFolder::Cache => ("XDG_CACHE_HOME", "LOCALAPPDATA", "Library/Caches", ".cache"),
        UserFolder::Settings => ("XDG_CONFIG_HOME", "APPDATA", "Library/Application Support", ".config"),
    };
    let in_home = |path: &str| variable("HOME").map(|home| home.join(path));
    let parent = variable(xdg).or_else(|| match system {
        "windows" => variable(windows),
        "macos" => in_home(mac),
        _ => in_home(usual),
    })?;
    Some(parent.join("leadr"))
}

impl MapCache {
    /// Creates a cache in `folder`. The folder itself is created by the first write.
    pub fn in_folder(folder: impl Into<PathBuf>) -> Self {
        Self { folder: folder.into() }
    }

    /// Returns the user's cache: `$LEADR_CACHE`, else the cache of [`user_folder`]. `None` if no variable is set.
    pub fn of_user() -> Option<Self> {
        variable("LEADR_CACHE").or_else(|| user_folder(UserFolder::Cache)).map(Self::in_folder)
    }

    /// Returns the folder of the cache.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name).with_extension("bin")
    }

    /// Reads the file stored as `name` under `key`, including its header, with at most `most` bytes of content. Returns
    /// `None` if the file is missing or has a different key.
    ///
    /// # Errors
    /// Returns a warning text if the file exists but cannot be read or is damaged.
    fn read(&self, name: &str, key: u64, most: u64) -> Result<Option<Vec<u8>>, String> {
        let path = &self.path(name);
        let (file, length) = match limits::open(path) {
            Ok(opened) => opened,
            Err(MapFault::Io { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(MapFault::NotAFile) => return Err(damaged(path, "it is not a regular file")),
            Err(fault) => return Err(format!("cache file {}: {fault}", shown_path(path))),
        };
        if length > most.saturating_add(HEADER as u64) {
            return Err(damaged(path, "it is too long"));
        }
        let bytes = read_side_by_side(&file, length as usize).map_err(|error| damaged(path, error))?;
        let (header, content) = bytes.split_at_checked(HEADER).ok_or_else(|| damaged(path, "it is too short"))?;
        let [magic, stored, sum]: [u64; 3] = bytemuck::pod_read_unaligned(header);
        if magic != MAGIC {
            return Err(damaged(path, "it has an unknown format"));
        }
        if stored != key {
            return Ok(None);
        }
        if checksum(content) != sum {
            return Err(damaged(path, "its checksum differs"));
        }
        // The timestamp only orders the files for eviction.
        let _ = file.set_modified(SystemTime::now());
        Ok(Some(bytes))
    }

    /// Stores `content` atomically as `name` under `key`.
    ///
    /// # Errors
    /// Fails if the folder cannot be created or written.
    fn write(&self, name: &str, key: u64, content: &[u8]) -> Result<(), MapError> {
        let path = self.path(name);
        let fault = |source| MapFault::io("cannot be written")(source).in_file(&path);
        remove_abandoned(&path);
        // A link in the place of the file would lead to the file of someone else.
        let _ = std::fs::remove_file(&path);
        let mut new = NewFile::create(&path)?;
        new.file.write_all(bytemuck::bytes_of(&[MAGIC, key, checksum(content)])).map_err(fault)?;
        new.file.write_all(content).map_err(fault)?;
        new.finish()
    }

    /// Whether a file of this `kind` and key exists. The file may be damaged, which only
    /// [`load_or_make`](Self::load_or_make) detects.
    pub fn holds(&self, kind: &str, key: u64) -> bool {
        self.path(&named(kind, key)).is_file()
    }

    /// Returns the stored value of this `kind` and key. If no value is stored, calls `make` and stores the result. `read`
    /// decodes the content, which has at most `most` bytes, or returns a description of its defect. A damaged or unusable
    /// cache only logs a warning. Results of more than half a gibibyte are not stored.
    ///
    /// # Errors
    /// Returns the errors of `make`.
    pub fn load_or_make<T, E>(
        &self,
        kind: &str,
        key: u64,
        most: u64,
        read: impl FnOnce(&[u8]) -> Result<T, &'static str>,
        make: impl FnOnce() -> Result<(T, Vec<u8>), E>,
    ) -> Result<T, E> {
        let name = named(kind, key);
        match self.read(&name, key, most) {
            Ok(Some(bytes)) => match read(&bytes[HEADER..]) {
                Ok(value) => return Ok(value),
                Err(fault) => tracing::warn!("{}", damaged(&self.path(&name), fault)),
            },
            Ok(None) => {}
            Err(sentence) => tracing::warn!("{sentence}"),
        }
        let (value, content) = make()?;
        if content.len() as u64 > MOST_BYTES / 2 {
            // Storing it would remove most of the other files.
            return Ok(value);
        }
        match self.write(&name, key, &content) {
            Ok(()) => self.trim(&self.path(&name), MOST_BYTES),
            Err(error) => tracing::warn!("cache file {error}"),
        }
        Ok(value)
    }

    /// Removes the least recently used files that [`load_or_make`](Self::load_or_make) stored, until at most `most` bytes
    /// remain. The file `kept` is never removed.
    fn trim(&self, kept: &Path, most: u64) {
        let Ok(entries) = std::fs::read_dir(&self.folder) else { return };
        let mut files: Vec<(SystemTime, u64, PathBuf)> = entries
            .flatten()
            .filter(|entry| entry.file_name().to_str().is_some_and(named_by_key))
            .filter_map(|entry| {
                let about = entry.metadata().ok().filter(std::fs::Metadata::is_file)?;
                Some((about.modified().ok()?, about.len(), entry.path()))
            })
            .collect();
        files.sort();
        let mut total: u64 = files.iter().map(|(_, length, _)| length).sum();
        for (_, length, path) in files.iter().filter(|(_, _, path)| path != kept) {
            if total <= most {
                break;
            }
            // Another process may already have removed the file.
            let _ = std::fs::remove_file(path);
            total -= length;
        }
    }
}

fn named(kind: &str, key: u64) -> String {
    format!("{kind}-{key:016x}")
}

/// Appends values to the content of a cache file.
pub fn put<T: Pod>(content: &mut Vec<u8>, values: &[T]) {
    content.extend_from_slice(bytemuck::cast_slice(values));
}

/// Removes `count` values from the front of a cache file's content and returns the values.
///
/// # Errors
/// Fails if the content holds fewer values.
pub fn take<T: Pod>(content: &mut &[u8], count: usize) -> Result<Vec<T>, &'static str> {
    let length = count.checked_mul(size_of::<T>()).ok_or("a count is too large")?;
    let (head, rest) = content.split_at_checked(length).ok_or("it is too short")?;
    *content = rest;
    let mut values = vec![T::zeroed(); count];
    // The copy is parallel because first-touch page faults cost more than the copy.
    let pieces = bytemuck::cast_slice_mut::<T, u8>(&mut values).par_chunks_mut(PIECE).zip(head.par_chunks(PIECE));
    pieces.for_each(|(to, from)| to.copy_from_slice(from));
    Ok(values)
}

/// The number of bytes that a thread reads or copies at a time.
const PIECE: usize = 4 << 20;

/// Reads the first `length` bytes of a file in parallel on all threads.
#[cfg(unix)]
fn read_side_by_side(file: &File, length: usize) -> std::io::Result<Vec<u8>> {
    use std::os::unix::fs::FileExt;
    let mut bytes = vec![0; length];
    let pieces = bytes.par_chunks_mut(PIECE).enumerate();
    pieces.map(|(i, piece)| file.read_exact_at(piece, (i * PIECE) as u64)).collect::<std::io::Result<()>>()?;
    Ok(bytes)
}

#[cfg(not(unix))]
fn read_side_by_side(mut file: &File, length: usize) -> std::io::Result<Vec<u8>> {
    let mut bytes = vec![0; length];
    std::io::Read::read_exact(&mut file, &mut bytes)?;
    Ok(bytes)
}

/// Checks that the whole content of a cache file was read.
///
/// # Errors
/// Fails if bytes remain.
pub fn expect_end(content: &[u8]) -> Result<(), &'static str> {
    if content.is_empty() { Ok(()) } else { Err("it is too long") }
}

/// Checks all values of the content of a cache file.
///
/// # Errors
/// Fails if a value is not `valid`.
pub fn expect_all<T: Sync>(values: &[T], valid: impl Fn(&T) -> bool + Sync) -> Result<(), &'static str> {
    if values.par_iter().with_min_len(PIECE / size_of::<T>()).all(&valid) {
        Ok(())
    } else {
        Err("a value is out of range")
    }
}

/// Returns `count` values from `make` or from the user's cache. The cache key covers the text of the programs that compute
/// them. Values that are not `valid` are not taken from the cache.
pub fn cached<T: Pod + Sync>(
    kind: &str,
    programs: &[&str],
    count: usize,
    valid: impl Fn(&T) -> bool + Sync,
    make: impl FnOnce() -> Vec<T>,
) -> Vec<T> {
    match MapCache::of_user() {
        Some(cache) => cache.cached(kind, programs, count, valid, make),
        None => make(),
    }
}

impl MapCache {
    /// Like [`cached`], but with this cache.
    fn cached<T: Pod + Sync>(
        &self,
        kind: &str,
        programs: &[&str],
        count: usize,
        valid: impl Fn(&T) -> bool + Sync,
        make: impl FnOnce() -> Vec<T>,
    ) -> Vec<T> {
        let sums: Vec<u64> = programs.iter().map(|text| checksum(text.as_bytes())).chain([count as u64]).collect();
        let read = |mut content: &[u8]| {
            let values = take(&mut content, count)?;
            expect_end(content)?;
            expect_all(&values, &valid)?;
            Ok(values)
        };
        let make = || {
            let values = make();
            debug_assert_eq!(expect_all(&values, &valid), Ok(()), "{kind}");
            let content = bytemuck::cast_slice(&values).to_vec();
            Ok::<_, Infallible>((values, content))
        };
        let most = (count * size_of::<T>()) as u64;
        let Ok(values) = self.load_or_make(kind, checksum(bytemuck::cast_slice(&sums)), most, read, make);
        values
    }
}

/// Whether a file name has the form that [`MapCache::load_or_make`] uses: `KIND-`, 16 digits, `.bin`.
fn named_by_key(name: &str) -> bool {
    let key = name.strip_suffix(".bin").and_then(|stem| stem.rsplit_once('-')).map(|(_, key)| key);
    key.is_some_and(|key| key.len() == 16 && key.bytes().all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_follow_the_platform() {
        let folder = |system: &str, folder, set: &[&str]| {
            let variable = |name: &str| set.contains(&name).then(|| PathBuf::from(format!("/{name}")));
            folder_on(system, folder, variable).map(|path| path.to_str().unwrap().replace('\\', "/"))
        };
        use UserFolder::{Cache, Settings};
        for (system, which, set, wanted) in [
            ("linux", Cache, &["HOME"][..], Some("/HOME/.cache/leadr")),
            ("linux", Settings, &["HOME", "XDG_CONFIG_HOME"], Some("/XDG_CONFIG_HOME/leadr")),
            ("macos", Cache, &["HOME"], Some("/HOME/Library/Caches/leadr")),
            ("macos", Settings, &["HOME"], Some("/HOME/Library/Application Support/leadr")),
            ("windows", Cache, &["LOCALAPPDATA", "APPDATA"], Some("/LOCALAPPDATA/leadr")),
            ("windows", Settings, &["LOCALAPPDATA", "APPDATA"], Some("/APPDATA/leadr")),
            ("windows", Cache, &["HOME"], None),
            ("linux", Cache, &[], None),
        ] {
            assert_eq!(folder(system, which, set).as_deref(), wanted, "{system} {which:?} {set:?}");
        }
    }

    fn in_temporary_folder() -> (tempfile::TempDir, MapCache) {
        let folder = tempfile::tempdir().unwrap();
        let cache = MapCache::in_folder(folder.path().join("deeper"));
        (folder, cache)
    }

    #[test]
    fn contents_end_with_their_values() {
        let mut content = Vec::new();
        put(&mut content, &[1u16, 2]);
        put(&mut content, &[0.5f32]);
        let left = &mut &content[..];
        assert_eq!(take::<u16>(left, 2), Ok(vec![1, 2]));
        assert_eq!(expect_end(left), Err("it is too long"));
        assert_eq!(take::<f32>(left, 2), Err("it is too short"));
        assert_eq!(take::<f32>(left, 1), Ok(vec![0.5]));
        assert_eq!(expect_end(left), Ok(()));
        assert_eq!(take::<u16>(left, usize::MAX), Err("a count is too large"));
    }

    #[test]
    fn written_text_reads_back() {
        let (_folder, cache) = in_temporary_folder();
        assert!(cache.read("a", 7, 100).unwrap().is_none());
        cache.write("a", 7, b"content").unwrap();
        assert_eq!(cache.read("a", 7, 100).unwrap().unwrap()[HEADER..], *b"content");
        assert!(cache.read("a", 8, 100).unwrap().is_none(), "another key");
        let files = std::fs::read_dir(cache.path("a").parent().unwrap()).unwrap().count();
        assert_eq!(files, 1, "nothing temporary is left");
    }

    #[test]
    fn every_kind_of_damage_is_detected() {
        let (_folder, cache) = in_temporary_folder();
        cache.write("a", 7, &[5; 100]).unwrap();
        let good = std::fs::read(cache.path("a")).unwrap();
        let flipped = |at: usize| good.iter().enumerate().map(|(i, b)| if i == at { b ^ 4 } else { *b }).collect();
        let cases: [Vec<u8>; 6] = [
            Vec::new(),
            good[..10].to_vec(),
            good[..good.len() - 5].to_vec(),
            [&good[..], &[0]].concat(),
            flipped(60),
            flipped(0),
        ];
        for bytes in cases {
            std::fs::write(cache.path("a"), bytes).unwrap();
            assert!(cache.read("a", 7, 100).is_err_and(|sentence| sentence.contains("damaged")));
        }
    }

    #[test]
    fn things_are_made_once() {
        let (_folder, cache) = in_temporary_folder();
        let load_or_make = |value: u8, fault: bool| {
            let read = |content: &[u8]| if fault { Err("it is odd") } else { Ok(content[0]) };
            let make = || Ok::<_, Infallible>((value, vec![value]));
            let Ok(value) = cache.load_or_make("number", 3, 100, read, make);
            value
        };
        assert_eq!(load_or_make(1, false), 1);
        assert_eq!(load_or_make(2, false), 1, "it was stored");
        assert_eq!(load_or_make(2, true), 2, "invalid content is replaced");
        assert_eq!(load_or_make(3, false), 2);
        // A plain file blocks the path of the cache folder.
        let file = cache.path("number-0000000000000003");
        let none = MapCache::in_folder(&file);
        assert_eq!(none.load_or_make("number", 3, 100, |_| Ok(1), || Ok::<_, &str>((4, vec![4]))), Ok(4));
        assert_eq!(none.load_or_make("number", 3, 100, |_| Ok(1), || Err("no")), Err("no"));
    }

    #[test]
    fn planted_values_are_replaced() {
        let (_folder, cache) = in_temporary_folder();
        let kept = |make: f32| cache.cached("heights", &["program"], 3, |h: &f32| h.abs() < 10.0, || vec![make; 3]);
        assert_eq!([kept(1.0), kept(2.0)], [[1.0; 3]; 2]);
        let file = std::fs::read_dir(&cache.folder).unwrap().next().unwrap().unwrap().path();
        let name = file.file_stem().unwrap().to_str().unwrap();
        let key = u64::from_str_radix(name.rsplit_once('-').unwrap().1, 16).unwrap();
        for (planted, made) in [(f32::NAN, 3.0), (f32::INFINITY, 4.0), (-11.0, 5.0)] {
            cache.write(name, key, bytemuck::bytes_of(&[1.0, planted, 1.0])).unwrap();
            assert_eq!(kept(made), [made; 3], "{planted} has a good checksum");
        }
    }

    #[cfg(unix)]
    #[test]
    fn planted_links_lead_nowhere() {
        let (folder, cache) = in_temporary_folder();
        let victim = folder.path().join("victim");
        std::fs::write(&victim, "mine").unwrap();
        std::fs::create_dir(&cache.folder).unwrap();
        std::os::unix::fs::symlink(&victim, cache.path("soft")).unwrap();
        std::fs::hard_link(&victim, cache.path("hard")).unwrap();
        let left = cache.folder.join(".leadr-0123456789abcdef.part");
        std::fs::write(&left, "left by a killed run").unwrap();
        for name in ["soft", "hard"] {
            cache.write(name, 1, b"content").unwrap();
            assert!(cache.read(name, 1, 100).unwrap().is_some());
        }
        assert_eq!(std::fs::read_to_string(victim).unwrap(), "mine");
        assert!(!left.exists());
    }

    #[test]
    fn the_folder_stays_small_and_foreign_files_stay() {
        let (_folder, cache) = in_temporary_folder();
        let write = |name: &str, age: u64| {
            cache.write(name, 1, &[0; 1000]).unwrap();
            let file = File::options().write(true).open(cache.path(name)).unwrap();
            file.set_modified(SystemTime::now() - std::time::Duration::from_secs(age)).unwrap();
        };
        let names = ["a-0000000000000001", "a-0000000000000002", "b-0000000000000003", "trex-64", "a-000000000000000G"];
        for (name, age) in names.iter().zip([50, 100, 10, 1000, 1000]) {
            write(name, age);
        }
        cache.trim(&cache.path(names[1]), 2500);
        let there = names.map(|name| cache.path(name).exists());
        assert_eq!(there, [false, true, true, true, true], "the oldest but the one kept, and none that another wrote");
    }
}
