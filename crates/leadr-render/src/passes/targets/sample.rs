//! The targets for one sample of every pixel.

use std::sync::Arc;

use super::begin::Begin;
use super::gbuffer::GBuffer;
use super::radiance::RADIANCE_FORMAT;
use super::visible_surface::VisibleSurface;
use crate::constants::OTHERS_BLOCK;
use leadr_gpu::{ColorTarget, Commands, DepthTarget, Gpu, Image, ImageDesc, Load, Result, Use};

/// The surfaces at the samples of an image, and the radiance of the samples. Clones share the images.
#[derive(Clone)]
pub struct SampleTargets {
    /// The output of the geometry stages.
    pub visible: VisibleSurface,
    /// The output of the filter passes.
    pub gbuffer: GBuffer,
    /// The radiance and the coverage.
    pub radiance: Image,
}

impl SampleTargets {
    /// Creates targets for an image of `size` samples. Without `with_gbuffer`, the G-buffer is a single texel.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32), with_gbuffer: bool) -> Result<Self> {
        Self::with(gpu, size, VisibleSurface::new(gpu, size)?, with_gbuffer)
    }

    /// Creates targets for a picture of `size` pixels with multisampled geometry. The targets include slots for further surfaces.
    pub fn with_slots(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let whole = |pixels: u32| pixels.next_multiple_of(OTHERS_BLOCK as u32);
        let size = (whole(size.0), 2 * whole(size.1));
        Self::with(gpu, size, VisibleSurface::stored(gpu, size)?, false)
    }

    fn with(gpu: &Arc<Gpu>, size: (u32, u32), visible: VisibleSurface, with_gbuffer: bool) -> Result<Self> {
        let radiance = ImageDesc::new(RADIANCE_FORMAT, size.0, size.1).color_target();
        Ok(Self {
            visible,
            gbuffer: GBuffer::new(gpu, if with_gbuffer { size } else { (1, 1) })?,
            radiance: Image::new(gpu, "sample", radiance)?,
        })
    }

    /// Runs `draw`, which writes the radiance of every sample within the scissor (x, y, width, height).
    pub fn draw_radiance(&self, cmd: &mut Commands, scissor: Option<[u32; 4]>, draw: impl FnOnce(&mut Commands)) {
        cmd.image_barrier(&self.radiance, Use::Undefined, Use::ColorTarget);
        cmd.begin_rendering(&[ColorTarget { view: self.radiance.whole(), load: Load::Discard }], None);
        if let Some(area) = scissor {
            cmd.scissor(area);
        }
        draw(cmd);
        cmd.end_rendering();
    }

    /// Runs `draw`, which writes the radiance of some of the objects. The pipelines of `draw` test the object depth.
    pub fn draw_radiance_of_objects(&self, cmd: &mut Commands, begin: Begin, draw: impl FnOnce(&mut Commands)) {
        begin.transition(cmd, &self.radiance, Use::ColorTarget);
        let load = if begin == Begin::Clear { Load::Discard } else { Load::Keep };
        let objects = DepthTarget { view: self.visible.objects.whole(), clear: None };
        cmd.begin_rendering(&[ColorTarget { view: self.radiance.whole(), load }], Some(objects));
        draw(cmd);
        cmd.end_rendering();
    }
}
