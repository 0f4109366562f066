//! Floor 3 · the renderer: one file per pass, plus the frame that orders them.

pub mod camera;
pub mod displacement;
pub mod patch;
pub mod patch_mesh;
pub mod scene;
pub mod tessellation;
pub mod topology;
