//! Paths of files that commands read and write.

use std::path::Path;

use super::error::AppError;

/// The lower-case extension of a path.
#[must_use]
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
