//! Paths of files that commands read and write.

use std::path::Path;

use super::error::AppError;
use leadr_maps::new_file::{NewFile, remove_abandoned};

/// The lower-case extension of a path.
pub fn extension(path: &Path) -> Option<String> {
    path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase)
}

/// Makes the folders above `path`.
///
/// # Errors
/// If one is missing and cannot be made.
pub fn make_folder_of(path: &Path) -> Result<(), AppError> {
    let Some(folder) = path.parent() else { return Ok(()) };
    std::fs::create_dir_all(folder).map_err(|e| AppError::io("make the folder", folder, e))
}

/// Begins a file before any work: makes the folder for it, removes what killed runs left of it, and finds out whether it can be written.
/// Dropped unfinished it is gone again.
///
/// # Errors
/// If the folder cannot be made or refuses the file.
pub fn begin(path: &Path) -> Result<NewFile, AppError> {
    make_folder_of(path)?;
    remove_abandoned([path]);
    Ok(NewFile::create(path)?)
}
