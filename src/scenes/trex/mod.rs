//! The walking Tyrannosaurus.

pub mod atlas;
pub mod noise;
pub mod parts;
pub mod primitive;
pub mod props;
pub mod sdf;
pub mod skin;
