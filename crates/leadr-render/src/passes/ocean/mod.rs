//! The passes of the sea: every frame transforms the waves into displacement and slope moments, then draws and filters them.

pub mod fields;
pub mod filter;
pub mod march;
pub mod surface;
