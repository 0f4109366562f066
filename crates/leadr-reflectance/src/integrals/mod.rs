//! The integrals of the LEADR paper over the slopes under a pixel, for lights and environments, with converged reference integrals.

pub mod diffuse;
pub mod directional_albedo;
pub mod facet_specular;
pub mod ggx_filtering;
pub mod ggx_lobes;
pub mod interreflection;
pub mod light_size;
pub mod phong;
pub mod reference;
pub mod sh;
pub mod sh_projection;
pub mod slope_nodes;
pub mod specular;
