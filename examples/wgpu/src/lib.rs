//! A tiny wgpu renderer of a plane to the horizon under a sun and a sky. From leadr-vk it uses only what any engine could: the
//! shader includes, read by naga, and a file of `leadr bake`, read by the `ktx2` crate.

pub mod baked;
pub mod includes;
pub mod picture;
pub mod view;
