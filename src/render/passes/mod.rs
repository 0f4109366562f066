//! The passes of a frame, one file each: `new` makes its pipelines, `record` draws it.

pub mod accumulate;
pub mod edges;
pub mod environment_lights;
pub mod filter;
pub mod geometry;
pub mod ocean;
pub mod present;
pub mod reference;
pub mod relief_shadow;
pub mod shade;
pub mod shadow;
pub mod targets;
pub mod tiles;
