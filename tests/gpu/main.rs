//! The Vulkan floor, and every GLSL function of the library against its Rust counterpart.

#[path = "../common/mod.rs"]
mod common;

mod build_script;
mod chi_square;
mod device;
mod names;
mod parity;
mod recording;
mod sampling;
