//! The geometry of the drawn sea: rings of patches around the viewer, which the waves displace.

use std::sync::Arc;

use glam::{Mat4, Vec3};

use super::fields::{CascadeGpu, OceanFields};
use crate::constants::GUARD_BAND;
use crate::passes::geometry::{GeometryKind, guard_band};
use crate::passes::targets::GeometryTargets;
use crate::surfaces::numbering::Numbering;
use crate::surfaces::object_view::Viewpoint;
use crate::surfaces::ocean::mesh::{EARTH, RingLayout, Rings};
use crate::surfaces::ocean::shore::ShoreGpu;
use leadr_gpu::{
    AddressMode, Buffer, Commands, Depth, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Memory, Result,
    Sampler, SharedStruct, SpecValue, Topology as Primitive, shared_struct,
};

shared_struct! {
    struct VertexGpu for "Vertex" {
        position: [f32; 2],
        spacing: f32,
        unused: f32,
    }
}

shared_struct! {
    struct ViewGpu for "View" {
        clip_from_world: [[f32; 4]; 4],
        window: [f32; 4],
        centre: [f32; 4],
    }
}

/// The pipeline that draws the rings for one kind of geometry. Clones share the pipeline.
#[derive(Clone)]
pub struct OceanSurfacePass {
    pipeline: GraphicsPipeline,
}

/// The buffers of the rings, and the sampler of the waves. Clones share both.
#[derive(Clone)]
pub struct RingBuffers {
    vertices: Buffer,
    patches: Buffer,
    patch_edges: Buffer,
    edge_factors: Buffer,
    visible: Buffer,
    view: Buffer,
    trilinear: Sampler,
}

impl OceanSurfacePass {
    /// Creates the pass, with or without a shore.
    pub fn new(gpu: &Arc<Gpu>, kind: GeometryKind, shore: bool, numbering: Numbering) -> Result<Self> {
        let desc = GraphicsDesc {
            vertex: "passes/ocean/surface.vert",
            tessellation: Some(["passes/ocean/surface.tesc", "passes/ocean/surface.tese"]),
            fragment: Some("passes/ocean/surface.frag"),
            colors: &GeometryTargets::FORMATS,
            depth: Some(Depth::default()),
            samples: kind.samples(),
            wires: kind == GeometryKind::Wires,
            topology: Primitive::Patches(4),
            spec: &[("HAS_BEACH", SpecValue::Bool(shore)), kind.pixels(), numbering.spec()],
            structs: &[ViewGpu::LAYOUT, VertexGpu::LAYOUT, CascadeGpu::LAYOUT, ShoreGpu::LAYOUT],
            ..Default::default()
        };
        Ok(Self { pipeline: GraphicsPipeline::new(gpu, "ocean", &desc)? })
    }

    /// Draws the rings that were written last, displaced by the waves, into the active targets. `shore` is the block of
    /// [`ShoreGpu`].
    pub fn draw(
        &self,
        cmd: &mut Commands,
        target: &GeometryTargets,
        rings: &RingBuffers,
        laid: &RingLayout,
        fields: &OceanFields,
        shore: &Buffer,
    ) {
        guard_band(cmd, &target.depth);
        cmd.bind(
            &self.pipeline,
            &[
                ("view", Descriptor::Uniform(&rings.view)),
                ("Vertices", Descriptor::Storage(&rings.vertices)),
                ("Patches", Descriptor::Storage(&rings.patches)),
                ("Edges", Descriptor::Storage(&rings.patch_edges)),
                ("EdgeFactors", Descriptor::Storage(&rings.edge_factors)),
                ("VisiblePatches", Descriptor::Storage(&rings.visible)),
                ("Cascades", Descriptor::Storage(&fields.cascades)),
                ("displacement", Descriptor::Sampled(fields.displacement.whole(), &rings.trilinear)),
                ("Beach", Descriptor::Uniform(shore)),
            ],
        );
        for (first, count) in laid.list.draws.all() {
            cmd.draw(first * 4..(first + count) * 4, 0..1);
        }
    }
}

impl RingBuffers {
    /// Creates buffers for these rings.
    pub fn new(gpu: &Arc<Gpu>, rings: &Rings) -> Result<Self> {
        let Rings { mesh, topology } = rings;
        let buffer =
            |name: &str, count: usize, size: usize| Buffer::new(gpu, name, (count * size) as u64, Memory::Upload);
        Ok(Self {
            vertices: buffer("ocean vertices", mesh.positions.len(), size_of::<VertexGpu>())?,
            patches: Buffer::from_slice(gpu, "ocean patches", &mesh.patches)?,
            patch_edges: Buffer::from_slice(gpu, "ocean edges", &topology.patch_edges)?,
            edge_factors: buffer("ocean factors", topology.edges.len(), 4)?,
            visible: buffer("ocean visible patches", mesh.patches.len(), 4)?,
            view: buffer("ocean view", 1, size_of::<ViewGpu>())?,
            trilinear: Sampler::new(gpu, Filter::Trilinear, AddressMode::Repeat)?,
        })
    }

    /// Writes the rings around a viewer. `level` is the height of the water at rest in metres. The device must be idle.
    pub fn update(&self, laid: &RingLayout, from: &Viewpoint, level: f32) -> Result<()> {
        let RingLayout { positions, spacing, factors, list } = laid;
        let vertex = |(p, &spacing): (&Vec3, &f32)| VertexGpu { position: [p.x, p.y], spacing, unused: 0.0 };
        let vertices: Vec<VertexGpu> = positions.iter().zip(spacing).map(vertex).collect();
        self.vertices.write(0, &vertices)?;
        self.edge_factors.write(0, factors)?;
        self.visible.write(0, &list.visible)?;
        let shrink = Mat4::from_scale(Vec3::new(1.0 / GUARD_BAND, 1.0 / GUARD_BAND, 1.0));
        let view = ViewGpu {
            clip_from_world: (shrink * from.clip_from_world).to_cols_array_2d(),
            window: [from.size.0 as f32, from.size.1 as f32, 0.0, 0.0],
            centre: [from.lens.eye.x, from.lens.eye.y, level, 0.5 / EARTH],
        };
        self.view.write(0, &[view])
    }
}
