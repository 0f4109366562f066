//! The ocean: a wind sea as cascades of waves.

pub mod cascades;
pub mod sea;
pub mod spectrum;
pub mod waves;
