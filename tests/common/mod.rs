//! Parts that several test binaries share.

#![allow(dead_code, reason = "each test binary uses its own part")]

pub mod comparison;
#[cfg(feature = "gpu")]
pub mod cube;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod height_rays;
pub mod memory;
#[cfg(feature = "gpu")]
pub mod render;
pub mod shared;
pub mod slopes;
pub mod sphere_oracle;
pub mod standard;
