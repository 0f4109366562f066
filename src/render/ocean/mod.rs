//! The moving sea on the device: cascades of waves, transformed every frame into displacement and slope moments.

pub mod fields;
pub mod march;
pub mod surface;
pub mod waves;
