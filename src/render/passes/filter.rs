//! Filter pass: the slope statistics and the material under each pixel, fetched once per pixel.

use std::sync::Arc;

use glam::Vec3;

use super::targets::{GBuffer, VisibleSurface};
use crate::gpu::{
    AddressMode, ColorTarget, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Load, Result, Sampler,
    SharedStruct, SpecValue, Topology, Use,
};
use crate::render::settings::Needs;
use crate::render::surfaces::atlas::{AtlasHeadGpu, PatchLinkGpu};
use crate::render::surfaces::object::{FLAGS_GRID_SHIFT, FilteredObjectGpu, GpuObject};

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
    /// The pass for what a technique needs.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>, needs: Needs) -> Result<Self> {
        let pipeline = |name, atlas| {
            let spec = [needs.spec(), vec![("ATLAS", SpecValue::Bool(atlas))]].concat();
            GraphicsPipeline::new(
                gpu,
                name,
                &GraphicsDesc {
                    vertex: "passes/filter/filter.vert",
                    fragment: Some("passes/filter/filter.frag"),
                    colors: &GBuffer::FORMATS,
                    topology: Topology::Points,
                    spec: &spec,
                    structs: &[FilteredObjectGpu::LAYOUT, AtlasHeadGpu::LAYOUT, PatchLinkGpu::LAYOUT],
                    ..Default::default()
                },
            )
        };
        let (continuous, atlas) = (pipeline("filter", false)?, pipeline("filter atlas", true)?);
        Ok(Self {
            continuous,
            atlas,
            nearest: Sampler::new(gpu, "filter", Filter::Nearest, AddressMode::ClampToEdge)?,
            linear: Sampler::new(gpu, "coarse levels", Filter::Bilinear, AddressMode::ClampToEdge)?,
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
                    ("visible_texture", Descriptor::Sampled(visible.texture.whole(), &self.nearest)),
                    ("visible_tangent", Descriptor::Sampled(visible.tangent.whole(), &self.nearest)),
                    ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                    ("moments_a", Descriptor::Sampled(object.maps.slopes().whole(), &object.sampler)),
                    ("moments_b", Descriptor::Sampled(object.maps.joint().whole(), &object.sampler)),
                    ("color_map", Descriptor::Sampled(object.color.whole(), &object.sampler)),
                    ("Atlas", Descriptor::Storage(&object.atlas.links)),
                    ("TileRecords", Descriptor::Storage(&visible.tiles.records)),
                    ("coarse_a", Descriptor::Sampled(object.atlas.slopes.whole(), &self.linear)),
                    ("coarse_b", Descriptor::Sampled(object.atlas.joint.whole(), &self.linear)),
                    ("coarse_color", Descriptor::Sampled(object.atlas.color.whole(), &self.linear)),
                    ("visible_depth", Descriptor::Sampled(visible.depth.whole(), &self.nearest)),
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
