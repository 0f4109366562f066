//! Data of others, where the variable `LEADR_SHARED` leads to it.

use std::path::PathBuf;

/// A file or folder of it, if it is there.
pub fn shared(path: &str) -> Option<PathBuf> {
    let path = PathBuf::from(std::env::var_os("LEADR_SHARED")?).join("data").join(path);
    path.exists().then_some(path)
}
