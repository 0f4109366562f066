//! The renderer's interface to materials: evaluation, sampling and density.

pub mod abc;
pub mod brdf;
pub mod classic;
pub mod diffuse_models;
pub mod energy;
pub mod fitted;
pub mod fitted_table;
pub mod half_difference;
pub mod lambert;
pub mod microfacet;
pub mod multiscattering;
pub mod shifted_gamma;
