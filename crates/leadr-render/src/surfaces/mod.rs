//! The surfaces that are drawn: patches and their maps on the device, and how finely they are tessellated.

pub mod atlas;
pub mod budget;
pub mod detail;
pub mod displacement;
pub mod divided;
pub mod fits;
pub mod flat;
mod half_range;
pub mod horizon;
pub mod material;
pub mod moments;
pub mod numbering;
pub mod object;
pub mod object_view;
pub mod ocean;
pub mod patch;
pub mod patch_mesh;
pub mod posed;
pub mod records;
pub mod relief_color;
pub mod skinning;
pub mod sphere;
pub mod tessellation;
pub mod topology;
pub mod triplanar;
