//! Filter pass: fetches the slope statistics and the material under each pixel, once per pixel.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use super::targets::{GBuffer, VisibleSurface};
use glam::Vec3;

use crate::gpu::{
    AddressMode, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Result, Sampler, SharedStruct,
    SpecValue, Topology, shared_struct,
};
use crate::render::constants::FLAGS_GRID_SHIFT;
use crate::render::settings::Needs;
use crate::render::surfaces::atlas::{AtlasHeadGpu, PatchLinkGpu};
use crate::render::surfaces::flat::Chart;
use crate::render::surfaces::object::{ObjectGpu, PatchGpu, SurfaceKind};
use crate::render::surfaces::object_view::{DrawnObject, PosedObject, VertexGpu};
use crate::render::view::{Samples, View};

/// Pipelines of the filter pass.
#[derive(Clone)]
pub struct FilterPass {
    pipelines: HashMap<SurfaceKind, GraphicsPipeline>,
    nearest: Sampler,
    linear: Sampler,
}

impl FilterPass {
    /// The pass for the inputs that a technique needs, and for objects of these kinds. `relief_drawn`: whether the geometry
    /// is displaced by as much as the maps say.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(
        gpu: &Arc<Gpu>,
        needs: Needs,
        relief_drawn: bool,
        objects: impl Iterator<Item = SurfaceKind>,
    ) -> Result<Self> {
        let mut pipelines = HashMap::new();
        for kind in objects {
            if let Entry::Vacant(place) = pipelines.entry(kind) {
                place.insert(Self::pipeline(gpu, needs, relief_drawn, kind)?);
            }
        }
        Ok(Self {
            pipelines,
            nearest: Sampler::new(gpu, "filter", Filter::Nearest, AddressMode::ClampToEdge)?,
            linear: Sampler::new(gpu, "coarse levels", Filter::Bilinear, AddressMode::ClampToEdge)?,
        })
    }

    fn pipeline(gpu: &Arc<Gpu>, needs: Needs, relief_drawn: bool, kind: SurfaceKind) -> Result<GraphicsPipeline> {
        let has = [
            ("ATLAS", SpecValue::Bool(kind.tiled)),
            ("DISPLACED", SpecValue::Bool(kind.displaced)),
            ("COLORED", SpecValue::Bool(kind.colored)),
            ("HORIZON", SpecValue::Bool(kind.horizon)),
            ("FLAT", SpecValue::Bool(kind.flat)),
            ("PLAIN", SpecValue::Bool(kind.plain)),
            ("RELIEF_DRAWN", SpecValue::Bool(relief_drawn)),
        ];
        let desc = GraphicsDesc {
            vertex: "passes/filter/filter.vert",
            fragment: Some("passes/filter/filter.frag"),
            colors: &GBuffer::FORMATS,
            topology: Topology::Points,
            spec: &[&needs.spec()[..], &has].concat(),
            structs: &[
                FilteredObjectGpu::LAYOUT,
                AtlasHeadGpu::LAYOUT,
                PatchLinkGpu::LAYOUT,
                VertexGpu::LAYOUT,
                PatchGpu::LAYOUT,
            ],
            ..Default::default()
        };
        GraphicsPipeline::new(gpu, if kind.tiled { "filter atlas" } else { "filter" }, &desc)
    }

    /// Filters the maps of `objects` into the begun G-buffer, at the pixels of a view that see them. `height_scale`
    /// multiplies the height scale of every object. The pass must know their kinds.
    pub fn draw<'a>(
        &self,
        cmd: &mut Commands,
        visible: &VisibleSurface,
        view: &View,
        objects: impl Iterator<Item = DrawnObject<'a>>,
        height_scale: f32,
    ) {
        for DrawnObject { posed, view: buffers } in objects {
            let object = &posed.object;
            cmd.bind(
                &self.pipelines[&object.kind],
                &[
                    ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                    ("visible_footprint", Descriptor::Sampled(visible.footprint.whole(), &self.nearest)),
                    ("Vertices", Descriptor::Storage(&buffers.vertices)),
                    ("Patches", Descriptor::Storage(&object.patches)),
                    ("height_map", Descriptor::Sampled(object.maps.heights().whole(), &object.sampler)),
                    ("moments_a", Descriptor::Sampled(object.maps.slopes().whole(), &object.sampler)),
                    ("moments_b", Descriptor::Sampled(object.maps.joint().whole(), &object.sampler)),
                    ("horizon_a", Descriptor::Sampled(object.horizons.leans().whole(), &object.sampler)),
                    ("horizon_b", Descriptor::Sampled(object.horizons.correlations().whole(), &object.sampler)),
                    ("color_map", Descriptor::Sampled(object.color.whole(), &object.sampler)),
                    ("Atlas", Descriptor::Storage(&object.atlas.links)),
                    ("TileRecords", Descriptor::Storage(&visible.tiles.records)),
                    ("coarse_a", Descriptor::Sampled(object.atlas.slopes.whole(), &self.linear)),
                    ("coarse_b", Descriptor::Sampled(object.atlas.joint.whole(), &self.linear)),
                    ("coarse_color", Descriptor::Sampled(object.atlas.color.whole(), &self.linear)),
                    ("visible_depth", Descriptor::Sampled(visible.depth.whole(), &self.nearest)),
                ],
            );
            cmd.push_constants(&FilteredObjectGpu::new(posed, height_scale, view));
            visible.tiles.draw(cmd);
        }
    }
}

shared_struct! {
    /// Push constants of the pass (`passes/geometry/object.glsl`).
    struct FilteredObjectGpu for "Object" {
        height_scale: f32,
        specular_f0: f32,
        flags: u32,
        index: u32,
        relief: f32,
        eye: [f32; 3],
        ray_x: [f32; 4],
        ray_y: [f32; 4],
        ray_middle: [f32; 4],
        tangent_s: [f32; 4],
        tangent_t: [f32; 4],
        color: [f32; 4],
    }
}

impl FilteredObjectGpu {
    fn new(posed: &PosedObject, height_scale: f32, view: &View) -> Self {
        let PosedObject { object, vertices, .. } = posed;
        let ObjectGpu { height_scale, specular_f0, mut flags, index, relief } = object.constants(height_scale, false);
        if let Samples::Edges { grid } = view.samples {
            flags |= grid << FLAGS_GRID_SHIFT;
        }
        let [x, y, middle] = view.rays();
        let mesh = &object.object.mesh;
        let chart = if object.kind.flat { Chart::of(mesh, vertices) } else { None };
        let Chart { tangent_s, tangent_t, outward } =
            chart.unwrap_or(Chart { tangent_s: Vec3::X, tangent_t: Vec3::Y, outward: true });
        let normal = tangent_s.cross(tangent_t).normalize_or_zero() * if outward { 1.0 } else { -1.0 };
        let above = vertices.positions.first().map_or(0.0, |&p| normal.dot(view.camera.position - p));
        Self {
            height_scale,
            specular_f0,
            flags,
            index,
            relief,
            eye: if object.kind.flat { [0.0, 0.0, above] } else { view.camera.position.to_array() },
            ray_x: x.extend(0.0).to_array(),
            ray_y: y.extend(0.0).to_array(),
            ray_middle: middle.extend(view.camera.near).to_array(),
            tangent_s: tangent_s.extend(if outward { 1.0 } else { -1.0 }).to_array(),
            tangent_t: tangent_t.extend(mesh.accessibility_of(0)).to_array(),
            color: mesh.color_of(0),
        }
    }
}
