//! The drawn sea: its waves, its mesh moved by them, and the filter of what its pixels see. It writes the targets of the other
//! objects' passes.

use std::sync::Arc;

use glam::{Mat4, Vec3};

use super::fields::{CascadeGpu, Content, OceanFields};
use super::filter::OceanFilter;
use super::march::OceanMarch;
use crate::gpu::{
    AddressMode, Buffer, ColorTarget, Commands, Depth, DepthTarget, Descriptor, Filter, Gpu, GraphicsDesc,
    GraphicsPipeline, Load, Memory, Result, Sampler, SharedStruct, SpecValue, Timestamps, Topology as Primitive, Use,
    shared_struct,
};
use crate::render::passes::geometry::guard_band;
use crate::render::passes::targets::{GBuffer, VisibleSurface};
use crate::render::settings::{Needs, Shading};
use crate::render::surfaces::ocean::mesh::{EARTH, Laid, Rings, SeaView};
use crate::render::surfaces::ocean::shore::ShoreGpu;
use crate::render::surfaces::ocean::{Ocean, SEA_INDEX};
use crate::render::surfaces::tessellation::{GUARD_BAND, Lens, TessellationSettings};

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
        centre: [f32; 4],
    }
}

/// The passes of the sea.
pub struct OceanPass {
    /// The sea.
    pub ocean: Ocean,
    fields: OceanFields,
    /// Of the reference, from when it is first asked for.
    march: Option<OceanMarch>,
    rings: Rings,
    laid: Laid,
    pipeline: GraphicsPipeline,
    filter: OceanFilter,
    needs: Needs,
    vertices: Buffer,
    patches: Buffer,
    patch_edges: Buffer,
    edge_factors: Buffer,
    visible: Buffer,
    view: Buffer,
    shore: Buffer,
    deviations: Vec<f64>,
    trilinear: Sampler,
}

impl OceanPass {
    /// Uploads a sea.
    ///
    /// # Errors
    /// As [`OceanFields::new`].
    pub fn new(gpu: &Arc<Gpu>, ocean: Ocean) -> Result<Self> {
        let rings = Rings::default();
        let Rings { mesh, topology } = &rings;
        let buffer =
            |name: &str, count: usize, size: usize| Buffer::new(gpu, name, (count * size) as u64, Memory::Upload);
        Ok(Self {
            fields: OceanFields::new(gpu, &ocean.cascades, Content::Moments)?,
            march: None,
            pipeline: GraphicsPipeline::new(
                gpu,
                "ocean",
                &GraphicsDesc {
                    vertex: "passes/ocean/surface.vert",
                    tessellation: Some(["passes/ocean/surface.tesc", "passes/ocean/surface.tese"]),
                    fragment: Some("passes/ocean/surface.frag"),
                    colors: &[VisibleSurface::FORMAT; 3],
                    depth: Some(Depth::default()),
                    topology: Primitive::Patches(4),
                    spec: &[
                        ("SEA", SpecValue::U32(SEA_INDEX)),
                        ("GUARD_BAND", SpecValue::F32(GUARD_BAND)),
                        ("HAS_BEACH", SpecValue::Bool(ocean.shore.is_some())),
                    ],
                    structs: &[ViewGpu::LAYOUT, VertexGpu::LAYOUT, CascadeGpu::LAYOUT, ShoreGpu::LAYOUT],
                    ..Default::default()
                },
            )?,
            filter: OceanFilter::new(gpu)?,
            needs: Shading::default().needs(),
            vertices: buffer("ocean vertices", mesh.positions.len(), size_of::<VertexGpu>())?,
            patches: Buffer::from_slice(gpu, "ocean patches", &mesh.patches)?,
            patch_edges: Buffer::from_slice(gpu, "ocean edges", &topology.patch_edges)?,
            edge_factors: buffer("ocean factors", topology.edges.len(), 4)?,
            visible: buffer("ocean visible patches", mesh.patches.len(), 4)?,
            view: buffer("ocean view", 1, size_of::<ViewGpu>())?,
            shore: buffer("shore", 1, size_of::<ShoreGpu>())?,
            deviations: ocean.cascades.iter().map(|c| c.deviations()[0]).collect(),
            trilinear: Sampler::new(gpu, "ocean", Filter::Trilinear, AddressMode::Repeat)?,
            rings,
            laid: Laid::default(),
            ocean,
        })
    }

