//! Geometry pass: tessellates, displaces and rasterises; each pixel learns what it sees.

use std::sync::Arc;

use super::targets::VisibleSurface;
use crate::gpu::{
    ColorTarget, Commands, Depth, DepthTarget, Descriptor, Gpu, GraphicsDesc, GraphicsPipeline, Image, Load, Result,
    Topology, Use,
};
use crate::render::surfaces::object::{GEOMETRY_STRUCTS, GpuObject, ViewBuffers};
use crate::render::surfaces::tessellation::GUARD_BAND;

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
                clockwise_front: true,
                topology: Topology::Patches(4),
                structs: &GEOMETRY_STRUCTS,
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
            ("view", Descriptor::Uniform(&view.view)),
            ("Vertices", Descriptor::Storage(&view.vertices)),
            ("Patches", Descriptor::Storage(&object.patches)),
            ("EdgeFactors", Descriptor::Storage(&view.edge_factors)),
            ("EdgeHeights", Descriptor::Storage(&object.edge_heights)),
            ("VertexHeights", Descriptor::Storage(&object.vertex_heights)),
            ("VisiblePatches", Descriptor::Storage(&view.visible)),
            ("height_map", Descriptor::Sampled(object.maps.heights().whole(), &object.sampler)),
        ],
    );
    cmd.push_constants(&object.constants(height_scale, mark_inside));
    for &(first, count) in &view.draws {
        cmd.draw(first * 4..(first + count) * 4, 0..1);
    }
}
