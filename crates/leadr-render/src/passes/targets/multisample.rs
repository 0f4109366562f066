//! The targets of multisampled geometry.

use std::sync::Arc;

use leadr_gpu::vk;

use super::visible_surface::GeometryTargets;
use crate::constants::OTHERS_BLOCK;
use leadr_gpu::{Buffer, Gpu, GpuError, Image, ImageDesc, Memory, Result};

/// The targets of multisampled geometry, and the slots for the further surfaces of each pixel (`passes/msaa.glsl`). Clones share
/// the images.
#[derive(Clone)]
pub struct MultisampleTargets {
    /// The multisampled targets.
    pub geometry: GeometryTargets,
    /// The first slot of each pixel's further surfaces, and the number of samples that each surface covers, as R32UI.
    pub others: Image,
    /// The slots in use per block of pixels, 32 bits each.
    pub filled: Buffer,
    /// The number of samples per pixel.
    pub count: u32,
}

impl MultisampleTargets {
    /// Creates the targets for a picture of `size` pixels, with `count` samples in each pixel.
    ///
    /// # Errors
    /// Returns an error if memory is short, or if the device does not support the sample count.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32), count: u32) -> Result<Self> {
        let possible = GeometryTargets::possible_samples(gpu);
        if possible & count == 0 {
            let known: Vec<String> =
                (0..u32::BITS).map(|bit| 1 << bit).filter(|n| possible & n != 0).map(|n: u32| n.to_string()).collect();
            let fault = format!("{} supports {} samples per pixel, not {count}", gpu.device_name(), known.join(" or "));
            return Err(GpuError::usage("multisampled geometry", fault));
        }
        let along = |pixels: u32| u64::from(pixels.div_ceil(OTHERS_BLOCK as u32));
        let blocks = along(size.0) * along(size.1);
        let others = ImageDesc::new(vk::Format::R32_UINT, size.0, size.1).storage();
        Ok(Self {
            geometry: GeometryTargets::new(gpu, size, count)?,
            others: Image::new(gpu, "other surfaces of pixels", others)?,
            filled: Buffer::new(gpu, "filled slots", blocks * 4, Memory::Device)?,
            count,
        })
    }
}
