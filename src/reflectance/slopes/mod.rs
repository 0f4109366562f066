//! The slopes under a pixel: their moments, how texels store them, and how they follow the surface they lie on.

pub mod geometric_antialiasing;
pub mod grid;
pub mod map;
pub mod moments;
pub mod packing;
pub mod statistics;
pub mod turn;
