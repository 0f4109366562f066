//! Image metrics.

pub mod compare;
mod crop;
pub mod delta_e;
pub mod flicker;
mod mask;
pub mod repetition;

pub use crop::Crop;
pub use mask::Mask;
