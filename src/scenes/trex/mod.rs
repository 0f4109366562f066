//! The walking Tyrannosaurus.

pub mod cage;
pub mod dual;
pub mod parts;
pub mod primitive;
pub mod relax;
pub mod sdf;
pub mod topology;
