//! The passes of the sea: waves transformed every frame into displacement and slope moments, then drawn and filtered.

pub mod fields;
pub mod filter;
pub mod march;
pub mod surface;
