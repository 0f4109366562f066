//! Paths and temporary files of commands.

use std::collections::BTreeSet;
use std::path::Path;

use super::error::AppError;
use leadr_maps::new_file::{NewFile, remove_abandoned};
use leadr_maps::shown::shown_path;

/// Returns the extension of a path in lower case.
pub fn extension(path: &Path) -> Option<String> {
    path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase)
}

/// Checks that none of the files to write is one of the files to read, under any name: outputs may not destroy inputs.
///
/// # Errors
/// If an output is an input.
pub fn keep_inputs<'a>(
    outputs: impl IntoIterator<Item = &'a Path>,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), AppError> {
    let inputs: BTreeSet<FileId> = inputs.into_iter().filter_map(file_id).collect();
    match outputs.into_iter().find(|output| file_id(output).is_some_and(|id| inputs.contains(&id))) {
        None => Ok(()),
        Some(output) => Err(AppError::Usage(format!(
            "the output '{}' is also an input, which it would replace: name another output",
            shown_path(output)
        ))),
    }
}

/// The identity of an existing regular file, which all its names and links share.
#[cfg(unix)]
type FileId = (u64, u64);

#[cfg(unix)]
fn file_id(path: &Path) -> Option<FileId> {
    use std::os::unix::fs::MetadataExt;
    let file = path.metadata().ok().filter(std::fs::Metadata::is_file)?;
    Some((file.dev(), file.ino()))
}

#[cfg(not(unix))]
type FileId = std::path::PathBuf;

#[cfg(not(unix))]
fn file_id(path: &Path) -> Option<FileId> {
    path.canonicalize().ok().filter(|path| path.is_file())
}

/// Creates the temporary file for `path`, and removes partial files of killed runs. Call this before any work, so that an
/// unwritable folder is reported at once. A file that is dropped unfinished is removed.
///
/// # Errors
/// If the file cannot be created.
pub fn begin(path: &Path) -> Result<NewFile, AppError> {
    remove_abandoned(path);
    Ok(NewFile::create(path)?)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn inputs_are_kept_under_every_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        fs::write(at("a"), "").unwrap();
        fs::write(at("b"), "").unwrap();
        fs::hard_link(at("a"), at("hard")).unwrap();
        std::os::unix::fs::symlink("../a", at("sub/soft")).unwrap();
        let check = |output: &str| keep_inputs([at("c").as_path(), &at(output)], [at("a").as_path(), &at("none")]);
        for same in ["a", "hard", "sub/soft", "sub/../a", "./a"] {
            let fault = check(same).unwrap_err();
            assert!(fault.exit_code() == 2 && fault.to_string().contains(same), "{fault}");
        }
        for other in ["b", "none", "sub"] {
            check(other).unwrap();
        }
        keep_inputs([Path::new("/dev/null")], [Path::new("/dev/null")]).unwrap();
    }
}
