//! The build that measures.

/// The commit this program was built from; `-dirty` and `-dev` mark what may differ from it.
pub const COMMIT: &str = env!("LEADR_COMMIT");
