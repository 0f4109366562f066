//! Bakes heights, normals or both into files of filtered slope moments with all mip levels. Rows are streamed, so memory
//! holds only the input images and bands of the result.
//!
//! **Units.** `s` and `t` run from 0 to 1 over the map, and `t` points down. Heights are in the unit of the height map,
//! multiplied by the height scale. If a normal map is given, the unit is the texture width, because normals define slopes
//! and texels are square. LEADR moments are moments of the slopes `dh/ds`, `dh/dt`, and equal the moments of
//! [`super::LeadrMap`] to the last bit. Other kinds use the tangent frame of a normal map with green up ([`Kind`]).
//!
//! **Heights and normals.** If heights and normals are both given, each texel takes its slope from the normals, and heights
//! are used only for displacement.

pub(super) mod blocks;
mod classes;
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

pub use classes::FoundClasses;
pub(super) use classes::{CLASS_CHANNELS, channels_before_classes};
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
