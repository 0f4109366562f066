//! Paths and temporary files of commands.

use std::path::Path;

use super::error::AppError;
use leadr_maps::new_file::{NewFile, remove_abandoned};

/// Returns the extension of a path in lower case.
pub fn extension(path: &Path) -> Option<String> {
    path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase)
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
