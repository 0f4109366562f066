//! The same integrals from the slopes that the viewer sees: closed forms and a few probes instead of the paper's grid.

pub mod diffuse;
pub mod fresnel;
pub mod shadowed_environment;
pub mod shadowed_specular;
pub mod slopes;
pub mod specular;
