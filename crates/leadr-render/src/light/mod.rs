//! The lighting of a scene: the sky, environment cube maps and their spherical harmonics, and the exposure.

mod atmosphere;
mod bright_spots;
pub mod casters;
pub mod cube_lobes;
pub mod cube_mips;
pub mod environment;
pub mod equirect;
pub mod exposure;
pub mod irradiance;
pub mod irradiance_rest;
pub mod panorama;
pub mod sky;
pub mod sky_pass;
pub mod sky_visibility;
mod texels;

pub use leadr_shaders::atmosphere as constants;
