//! LEADR's integrals over visible slopes, computed by closed forms and a few probes instead of the paper's grid.

pub mod class_environment;
pub mod clear_coat;
pub mod cone_specular;
pub mod diffuse;
pub mod fresnel;
pub mod grazing;
pub mod horizon;
pub mod kernel;
pub mod lit_slopes;
pub mod mapped;
pub mod shadowed_environment;
pub mod shadowed_specular;
pub mod slopes;
pub mod specular;
pub mod transmission;
