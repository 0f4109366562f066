//! The version, commit and memory use of the running program.

use std::sync::OnceLock;
use std::time::UNIX_EPOCH;

use serde::Serialize;

static COMMIT: OnceLock<&str> = OnceLock::new();

/// Sets the commit of this build. Call `set_commit` once, at the start.
pub fn set_commit(commit: &'static str) {
    // A second call comes from the same program and has the same commit.
    let _ = COMMIT.set(commit);
}

/// Returns the commit that the program was built from, or `unknown` if [`set_commit`] was not called. `-dirty` and `-dev`
/// mark builds that may differ from their commit.
pub fn commit() -> &'static str {
    COMMIT.get().copied().unwrap_or("unknown")
}

/// The version of this program.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The schema version of JSON results (docs/guide/json.md). The version increases when a field is removed or changes its
/// meaning, but not when a field is added.
pub const SCHEMA: u32 = 1;

/// A JSON result together with the schema, version and commit of the program.
#[derive(Debug, Serialize)]
pub struct Stamped<'a, R> {
    schema: u32,
    version: &'static str,
    commit: &'static str,
    #[serde(flatten)]
    result: &'a R,
}

impl<'a, R> Stamped<'a, R> {
    /// Adds the schema, version and commit to a result.
    pub fn new(result: &'a R) -> Self {
        Self { schema: SCHEMA, version: VERSION, commit: commit(), result }
    }
}

/// Returns the version and commit. If the build may differ from its commit, the size and time of the executable follow.
pub fn build() -> String {
    let commit = commit();
    if commit != "unknown" && !commit.contains('-') {
        return format!("{VERSION} {commit}");
    }
    let stamp = || {
        let data = std::env::current_exe().ok()?.metadata().ok()?;
        let time = data.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        Some(format!("{} bytes of {}", data.len(), time.as_secs()))
    };
    format!("{VERSION} {commit}, {}", stamp().unwrap_or_default())
}

/// Returns the memory of this process in bytes, from a line of `/proc/self/status`. `VmRSS:` is the resident memory, and
/// `VmHWM:` the peak of resident memory. Returns `None` except on Linux.
pub fn memory_of_process(line: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let value = status.lines().find_map(|text| text.strip_prefix(line))?;
    value.split_whitespace().next()?.parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
}
