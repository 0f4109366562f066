//! Filter pass: the slope statistics and the material under each pixel, fetched once per pixel.

use std::sync::Arc;

use ash::vk;
use glam::{DVec2, DVec3, Vec2, Vec3};
use half::f16;

use super::geometry::VisibleSurface;
use crate::gpu::{
    ColorTarget, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Image, ImageDesc, Load, Result,
    Sampler, SpecValue, Topology, Use, Wrap,
};
use crate::reflectance::frame::octahedral_decode;
use crate::render::settings::ShadingSettings;
use crate::render::surfaces::object::{FLAGS_GRID_SHIFT, FilteredObjectGpu, GpuObject};

/// The LEADR G-buffer: everything a pixel needs to be shaded, 40 bytes (`passes/gbuffer.glsl`) and the depth of [`VisibleSurface`].
pub struct GBuffer {
    /// Octahedral displacement direction, mean slope in its frame, covariance `sxy`; RGBA32UI.
    pub slopes: Image,
    /// Linear albedo, Beckmann roughness, variances `sxx` and `syy`; RGBA32UI.
    pub material: Image,
    /// Specular f0 and accessibility; level of detail, or what edge samples are joined by; RG32UI.
    pub surface: Image,
}

/// One pixel of the [`GBuffer`], as far as pictures show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilteredPixel {
    /// World displacement direction, unit.
    pub normal: DVec3,
    /// Mean slope in the frame about it.
    pub mean_slope: Vec2,
    /// Slope covariance `sxx, syy, sxy`.
    pub slope_covariance: Vec3,
    /// Linear albedo.
    pub albedo: Vec3,
    /// Beckmann roughness of the base material.
    pub roughness: f32,
    /// Level of detail of the maps.
    pub lod: f32,
}

impl GBuffer {
    /// Formats of its images in the order of their attachments.
    pub const FORMATS: [vk::Format; 3] =
        [vk::Format::R32G32B32A32_UINT, vk::Format::R32G32B32A32_UINT, vk::Format::R32G32_UINT];

    /// A G-buffer of `size` pixels.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let color = |format| ImageDesc::new(format, size.0, size.1).color_target();
        let [slopes, material, surface] = Self::FORMATS.map(color);
        // Edge samples are joined in the first two.
        Ok(Self {
            slopes: Image::new(gpu, "g-buffer slopes", slopes.storage())?,
            material: Image::new(gpu, "g-buffer material", material.storage())?,
            surface: Image::new(gpu, "g-buffer surface", surface)?,
        })
    }

    /// Its images in the order of their attachments.
    #[must_use]
    pub fn colors(&self) -> [&Image; 3] {
        [&self.slopes, &self.material, &self.surface]
    }

    /// Reads it back, row by row.
    ///
    /// # Errors
    /// A lost device, or memory that is short.
    pub fn read(&self) -> Result<Vec<FilteredPixel>> {
        let slopes: Vec<[u32; 4]> = self.slopes.read(0, 0)?;
        let material: Vec<[u32; 4]> = self.material.read(0, 0)?;
        let surface: Vec<[u32; 2]> = self.surface.read(0, 0)?;
        let pixels = slopes.iter().zip(&material).zip(&surface);
        Ok(pixels.map(|((&slopes, &material), &surface)| FilteredPixel::unpack(slopes, material, surface)).collect())
    }
}

impl FilteredPixel {
    fn unpack(slopes: [u32; 4], material: [u32; 4], surface: [u32; 2]) -> Self {
        let snorm = |bits: u32| (f64::from(bits as u16 as i16) / 32767.0).max(-1.0);
        let half = |bits: u32| f16::from_bits(bits as u16).to_f32();
        let color = [material[0], material[0] >> 16, material[1], material[1] >> 16].map(half);
        Self {
            normal: octahedral_decode(DVec2::new(snorm(slopes[0]), snorm(slopes[0] >> 16))),
            mean_slope: Vec2::from([slopes[1], slopes[2]].map(f32::from_bits)),
            slope_covariance: Vec3::from([material[2], material[3], slopes[3]].map(f32::from_bits)),
            albedo: Vec3::new(color[0], color[1], color[2]),
            roughness: color[3],
            lod: half(surface[1]),
        }
    }
}

