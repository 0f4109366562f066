//! Baking of heights, normals or both into files of filtered slope moments with all mip levels. Baking streams rows, so memory
//! holds only the input images and bands of the result.
//!
//! **Units.** `s` and `t` run over the map from 0 to 1, `t` down. Heights are in the unit of the height map times the height
//! scale. With a normal map the unit is the texture width, since normals give rise over run and texels are square. LEADR
//! moments are moments of the slopes `dh/ds`, `dh/dt` and equal those of [`super::LeadrMap`] to the last bit. Other kinds use
//! the tangent frame of a normal map with green up ([`Kind`]).
//!
//! **Heights and normals.** If both are given, slopes come from the normals, one per texel, and heights are used only for
//! displacement.

pub(super) mod blocks;
mod derived;
mod exr_write;
mod inputs;
mod keys;
mod kind;
pub(super) mod ktx2_write;
mod normals;
mod png_write;
mod report;
mod resample;
mod work;

pub use derived::FoundHeights;
pub use exr_write::ExrFile;
pub use inputs::{DetailNormals, Inputs, Roughness};
pub(super) use keys::packed;
pub(super) use kind::HEIGHT_REST;
pub use kind::{Kind, Layout, Precision, Texels};
pub use ktx2_write::Ktx2File;
pub use png_write::PngFile;
pub use report::{LevelError, Report};
pub use work::{Plan, Target, bake};
