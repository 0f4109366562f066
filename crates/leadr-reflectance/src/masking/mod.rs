//! Masking hides facets from the viewer, and shadowing hides them from the light.

pub mod class_sky;
pub mod classes;
pub mod correlated;
pub mod grooves;
pub mod occlusion;
pub mod shadowing;
pub mod smith;
pub mod variants;
