//! The radiance of samples, and the joined sums of edge samples.

use std::sync::Arc;

use leadr_gpu::vk;

use leadr_gpu::{Gpu, Image, ImageDesc, Result};

/// Format of the images that hold radiance and coverage.
pub const RADIANCE_FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// The joined sums of each pixel's edge samples.
#[derive(Clone)]
pub struct JoinedEdges {
    /// Sum of radiance and coverage over the edge samples on a different surface from the pixel's; RGBA32F.
    pub others: Image,
    /// Number of edge samples on the pixel's surface, area and number of the joined samples, and number of samples that the first
    /// sun reaches; RGBA32F.
    pub shares: Image,
    /// Numbers of samples that the further suns reach; RGBA32F. The image is a single texel for at most one sun.
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

    /// Whether the images fit a picture of `size` with this number of shadow maps.
    pub fn fits(&self, size: (u32, u32), shadow_maps: u32) -> bool {
        shadow_maps < 2 || self.more_suns.mip_extent(0) == [size.0, size.1]
    }
}
