//! Third-party data that the repository does not contain: maps, environments, damaged files.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::path::{Path, PathBuf};

/// The folder `LEADR_SHARED/data/<folder>`, if the variable leads to one; else the test has nothing to read.
///
/// # Panics
/// When `LEADR_REQUIRE_SHARED=1` asks for the data and it is missing.
pub fn shared_data(folder: &str) -> Option<PathBuf> {
    let root = std::env::var_os("LEADR_SHARED");
    let found = root.map(|root| Path::new(&root).join("data").join(folder)).filter(|path| path.is_dir());
    if found.is_none() {
        let required = std::env::var("LEADR_REQUIRE_SHARED").is_ok_and(|value| value == "1");
        assert!(!required, "LEADR_REQUIRE_SHARED=1, but LEADR_SHARED does not lead to data/{folder}");
        println!("skipped: LEADR_SHARED does not lead to data/{folder}");
    }
    found
}
