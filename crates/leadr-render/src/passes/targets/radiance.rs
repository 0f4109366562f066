//! The radiance of samples, and the sums over edge samples.

use std::sync::Arc;

use leadr_gpu::vk;

use leadr_gpu::{Gpu, Image, ImageDesc, Result};

/// The format of images that hold radiance and coverage.
pub const RADIANCE_FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// The sums over the edge samples of each pixel.
#[derive(Clone)]
pub struct JoinedEdges {
    /// The sum of radiance and coverage over the edge samples on a different surface from the pixel's, as RGBA32F.
    pub others: Image,
    /// Four numbers per pixel, as RGBA32F: the number of edge samples on the pixel's surface, the area and the number of the joined
    /// samples, and the number of samples that the first sun reaches.
    pub shares: Image,
    /// The numbers of samples that the other suns reach, as RGBA32F. With at most one sun, the image is a single texel.
    pub more_suns: Image,
}

impl JoinedEdges {
    /// Creates images for a picture of `size` pixels with this number of shadow maps.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32), shadow_maps: u32) -> Result<Self> {
        let image =
            |name, size: (u32, u32)| Image::new(gpu, name, ImageDesc::new(RADIANCE_FORMAT, size.0, size.1).storage());
        Ok(Self {
            others: image("other surfaces", size)?,
            shares: image("shares of edge samples", size)?,
            more_suns: image("suns of edge samples", if shadow_maps > 1 { size } else { (1, 1) })?,
        })
    }

    /// Whether the images fit a picture of `size` pixels with this number of shadow maps.
    pub fn fits(&self, size: (u32, u32), shadow_maps: u32) -> bool {
        shadow_maps < 2 || self.more_suns.mip_extent(0) == [size.0, size.1]
    }
}
