//! The walking Tyrannosaurus.

pub mod parts;
pub mod primitive;
pub mod sdf;
