//! Code that several test binaries share.

pub mod comparison;
#[cfg(feature = "gpu")]
pub mod cube;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "maps")]
pub mod height_rays;
pub mod memory;
#[cfg(feature = "gpu")]
pub mod render;
pub mod shared;
pub mod slopes;
pub mod sphere_oracle;
pub mod standard;
