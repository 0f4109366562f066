//! Floor 5 · the laboratory: what proves and measures. Nothing that draws a user's frame imports it.

pub mod metrics;
pub mod quadrature_study;
pub mod ray_cast;
pub mod shadowing_errors;
