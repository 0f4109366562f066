//! Floor 1 · pure mathematics of LEADR mapping, in `f64`: the reference and the documentation of every equation.
//!
//! Each file has a twin of the same name under `shaders-glsl/leadr` (what ships, `f32`) and is held against it by a probe
//! under `shaders-glsl/probes`. Same function names, same argument order.
//!
//! Conventions. Directions are unit vectors pointing away from the surface, in the macro tangent frame with z the
//! displacement direction: `wo` viewer, `wi` light, `wh` half vector, `wn` micronormal. A slope is
//! `(-n.x / n.z, -n.y / n.z)`. `m` is the mean slope; `s` the slope covariance as `(s_xx, s_yy, s_xy)`. Every function
//! is finite for every finite input, rough or smooth, facing or not.

pub mod beckmann;
pub mod beckmann_sampling;
pub mod diffuse;
pub mod ellipse;
pub mod frame;
pub mod fresnel;
pub mod geometric_antialiasing;
pub mod ggx;
pub mod ggx_filtering;
pub mod ggx_sampling;
pub mod limits;
pub mod masking;
pub mod normal_distribution;
pub mod projected_area;
pub mod quadrature;
pub mod reference;
pub mod sh;
pub mod sh_projection;
pub mod slope_distribution;
pub mod slope_grid;
pub mod slope_map;
pub mod slope_moments;
pub mod slope_packing;
pub mod slope_statistics;
pub mod specular;