/// Pipelines of the filter pass.
pub struct FilterPass {
    /// For maps that go on where a pixel's footprint does.
    continuous: GraphicsPipeline,
    /// For atlases of one tile per patch.
    atlas: GraphicsPipeline,
    nearest: Sampler,
    linear: Sampler,
}

impl FilterPass {
    /// The pass for some settings, of which it needs the technique and whether the pixel kernel is wanted.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>, settings: &ShadingSettings) -> Result<Self> {
        let pipeline = |name, atlas| {
            GraphicsPipeline::new(
                gpu,
                name,
                &GraphicsDesc {
                    vertex: "passes/filter/filter.vert",
                    fragment: Some("passes/filter/filter.frag"),
                    colors: &GBuffer::FORMATS,
                    topology: Topology::Points,
                    spec: &[
                        (0, SpecValue::I32(settings.technique.code())),
                        (2, SpecValue::Bool(settings.pixel_kernel)),
                        (3, SpecValue::Bool(atlas)),
                    ],
                    ..Default::default()
                },
            )
        };
        let (continuous, atlas) = (pipeline("filter", false)?, pipeline("filter atlas", true)?);
        Ok(Self {
            continuous,
            atlas,
            nearest: Sampler::new(gpu, "filter", Filter::Nearest, Wrap::Clamp)?,
            linear: Sampler::new(gpu, "coarse levels", Filter::Bilinear, Wrap::Clamp)?,
        })
    }

    /// Fills the G-buffer where an object is visible (elsewhere it stays undefined: depth tells), in the tiles of each object, and
    /// leaves it readable. `rays` and near plane are those of the image; `grid`: edge samples along a pixel, 0 of the pixels
    /// themselves; `scissor`: where in it.
    pub fn record<'a>(
        &self,
        cmd: &mut Commands,
        visible: &VisibleSurface,
        target: &GBuffer,
        objects: impl Iterator<Item = &'a GpuObject>,
        height_scale: f32,
        (rays, near): ([Vec3; 3], f32),
        grid: u32,
        scissor: Option<[u32; 4]>,
    ) {
        for image in target.colors() {
            cmd.image_barrier(image, Use::Undefined, Use::ColorTarget);
        }
        // Pictures are taken of the pixels' own.
        let load = if grid > 0 { Load::Discard } else { Load::ClearUint([0; 4]) };
        let colors = target.colors().map(|image| ColorTarget { view: image.whole(), load });
        cmd.begin_rendering(&colors, None);
        if let Some(area) = scissor {
            cmd.scissor(area);
        }
        for object in objects {
            cmd.bind(
                if object.atlas.tiled { &self.atlas } else { &self.continuous },
                &[
                    (0, Descriptor::Sampled(visible.texture.whole(), &self.nearest)),
                    (1, Descriptor::Sampled(visible.tangent.whole(), &self.nearest)),
                    (2, Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                    (3, Descriptor::Sampled(object.maps.slopes().whole(), &object.sampler)),
                    (4, Descriptor::Sampled(object.maps.joint().whole(), &object.sampler)),
                    (5, Descriptor::Sampled(object.color.whole(), &object.sampler)),
                    (6, Descriptor::Storage(&object.atlas.links)),
                    (7, Descriptor::Storage(&visible.tiles.records)),
                    (8, Descriptor::Sampled(object.atlas.slopes.whole(), &self.linear)),
                    (9, Descriptor::Sampled(object.atlas.joint.whole(), &self.linear)),
                    (10, Descriptor::Sampled(object.atlas.color.whole(), &self.linear)),
                    (11, Descriptor::Sampled(visible.depth.whole(), &self.nearest)),
                ],
            );
            let mut constants = object.constants(height_scale, false);
            constants.flags |= grid << FLAGS_GRID_SHIFT;
            cmd.push_constants(&FilteredObjectGpu::new(constants, rays, near));
            visible.tiles.draw(cmd);
        }
        cmd.end_rendering();
        for image in target.colors() {
            cmd.transition(image, Use::Sampled);
        }
    }
}
