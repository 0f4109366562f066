//! The build that measures and draws.

use std::sync::OnceLock;
use std::time::UNIX_EPOCH;

use serde::Serialize;

static COMMIT: OnceLock<&str> = OnceLock::new();

/// Announces the commit that the program was built from. A program does so once, first of all.
pub fn announce(commit: &'static str) {
    // Announced twice, it is the same program.
    let _ = COMMIT.set(commit);
}

/// The commit that the program was built from, `unknown` if none was announced; `-dirty` and `-dev` mark builds that may
/// differ from it.
pub fn commit() -> &'static str {
    COMMIT.get().copied().unwrap_or("unknown")
}

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
        Self { schema: SCHEMA, version: VERSION, commit: commit(), result }
    }
}

/// Version and commit. Where many builds have the same commit, size and time of the program tell them apart.
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

/// Memory of this process, bytes, in a line of `/proc/self/status`: `VmRSS:`, which is resident, or `VmHWM:`, the most that ever was. Only
/// Linux reports it.
pub fn memory_of_process(line: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let value = status.lines().find_map(|text| text.strip_prefix(line))?;
    value.split_whitespace().next()?.parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
}
