//! The passes of the sea, which transform the waves into displacement and slope moments every frame, then draw and filter them.

pub mod fields;
pub mod filter;
pub mod march;
pub mod surface;
