//! The walking Tyrannosaurus.

pub mod cage;
pub mod deform;
pub mod dual;
pub mod gait;
pub mod parts;
#[cfg(test)]
mod preview;
pub mod primitive;
pub mod relax;
pub mod sdf;
pub mod skeleton;
pub mod topology;
pub mod walk;
pub mod weights;
