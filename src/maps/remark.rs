//! What is odd about a file that is read all the same.

use std::path::Path;

/// Says it where there is a log; the mathematics and the maps alone have none.
pub(super) fn remark(file: &Path, text: &str) {
    #[cfg(feature = "gpu")]
    tracing::warn!("{}: {text}", file.display());
    #[cfg(not(feature = "gpu"))]
    let _ = (file, text);
}
