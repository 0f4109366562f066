//! The passes of the sea. In every frame, they transform the waves into displacement and slope moments, and then draw and filter
//! the waves.

pub mod fields;
pub mod filter;
pub mod march;
pub mod surface;
