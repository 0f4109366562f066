//! scenes
pub mod trex;
