//! Floor 3 · the renderer: one file per pass, plus the frame that orders them.

pub mod patch;
pub mod patch_mesh;
pub mod sky;
