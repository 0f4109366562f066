//! Scenes: pure functions of time that produce render inputs.

pub mod camera_file;
pub mod config;
pub mod cover;
pub mod daylight;
pub mod deform;
pub mod detail;
pub mod dressed;
pub mod error;
pub mod fitted;
pub mod ground;
mod holes;
pub mod light;
pub mod model;
pub mod ocean;
pub mod pillow;
pub mod plane;
pub mod registry;
pub mod set;
pub mod setting;
pub mod shore;
pub mod snake;
pub mod sphere;
pub mod spheres;
pub mod stage;
pub mod studio;
pub mod trex;
pub mod view;
