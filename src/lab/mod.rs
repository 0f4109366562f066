//! Floor 5 · the laboratory: what proves and measures. Nothing that draws a user's frame imports it.

pub mod bench;
pub mod cracks;
pub mod error;
pub mod fit;
pub mod metrics;
pub mod multiscattering_study;
pub mod panorama_study;
pub mod program;
pub mod progress;
pub mod quadrature_study;
pub mod ray_cast;
pub mod report;
pub mod shadowing_errors;
