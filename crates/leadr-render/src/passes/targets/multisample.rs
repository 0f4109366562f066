//! Targets of multisampled geometry.

use std::sync::Arc;

use leadr_gpu::vk;

use super::visible_surface::GeometryTargets;
use crate::constants::OTHERS_BLOCK;
use leadr_gpu::{Buffer, Gpu, GpuError, Image, ImageDesc, Memory, Result};

/// What multisampled geometry is drawn into, and what becomes of it: for each pixel the slots of the surfaces that it shows beside
/// its own (`passes/msaa.glsl`). Clones share the images.
#[derive(Clone)]
pub struct MultisampleTargets {
    /// The samples.
    pub geometry: GeometryTargets,
    /// First slot of each pixel's other surfaces, and how many samples each of them covers; R32UI.
    pub others: Image,
    /// Slots of each block of pixels that are taken; 32 bits each.
    pub filled: Buffer,
    /// Samples in each pixel.
    pub count: u32,
}

impl MultisampleTargets {
    /// Targets for a picture of `size` pixels with `count` samples in each.
    ///
    /// # Errors
    /// Memory that is short, or a number of samples that the device does not have.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32), count: u32) -> Result<Self> {
        let possible = GeometryTargets::possible_samples(gpu);
        if possible & count == 0 {
            let known: Vec<String> =
                (0..u32::BITS).map(|bit| 1 << bit).filter(|n| possible & n != 0).map(|n: u32| n.to_string()).collect();
            let fault = format!("{} has {} samples in a pixel, not {count}", gpu.device_name(), known.join(" or "));
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
