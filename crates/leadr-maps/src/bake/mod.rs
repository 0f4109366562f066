//! Maps to be kept in files: heights, normals or both become filtered slope moments with all mip levels, row by row, so that
//! memory holds the pictures that are read and bands of the result.
//!
//! **Units.** `s` and `t` run over the map from 0 to 1, `t` down. Heights are in the unit of the height map times the height scale;
//! with a normal map that unit is the width of the texture, since a normal tells rise over run and texels are square.
//! LEADR moments are those of [`super::LeadrMap`], to the last bit: slopes `dh/ds`, `dh/dt`. The other kinds are in the tangent frame of
//! a normal map whose green goes up ([`Kind`]).
//!
//! **Both.** Where there are heights and normals, slopes are those of the normals, one for a texel, and heights only displace.

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
