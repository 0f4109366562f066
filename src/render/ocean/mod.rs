//! The moving sea on the device: cascades of waves, transformed every frame into displacement and slope moments.

pub mod fields;
pub mod filter;
pub mod march;
pub mod mesh;
pub mod shore;
pub mod surface;
pub mod waves;
