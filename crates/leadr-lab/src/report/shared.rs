//! Finds third-party data in the folder that the environment variable `LEADR_SHARED` names.

use std::path::PathBuf;

/// Returns the path of a file or folder of the shared data, if it exists.
pub fn shared(path: &str) -> Option<PathBuf> {
    let path = PathBuf::from(std::env::var_os("LEADR_SHARED")?).join("data").join(path);
    path.exists().then_some(path)
}
