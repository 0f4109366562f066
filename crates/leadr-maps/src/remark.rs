//! Remarks about files that are odd and read all the same.

use std::path::Path;

/// Logs a remark.
pub(super) fn remark(file: &Path, text: &str) {
    tracing::warn!("{}: {text}", file.display());
}
