//! A tiny wgpu renderer of a plane that extends to the horizon, under a sun and a sky. The renderer uses only parts of leadr-vk that any
//! engine could use: the shader includes, which naga reads, and a file of `leadr bake`, which the `ktx2` crate reads.

pub mod baked;
pub mod includes;
pub mod picture;
pub mod view;
