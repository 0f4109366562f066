//! The renderer's pictures, scene by scene and pass by pass.

#[path = "../common/mod.rs"]
mod common;

mod antialiasing;
mod baked;
mod bounces;
mod deform;
mod displaced_models;
mod edges;
mod environment;
mod faults;
mod figures;
mod filtering;
mod fitted;
mod frame;
mod irradiance;
mod layers;
mod materials;
mod model;
mod model_looks;
mod moments;
mod moving_sun;
mod msaa;
mod ocean;
mod panorama;
mod pictures;
mod reference;
mod relief;
mod relief_color;
mod seams;
mod shading;
mod shore;
mod soft_shadows;
mod spheres;
mod techniques;
mod tiling;
mod trex;
mod triplanar;
