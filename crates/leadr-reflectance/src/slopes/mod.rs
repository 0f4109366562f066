//! The slopes under a pixel: their moments, texel formats, and changes with the underlying surface.

pub mod geometric_antialiasing;
pub mod grid;
pub mod map;
pub mod moments;
pub mod normal_blending;
pub mod packing;
pub mod rotation;
pub mod statistics;
pub mod tiling;
