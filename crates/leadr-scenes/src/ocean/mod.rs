//! The ocean: a wind sea made of wave cascades.

pub mod cascades;
pub mod sea;
pub mod spectrum;
pub mod waves;
