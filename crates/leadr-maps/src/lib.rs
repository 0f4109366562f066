//! Textures on the CPU. This crate loads and validates untrusted files, derives slope moments and mip levels, generates
//! procedural height maps, and tonemaps and saves images. The crate does not depend on Vulkan.
//!
//! Texels are row-major, and row 0 is the top row. `s` runs to the right over the width and `t` runs down over the height,
//! both from 0 to 1. Colours are linear Rec.709 unless the type says sRGB.

pub mod bake;
pub mod baked;
mod bc5;
pub mod cache;
pub mod checksum;
mod class_map;
mod dds_read;
pub mod derive;
mod exr_layers;
mod exr_picture;
mod exr_read;
mod fault;
pub mod folders;
mod gamut;
pub mod guard;
pub mod halves;
mod hdr;
mod header;
mod holes;
pub mod horizon;
mod image_class;
mod image_format;
mod ktx2_read;
pub mod limits;
mod load;
pub mod material;
pub mod mips;
pub mod moments;
pub mod new_file;
pub mod noise;
pub mod origin;
mod panorama;
mod picture;
mod png_info;
pub mod procedural;
mod pyramid;
mod raster_read;
pub mod reads;
mod resample;
pub mod save;
mod seams;
pub mod shown;
pub mod srgb;
mod texels;
mod tiff_read;
pub mod tonemap;
mod types;
pub mod udim;

pub use class_map::{CLASS_SOURCES, ClassColors, ClassFrame, ClassLevel, ClassMap};
pub use fault::{MapError, MapFault};
pub use header::ImageHeader;
pub use image_format::ImageFormat;
pub use load::{
    decode_color, decode_color_srgb8, decode_environment, decode_height_map, decode_heights, decode_picture,
    load_color, load_color_raster, load_color_srgb8, load_environment, load_environment_layer, load_height_channel,
    load_height_map, load_picture, load_picture_layer, load_raster,
};
pub use moments::{LeadrMap, MomentLevel, Moments, Wrap};
pub use picture::{Frame, Picture};
pub use raster_read::{decode_raster, decode_raster_with_remarks};
pub use types::{HeightMap, Image, Rgb8Image, RgbImage};
