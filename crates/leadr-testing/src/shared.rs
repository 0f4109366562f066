//! Finds third-party data outside the repository, such as maps, environments and damaged files.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::path::{Path, PathBuf};

/// Returns the folder `LEADR_SHARED/data/<folder>`, or `None` if it does not exist, so that the test is skipped.
///
/// # Panics
/// If `LEADR_REQUIRE_SHARED=1` is set and the data are missing.
pub fn shared_data(folder: &str) -> Option<PathBuf> {
    let root = std::env::var_os("LEADR_SHARED");
    let found = root.map(|root| Path::new(&root).join("data").join(folder)).filter(|path| path.is_dir());
    if found.is_none() {
        let required = std::env::var("LEADR_REQUIRE_SHARED").is_ok_and(|value| value == "1");
        assert!(!required, "LEADR_REQUIRE_SHARED=1, but LEADR_SHARED has no data/{folder}");
        println!("skipped: LEADR_SHARED has no data/{folder}");
    }
    found
}
