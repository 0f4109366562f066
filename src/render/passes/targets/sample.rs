//! The targets for one sample of every pixel.

use std::sync::Arc;

use super::gbuffer::GBuffer;
use super::radiance::RADIANCE_FORMAT;
use super::visible_surface::VisibleSurface;
use crate::gpu::{Gpu, Image, ImageDesc, Result};

/// The surfaces that the samples of an image see, and their radiance. Clones share the images.
#[derive(Clone)]
pub struct SampleTargets {
    /// The output of the geometry stages.
    pub visible: VisibleSurface,
    /// The output of the filter passes.
    pub gbuffer: GBuffer,
    /// Radiance and coverage.
    pub radiance: Image,
}

impl SampleTargets {
    /// Targets for an image of `size` samples.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let radiance = ImageDesc::new(RADIANCE_FORMAT, size.0, size.1).color_target();
        Ok(Self {
            visible: VisibleSurface::new(gpu, size)?,
            gbuffer: GBuffer::new(gpu, size)?,
            radiance: Image::new(gpu, "sample", radiance)?,
        })
    }
}
