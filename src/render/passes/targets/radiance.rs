//! The radiance of samples, and the joined sums of edge samples.

use std::sync::Arc;

use ash::vk;

use crate::gpu::{Gpu, Image, ImageDesc, Result};

/// Format of the images that hold radiance and coverage.
pub const RADIANCE_FORMAT: vk::Format = vk::Format::R32G32B32A32_SFLOAT;

/// The joined sums of each pixel's edge samples.
#[derive(Clone)]
pub struct JoinedEdges {
    /// Sum of the radiance and coverage of the edge samples that see other surfaces than the pixel; RGBA32F.
    pub others: Image,
    /// Number of edge samples that see the pixel's surface; area, number and sunlit share of those that were joined;
    /// RGBA32F.
    pub shares: Image,
}

impl JoinedEdges {
    /// Images for a picture of `size` pixels.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let image = |name| Image::new(gpu, name, ImageDesc::new(RADIANCE_FORMAT, size.0, size.1).storage());
        Ok(Self { others: image("other surfaces")?, shares: image("shares of edge samples")? })
    }
}
