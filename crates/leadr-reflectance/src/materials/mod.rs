//! The renderer's view of materials: evaluation, sampling, density.

pub mod brdf;
pub mod classic;
pub mod energy;
pub mod fitted;
pub mod fitted_table;
pub mod half_difference;
pub mod lambert;
pub mod microfacet;
pub mod multiscattering;
