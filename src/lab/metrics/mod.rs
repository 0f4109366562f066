//! How far pictures are apart.

pub mod compare;
pub mod flicker;
mod mask;

pub use mask::Mask;
