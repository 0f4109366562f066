//! Floor 3 · the renderer: one file per pass, plus the frame that orders them.

mod atmosphere;
pub mod cube_mips;
pub mod environment;
pub mod equirect;
pub mod irradiance;
pub mod moments;
pub mod patch;
pub mod patch_mesh;
pub mod sky;
pub mod sky_pass;
