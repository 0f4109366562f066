//! Floor 4 · scenes: pure functions of time that produce render inputs.

pub mod ground;
pub mod ocean;
pub mod plane;
pub mod sphere;
pub mod stage;
pub mod trex;
