//! Fits microfacet models to a material (thesis ch. 4).

pub mod fit;
pub mod fresnel;
pub mod lobes;
pub mod parametric;
pub mod power_iteration;
pub mod published;
pub mod refinement;
pub mod roughness;
pub mod samples;
pub mod simplex;
