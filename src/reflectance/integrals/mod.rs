//! The integrals of the LEADR paper over the slopes under a pixel, for lights and environments, and their converged values.

pub mod diffuse;
pub mod ggx_filtering;
pub mod ggx_lobes;
pub mod reference;
pub mod sh;
pub mod sh_projection;
pub mod shadowed_reference;
pub mod specular;
