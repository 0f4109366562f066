//! Loading and saving files, the cost of damaged ones, and the moments of height maps.

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod bake;
mod derive;
mod images;
mod slope_variance;
mod textures;
mod tiling;
