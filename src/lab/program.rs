//! The build that measures and draws.

use std::time::UNIX_EPOCH;

use serde::Serialize;

/// The commit this program was built from; `-dirty` and `-dev` mark what may differ from it.
pub const COMMIT: &str = env!("LEADR_COMMIT");

/// The version of this program.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The meaning of the fields of all results as JSON (docs/guide/json.md). It grows when a field goes or means something else; new fields
/// leave it.
pub const SCHEMA: u32 = 1;

/// A result as JSON, with what every one of them tells of the program.
#[derive(Debug, Serialize)]
pub struct Stamped<'a, R> {
    schema: u32,
    version: &'static str,
    commit: &'static str,
    #[serde(flatten)]
    result: &'a R,
}

impl<'a, R> Stamped<'a, R> {
    /// The result of this program.
    pub fn new(result: &'a R) -> Self {
        Self { schema: SCHEMA, version: VERSION, commit: COMMIT, result }
    }
}

/// Version and commit. Where many builds have the same commit, size and time of the program tell them apart.
#[must_use]
pub fn build() -> String {
    if COMMIT != "unknown" && !COMMIT.contains('-') {
        return format!("{VERSION} {COMMIT}");
    }
    let stamp = || {
        let data = std::env::current_exe().ok()?.metadata().ok()?;
        let time = data.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        Some(format!("{} bytes of {}", data.len(), time.as_secs()))
    };
    format!("{VERSION} {COMMIT}, {}", stamp().unwrap_or_default())
}
