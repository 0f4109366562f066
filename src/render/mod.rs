//! Floor 3 · the renderer: one file per pass, plus the frame that orders them.

pub mod accumulate;
mod atmosphere;
pub mod camera;
pub mod color_map;
pub mod cube_mips;
pub mod displacement;
pub mod environment;
pub mod equirect;
pub mod filter;
pub mod frame;
pub mod geometry;
pub mod irradiance;
pub mod moments;
pub mod object;
pub mod ocean;
pub mod patch;
pub mod patch_mesh;
pub mod present;
pub mod scene;
pub mod settings;
pub mod shade;
pub mod shadow;
pub mod skinning;
pub mod sky;
pub mod sky_pass;
pub mod tessellation;
pub mod topology;