    /// Lays the rings around a viewer and chooses what is drawn, at `time` in seconds. The device must be idle.
    ///
    /// # Errors
    /// A failed pipeline or write.
    pub fn update(
        &mut self,
        gpu: &Arc<Gpu>,
        needs: Needs,
        time: f64,
        clip_from_world: Mat4,
        eye: Vec3,
        lens: Lens,
        tessellation: &TessellationSettings,
    ) -> Result<()> {
        self.needs = needs;
        self.filter.update(gpu, needs, &self.ocean, eye.truncate())?;
        if self.marches() {
            let march = match &mut self.march {
                Some(march) => march,
                none => none.insert(OceanMarch::new(gpu, &self.ocean.cascades)?),
            };
            march.update(clip_from_world, eye, lens.near, self.ocean.level)?;
        }
        let (level, deviation) = (self.ocean.level, self.ocean.height);
        self.laid = self.rings.lay(&SeaView { clip_from_world, lens, level, deviation }, tessellation);
        let Laid { positions, spacing, list } = &self.laid;
        let vertex = |(p, &spacing): (&Vec3, &f32)| VertexGpu { position: [p.x, p.y], spacing, unused: 0.0 };
        let vertices: Vec<VertexGpu> = positions.iter().zip(spacing).map(vertex).collect();
        self.vertices.write(0, &vertices)?;
        self.edge_factors.write(0, &list.edge_factors)?;
        if !list.visible.is_empty() {
            self.visible.write(0, &list.visible)?;
        }
        let shrink = Mat4::from_scale(Vec3::new(1.0 / GUARD_BAND, 1.0 / GUARD_BAND, 1.0));
        let view = ViewGpu {
            clip_from_world: (shrink * clip_from_world).to_cols_array_2d(),
            centre: [eye.x, eye.y, level, 0.5 / EARTH],
        };
        self.view.write(0, &[view])?;
        let shore = self.ocean.shore.as_ref();
        self.shore.write(0, &[shore.map_or_else(ShoreGpu::default, |s| ShoreGpu::new(s, time, &self.deviations))])
    }

    /// Records the waves at `time`, seconds, every pass `repeats` times and timed by itself: the waves moved to the present and
    /// their rows transformed, the columns with displacement and moments, the mips.
    pub fn record_waves(&self, cmd: &mut Commands, time: f64, repeats: u32, timestamps: &Timestamps) {
        let choppiness = self.ocean.choppiness;
        let fields = self.reference().map_or(&self.fields, OceanMarch::fields);
        cmd.label_times("wave rows", repeats, |cmd| fields.record_rows(cmd, time));
        cmd.timestamp(timestamps, "wave rows");
        cmd.label_times("wave columns", repeats, |cmd| fields.record_columns(cmd, choppiness));
        cmd.timestamp(timestamps, "wave columns");
        cmd.label_times("wave mips", repeats, |cmd| fields.record_mips(cmd));
        cmd.timestamp(timestamps, "wave mips");
    }

    /// The passes of the reference, where it is drawn.
    fn reference(&self) -> Option<&OceanMarch> {
        self.march.as_ref().filter(|_| self.marches())
    }

    /// Whether rays are marched, which know of no beach.
    fn marches(&self) -> bool {
        self.needs.is_finest() && self.ocean.shore.is_none()
    }

    /// Draws the sea over what the geometry pass left, and leaves the targets readable.
    pub fn record_geometry(&self, cmd: &mut Commands, target: &VisibleSurface) {
        for image in target.colors() {
            cmd.transition(image, Use::ColorTarget);
        }
        cmd.transition(&target.depth, Use::DepthTarget);
        let colors = target.colors().map(|image| ColorTarget { view: image.whole(), load: Load::Keep });
        cmd.begin_rendering(&colors, Some(DepthTarget { view: target.depth.whole(), clear: None }));
        match self.reference() {
            Some(march) => march.draw_geometry(cmd),
            None => self.draw_rings(cmd, target),
        }
        cmd.end_rendering();
        for image in target.colors() {
            cmd.transition(image, Use::Sampled);
        }
        cmd.transition(&target.depth, Use::Sampled);
    }

    fn draw_rings(&self, cmd: &mut Commands, target: &VisibleSurface) {
        guard_band(cmd, &target.depth);
        cmd.bind(
            &self.pipeline,
            &[
                ("view", Descriptor::Uniform(&self.view)),
                ("Vertices", Descriptor::Storage(&self.vertices)),
                ("Patches", Descriptor::Storage(&self.patches)),
                ("Edges", Descriptor::Storage(&self.patch_edges)),
                ("EdgeFactors", Descriptor::Storage(&self.edge_factors)),
                ("VisiblePatches", Descriptor::Storage(&self.visible)),
                ("Cascades", Descriptor::Storage(&self.fields.cascades)),
                ("displacement", Descriptor::Sampled(self.fields.displacement.whole(), &self.trilinear)),
                ("Beach", Descriptor::Uniform(&self.shore)),
            ],
        );
        for &(first, count) in &self.laid.list.draws {
            cmd.draw(first * 4..(first + count) * 4, 0..1);
        }
    }

    /// Filters the waves under the sea's pixels into a G-buffer that holds the other objects already.
    pub fn record_filter(&self, cmd: &mut Commands, visible: &VisibleSurface, target: &GBuffer) {
        self.filter.record(cmd, target, |cmd, water| match self.reference() {
            Some(march) => march.draw_filter(cmd, visible, water),
            None => self.filter.draw(cmd, self.needs, &self.fields, &self.shore, visible),
        });
    }

    /// Upper bound on the triangles that are drawn.
    #[must_use]
    pub fn triangles(&self) -> u64 {
        self.laid.list.triangles
    }

    /// Patches that are drawn.
    #[must_use]
    pub fn patches(&self) -> u32 {
        self.laid.list.visible.len() as u32
    }
}
