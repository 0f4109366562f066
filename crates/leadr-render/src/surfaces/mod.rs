//! The drawn surfaces, with their patches and maps on the device and with their tessellation.

pub mod atlas;
pub mod budget;
pub mod classes;
pub mod detail;
pub mod displacement;
pub mod divided;
pub mod fits;
pub mod flat;
pub mod half_range;
pub mod height_scale;
pub mod horizon;
pub mod material;
pub mod media;
pub mod moments;
pub mod numbering;
pub mod object;
pub mod object_view;
pub mod ocean;
pub mod patch;
pub mod patch_mesh;
pub mod placeholders;
pub mod posed;
pub mod records;
pub mod skinning;
pub mod sphere;
pub mod tessellation;
pub mod topology;
pub mod triplanar;

use std::sync::Arc;

use half::f16;
use leadr_gpu::{Gpu, Image, ImageDesc, Result, vk};

/// Creates an image of one texel in place of a missing map. The image is bound, but never read.
fn placeholder(gpu: &Arc<Gpu>, name: &str, format: vk::Format) -> Result<Image> {
    let image = Image::new(gpu, name, ImageDesc::new(format, 1, 1))?;
    image.write(0, 0, &vec![0u8; image.texel_bytes()? as usize])?;
    Ok(image)
}

/// Reads the texels of one level of a half-float image.
fn floats(image: &Image, level: u32) -> Result<Vec<[f32; 4]>> {
    let texels: Vec<[f16; 4]> = image.read(level, 0)?;
    Ok(texels.into_iter().map(|texel| texel.map(f16::to_f32)).collect())
}
