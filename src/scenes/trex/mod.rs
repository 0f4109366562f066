//! The walking Tyrannosaurus.

pub mod atlas;
pub mod cage;
pub mod dual;
pub mod noise;
pub mod parts;
#[cfg(test)]
mod preview;
pub mod primitive;
pub mod props;
pub mod relax;
pub mod sdf;
pub mod skin;
pub mod topology;
