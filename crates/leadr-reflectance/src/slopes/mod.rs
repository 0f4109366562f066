//! The slopes under a pixel: their moments, how texels store them, and how they change with the surface that carries
//! them.

pub mod geometric_antialiasing;
pub mod grid;
pub mod map;
pub mod moments;
pub mod normal_blending;
pub mod packing;
pub mod statistics;
pub mod tiling;
pub mod turn;
