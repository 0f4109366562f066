//! leadr
pub mod app;
pub mod gpu;
pub mod maps;
pub mod reflectance;
pub mod render;
pub mod scenes;
