//! Filter pass: the slope statistics and the material under each pixel, fetched once per pixel.

use std::sync::Arc;

use ash::vk;

use super::geometry::VisibleSurface;
use super::object::{FLAGS_GRID_SHIFT, GpuObject};
use super::settings::ShadingSettings;
use crate::gpu::{
    ColorTarget, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Image, ImageDesc, Load, Result,
    Sampler, SpecValue, Use, Wrap,
};

/// The LEADR G-buffer: everything a pixel needs to be shaded, 48 bytes and the depth of [`VisibleSurface`].
pub struct GBuffer {
    /// Octahedral displacement direction (xy), mean slope in its frame (zw); RGBA32F.
    pub frame: Image,
    /// Slope covariance `sxx, syy, sxy` and LOD; RGBA32F.
    pub covariance: Image,
    /// Linear albedo and Beckmann roughness; RGBA16F.
    pub material: Image,
    /// Specular f0, accessibility, inside marker, 1 where the footprint is more than its patch knows (of edge samples: the object's relief, metres); RGBA16F.
    pub surface: Image,
}

impl GBuffer {
    /// Formats of its images in the order of their attachments.
    pub const FORMATS: [vk::Format; 4] = [
        vk::Format::R32G32B32A32_SFLOAT,
        vk::Format::R32G32B32A32_SFLOAT,
        vk::Format::R16G16B16A16_SFLOAT,
        vk::Format::R16G16B16A16_SFLOAT,
    ];

    /// A G-buffer of `size` pixels.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        // Edge samples are joined in it.
        let color =
            |name: &str, format| Image::new(gpu, name, ImageDesc::new(format, size.0, size.1).color_target().storage());
        Ok(Self {
            frame: color("g-buffer frame", Self::FORMATS[0])?,
            covariance: color("g-buffer covariance", Self::FORMATS[1])?,
            material: color("g-buffer material", Self::FORMATS[2])?,
            surface: color("g-buffer surface", Self::FORMATS[3])?,
        })
    }

    /// Its images in the order of their attachments.
    #[must_use]
    pub fn colors(&self) -> [&Image; 4] {
        [&self.frame, &self.covariance, &self.material, &self.surface]
    }
}

/// Pipeline of the filter pass.
pub struct FilterPass {
    pipeline: GraphicsPipeline,
    nearest: Sampler,
}

impl FilterPass {
    /// The pass for some settings, of which it needs the technique and whether the pixel kernel is wanted.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>, settings: &ShadingSettings) -> Result<Self> {
        let pipeline = GraphicsPipeline::new(
            gpu,
            "filter",
            &GraphicsDesc {
                vertex: "passes/fullscreen.vert",
                fragment: Some("passes/filter/filter.frag"),
                colors: &GBuffer::FORMATS,
                spec: &[(0, SpecValue::I32(settings.technique.code())), (2, SpecValue::Bool(settings.pixel_kernel))],
                ..Default::default()
            },
        )?;
        Ok(Self { pipeline, nearest: Sampler::new(gpu, "filter", Filter::Nearest, Wrap::Clamp)? })
    }

    /// Fills the G-buffer where an object is visible (elsewhere it stays undefined: depth tells), one full-screen draw
    /// per object, and leaves it readable. `grid`: edge samples along a pixel, 0 of the pixels themselves; `scissor`: where in it.
    pub fn record<'a>(
        &self,
        cmd: &mut Commands,
        visible: &VisibleSurface,
        target: &GBuffer,
        objects: impl Iterator<Item = &'a GpuObject>,
        height_scale: f32,
        grid: u32,
        scissor: Option<[u32; 4]>,
    ) {
        for image in target.colors() {
            cmd.image_barrier(image, Use::Undefined, Use::ColorTarget);
        }
        let colors = target.colors().map(|image| ColorTarget { view: image.whole(), load: Load::Clear([0.0; 4]) });
        cmd.begin_rendering(&colors, None);
        if let Some(area) = scissor {
            cmd.scissor(area);
        }
        for object in objects {
            cmd.bind(
                &self.pipeline,
                &[
                    (0, Descriptor::Sampled(visible.texture.whole(), &self.nearest)),
                    (1, Descriptor::Sampled(visible.tangent.whole(), &self.nearest)),
                    (2, Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                    (3, Descriptor::Sampled(object.maps.slopes().whole(), &object.sampler)),
                    (4, Descriptor::Sampled(object.maps.joint().whole(), &object.sampler)),
                    (5, Descriptor::Sampled(object.color.whole(), &object.sampler)),
                    (6, Descriptor::Storage(&object.tiles)),
                ],
            );
            let mut constants = object.constants(height_scale, false);
            constants.flags |= grid << FLAGS_GRID_SHIFT;
            cmd.push_constants(&constants);
            cmd.draw(0..3, 0..1);
        }
        cmd.end_rendering();
        for image in target.colors() {
            cmd.transition(image, Use::Sampled);
        }
    }
}
