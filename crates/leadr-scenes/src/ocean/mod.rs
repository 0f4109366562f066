//! The ocean: a wind sea as wave cascades.

pub mod cascades;
pub mod sea;
pub mod spectrum;
pub mod waves;
