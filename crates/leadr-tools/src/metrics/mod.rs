//! Image metrics.

pub mod compare;
pub mod delta_e;
pub mod flicker;
mod mask;
pub mod repetition;

pub use mask::Mask;
