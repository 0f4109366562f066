//! Geometry pass: tessellates, displaces and rasterises; each pixel learns what it sees.

use std::sync::Arc;

use ash::vk;

use super::tiles::Tiles;
use crate::gpu::{
    ColorTarget, Commands, Cull, Depth, DepthTarget, Descriptor, Gpu, GraphicsDesc, GraphicsPipeline, Image, ImageDesc,
    Load, Result, Topology, Use,
};
use crate::render::surfaces::object::{GpuObject, ViewBuffers};
use crate::render::surfaces::tessellation::GUARD_BAND;

/// What the geometry stages leave behind for each pixel, 52 bytes: enough to filter its maps.
pub struct VisibleSurface {
    /// Texture coordinate and derivatives; RGBA32UI.
    pub texture: Image,
    /// Displacement direction and tangents; RGBA32UI.
    pub tangent: Image,
    /// Object and patch (0 where nothing is), macro curvature, accessibility, colour; RGBA32UI.
    pub surface: Image,
    /// Reversed depth, 0 where nothing is; D32F.
    pub depth: Image,
    /// What its tiles show, when [`TilePass`](super::tiles::TilePass) has looked.
    pub tiles: Tiles,
}

impl VisibleSurface {
    /// Format of the colour targets.
    pub const FORMAT: vk::Format = vk::Format::R32G32B32A32_UINT;

    /// Targets of `size` pixels.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let color = |name: &str| Image::new(gpu, name, ImageDesc::new(Self::FORMAT, size.0, size.1).color_target());
        // The edge pass marks in it.
        let surface = ImageDesc::new(Self::FORMAT, size.0, size.1).color_target().storage();
        let depth = ImageDesc::new(vk::Format::D32_SFLOAT, size.0, size.1).depth_target();
        Ok(Self {
            texture: color("visible texture")?,
            tangent: color("visible tangent")?,
            surface: Image::new(gpu, "visible surface", surface)?,
            depth: Image::new(gpu, "depth", depth)?,
            tiles: Tiles::new(gpu, size)?,
        })
    }

    /// The colour targets in the order of their attachments.
    #[must_use]
    pub fn colors(&self) -> [&Image; 3] {
        [&self.texture, &self.tangent, &self.surface]
    }
}

/// Pipeline of the geometry pass.
pub struct GeometryPass {
    pipeline: GraphicsPipeline,
}

impl GeometryPass {
    /// The pass. Nothing is culled by facing: a closed surface hides its own inside.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let pipeline = GraphicsPipeline::new(
            gpu,
            "geometry",
            &GraphicsDesc {
                vertex: "passes/geometry/geometry.vert",
                tessellation: Some(["passes/geometry/geometry.tesc", "passes/geometry/geometry.tese"]),
                fragment: Some("passes/geometry/geometry.frag"),
                colors: &[VisibleSurface::FORMAT; 3],
                depth: Some(Depth::default()),
                cull: Cull::None,
                clockwise_front: true,
                topology: Topology::Patches(4),
                ..Default::default()
            },
        )?;
        Ok(Self { pipeline })
    }

    /// Clears the targets, draws the objects, and leaves the targets readable.
    pub fn record(
        &self,
        cmd: &mut Commands,
        target: &VisibleSurface,
        objects: &[(&GpuObject, &ViewBuffers)],
        height_scale: f32,
        mark_inside: bool,
    ) {
        for image in target.colors() {
            cmd.image_barrier(image, Use::Undefined, Use::ColorTarget);
        }
        cmd.image_barrier(&target.depth, Use::Undefined, Use::DepthTarget);
        let colors = target.colors().map(|image| ColorTarget { view: image.whole(), load: Load::ClearUint([0; 4]) });
        cmd.begin_rendering(&colors, Some(DepthTarget { view: target.depth.whole(), clear: Some(0.0) }));
        guard_band(cmd, &target.depth);
        for (object, view) in objects {
            draw_object(cmd, &self.pipeline, object, view, height_scale, mark_inside);
        }
        cmd.end_rendering();
        for image in target.colors() {
            cmd.transition(image, Use::Sampled);
        }
        cmd.transition(&target.depth, Use::Sampled);
    }
}

/// Sets the viewport of [`GUARD_BAND`] around a target and cuts the target out of it.
pub(crate) fn guard_band(cmd: &mut Commands, target: &Image) {
    let [width, height] = target.mip_extent(0);
    let (w, h) = (width as f32, height as f32);
    let margin = (GUARD_BAND - 1.0) / 2.0;
    cmd.viewport([-margin * w, -margin * h, GUARD_BAND * w, GUARD_BAND * h]);
    cmd.scissor([0, 0, width, height]);
}

/// Binds and draws one object; shared with the shadow pass.
pub(crate) fn draw_object(
    cmd: &mut Commands,
    pipeline: &GraphicsPipeline,
    object: &GpuObject,
    view: &ViewBuffers,
    height_scale: f32,
    mark_inside: bool,
) {
    if view.draws.is_empty() {
        return;
    }
    cmd.bind(
        pipeline,
        &[
            (0, Descriptor::Uniform(&view.view)),
            (1, Descriptor::Storage(&view.vertices)),
            (2, Descriptor::Storage(&object.patches)),
            (3, Descriptor::Storage(&view.edge_factors)),
            (4, Descriptor::Storage(&object.edge_heights)),
            (5, Descriptor::Storage(&object.vertex_heights)),
            (6, Descriptor::Storage(&view.visible)),
            (7, Descriptor::Sampled(object.maps.heights().whole(), &object.sampler)),
        ],
    );
    cmd.push_constants(&object.constants(height_scale, mark_inside));
    for &(first, count) in &view.draws {
        cmd.draw(first * 4..(first + count) * 4, 0..1);
    }
}
