//! Loading and saving files, the cost of damaged files, and moments of height maps.

mod bad_input;
mod bake;
mod classes;
mod derive;
mod images;
mod not_a_number;
mod pictures;
mod quantisation;
mod slope_variance;
mod textures;
mod tiling;
