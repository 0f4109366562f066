//! The ocean: a wind sea that consists of wave cascades.

pub mod cascades;
pub mod sea;
pub mod spectrum;
pub mod waves;
