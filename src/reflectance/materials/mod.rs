//! Materials as a renderer asks for them: evaluate, sample, density.

pub mod brdf;
pub mod classic;
pub mod half_difference;
pub mod lambert;
pub mod microfacet;
