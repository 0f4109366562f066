//! Geometry pass: tessellates, displaces and rasterises; for each pixel it stores the visible surface.

use std::sync::Arc;

use super::targets::VisibleSurface;
use crate::gpu::{
    Commands, Depth, Descriptor, Gpu, GraphicsDesc, GraphicsPipeline, Image, Result, SpecValue, Topology,
};
use crate::render::constants::GUARD_BAND;
use crate::render::surfaces::object_view::{DrawnObject, GEOMETRY_STRUCTS, PosedObject};
use crate::render::view::Samples;

/// Pipelines of the geometry pass.
#[derive(Clone)]
pub struct GeometryPass {
    pixels: GraphicsPipeline,
    edges: GraphicsPipeline,
}

impl GeometryPass {
    /// The pass. It draws both sides of a surface: a closed surface hides its own inside.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let pipeline = |edges: bool| {
            let desc = GraphicsDesc {
                vertex: "passes/geometry/geometry.vert",
                tessellation: Some(["passes/geometry/geometry.tesc", "passes/geometry/geometry.tese"]),
                fragment: Some("passes/geometry/geometry.frag"),
                colors: &VisibleSurface::FORMATS,
                // Only edge samples have a footprint of their own.
                kept_colors: usize::from(!edges),
                depth: Some(Depth::default()),
                clockwise_front: true,
                topology: Topology::Patches(4),
                spec: &[("EDGES", SpecValue::Bool(edges))],
                structs: &GEOMETRY_STRUCTS,
            };
            GraphicsPipeline::new(gpu, if edges { "geometry of edges" } else { "geometry" }, &desc)
        };
        Ok(Self { pixels: pipeline(false)?, edges: pipeline(true)? })
    }

    /// Draws objects into the begun targets, as `samples` see them; `mark_inside` paints back faces in a marker colour.
    pub fn draw<'a>(
        &self,
        cmd: &mut Commands,
        target: &VisibleSurface,
        samples: Samples,
        objects: impl Iterator<Item = DrawnObject<'a>>,
        mark_inside: bool,
    ) {
        let pipeline = match samples {
            Samples::Pixels => &self.pixels,
            Samples::Edges { .. } => &self.edges,
        };
        guard_band(cmd, &target.depth);
        for object in objects {
            draw_object(cmd, pipeline, object, mark_inside);
        }
    }
}

/// Sets a viewport of [`GUARD_BAND`] times the target's size, and a scissor of the target alone.
pub(crate) fn guard_band(cmd: &mut Commands, target: &Image) {
    let [width, height] = target.mip_extent(0);
    let (w, h) = (width as f32, height as f32);
    let margin = (GUARD_BAND - 1.0) / 2.0;
    cmd.viewport([-margin * w, -margin * h, GUARD_BAND * w, GUARD_BAND * h]);
    cmd.scissor([0, 0, width, height]);
}

/// Binds and draws one object; shared with the shadow passes.
pub(crate) fn draw_object(cmd: &mut Commands, pipeline: &GraphicsPipeline, drawn: DrawnObject<'_>, mark_inside: bool) {
    let DrawnObject { posed: PosedObject { object, height_scale, .. }, view } = drawn;
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
    cmd.push_constants(&object.constants(*height_scale, mark_inside));
    for &(first, count) in &view.draws {
        cmd.draw(first * 4..(first + count) * 4, 0..1);
    }
}
