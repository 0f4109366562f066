//! A tiny renderer in wgpu. Of leadr-vk it has the shader includes, which naga reads, and a file of `leadr bake`, which the
//! `ktx2` crate reads: what any other engine would take. It shows a plane to the horizon under a sun and a sky.

pub mod baked;
pub mod includes;
pub mod picture;
pub mod view;
