//! The drawn sea: rings of patches around the viewer from the feet to the horizon, moved by the waves, and the filter of what
//! its pixels see. Both write the targets of the other objects' passes.

use std::f32::consts::TAU;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec2, Vec3};

use super::fields::{Content, OceanFields};
use super::march::OceanMarch;
use super::waves::Cascade;
use crate::gpu::{
    Buffer, ColorTarget, Commands, Cull, Depth, DepthTarget, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline,
    Load, Memory, Result, Sampler, SpecValue, Topology as Primitive, Use, Wrap,
};
use crate::render::filter::GBuffer;
use crate::render::geometry::{VisibleSurface, guard_band};
use crate::render::patch_mesh::PatchMesh;
use crate::render::settings::Technique;
use crate::render::tessellation::{DrawList, GUARD_BAND, Lens, PosedMesh, TessellationSettings};
use crate::render::topology::Topology;

/// Index of the sea among the objects of a scene: the last of the G-buffer's seven bits.
pub const SEA_INDEX: u32 = 127;
/// Radius of the earth with the usual refraction of the air, metres.
pub const EARTH: f32 = 6.371e6 * 7.0 / 6.0;
/// Patches around the viewer.
const SPOKES: u32 = 48;
/// Rings of them.
const RINGS: u32 = 96;

/// A sea: its waves and its water.
#[derive(Clone, Debug)]
pub struct Ocean {
    /// Tiles of waves, longest first; equal resolutions.
    pub cascades: Vec<Cascade>,
    /// Standard deviation of the height, metres.
    pub height: f32,
    /// Slope covariance `xx, yy, xy` of the waves that no cascade carries.
    pub tail: Vec3,
    /// Horizontal movement of the waves: 1 is water's, 0 none.
    pub choppiness: f32,
    /// Height of the water at rest, metres.
    pub level: f32,
    /// Diffuse albedo of what comes up out of the water, linear.
    pub color: Vec3,
    /// Diffuse albedo of foam, linear.
    pub foam: Vec3,
    /// The sea foams where its horizontal stretch ([`OceanFields::joint`]) is below this: 1 is the sea at rest, 0 for no foam.
    pub foam_threshold: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct VertexGpu {
    position: [f32; 2],
    spacing: f32,
    unused: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ViewGpu {
    clip_from_world: [[f32; 4]; 4],
    centre: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct WaterGpu {
    centre: [f32; 4],
    tail: [f32; 4],
    color: [f32; 4],
    foam: [f32; 4],
}

/// The passes of the sea.
pub struct OceanPass {
    /// The sea.
    pub ocean: Ocean,
    fields: OceanFields,
    /// Of the reference, from when it is first asked for.
    march: Option<OceanMarch>,
    mesh: PatchMesh,
    topology: Topology,
    pipeline: GraphicsPipeline,
    filter: GraphicsPipeline,
    technique: Technique,
    vertices: Buffer,
    patches: Buffer,
    patch_edges: Buffer,
    edge_factors: Buffer,
    visible: Buffer,
    view: Buffer,
    water: Buffer,
    trilinear: Sampler,
    nearest: Sampler,
    list: DrawList,
}

impl OceanPass {
    /// Uploads a sea.
    ///
    /// # Errors
    /// As [`OceanFields::new`].
    pub fn new(gpu: &Arc<Gpu>, ocean: Ocean) -> Result<Self> {
        let mesh = rings();
        let topology = Topology::new(&mesh.patches);
        let buffer =
            |name: &str, count: usize, size: usize| Buffer::new(gpu, name, (count * size) as u64, Memory::Upload);
        let technique = Technique::Leadr;
        Ok(Self {
            fields: OceanFields::new(gpu, &ocean.cascades, Content::Moments)?,
            march: None,
            ocean,
            pipeline: GraphicsPipeline::new(
                gpu,
                "ocean",
                &GraphicsDesc {
                    vertex: "passes/ocean/surface.vert",
                    tessellation: Some(["passes/ocean/surface.tesc", "passes/ocean/surface.tese"]),
                    fragment: Some("passes/ocean/surface.frag"),
                    colors: &[VisibleSurface::FORMAT; 3],
                    depth: Some(Depth::default()),
                    cull: Cull::None,
                    topology: Primitive::Patches(4),
                    spec: &[(0, SpecValue::U32(SEA_INDEX))],
                    ..Default::default()
                },
            )?,
            filter: filter_pipeline(gpu, technique)?,
            technique,
            vertices: buffer("ocean vertices", mesh.positions.len(), size_of::<VertexGpu>())?,
            patches: Buffer::from_slice(gpu, "ocean patches", &mesh.patches)?,
            patch_edges: Buffer::from_slice(gpu, "ocean edges", &topology.patch_edges)?,
            edge_factors: buffer("ocean factors", topology.edges.len(), 4)?,
            visible: buffer("ocean visible patches", mesh.patches.len(), 4)?,
            view: buffer("ocean view", 1, size_of::<ViewGpu>())?,
            water: buffer("water", 1, size_of::<WaterGpu>())?,
            trilinear: Sampler::new(gpu, "ocean", Filter::Trilinear, Wrap::Repeat)?,
            nearest: Sampler::new(gpu, "ocean pixels", Filter::Nearest, Wrap::Clamp)?,
            mesh,
            topology,
            list: DrawList::default(),
        })
    }

    /// Lays the rings around a viewer and chooses what is drawn. The device must be idle.
    ///
    /// # Errors
    /// A failed pipeline or write.
    pub fn update(
        &mut self,
        gpu: &Arc<Gpu>,
        technique: Technique,
        clip_from_world: Mat4,
        eye: Vec3,
        lens: Lens,
        tessellation: &TessellationSettings,
    ) -> Result<()> {
        if self.technique != technique {
            self.filter = filter_pipeline(gpu, technique)?;
            self.technique = technique;
        }
        let level = self.ocean.level;
        if technique == Technique::Reference {
            let march = match &mut self.march {
                Some(march) => march,
                none => none.insert(OceanMarch::new(gpu, &self.ocean.cascades)?),
            };
            march.update(clip_from_world, eye, lens.near, level)?;
        }
        let height = (eye.z - level).abs().max(0.5);
        let horizon = (2.0 * EARTH * height).sqrt();
        let centre = eye.truncate();
        let amplitude = 4.0 * self.ocean.height;
        // From the feet to beyond the horizon of the highest waves.
        let (first, last) = (0.2 * height, horizon + (2.0 * EARTH * amplitude).sqrt());
        let radius = |ring: f32| {
            if ring <= 0.0 { 0.0 } else { first * (last / first).powf((ring - 1.0) / (RINGS as f32 - 1.0)) }
        };
        let drop = |away: Vec2| away.length_squared() / (2.0 * EARTH);
        let positions: Vec<Vec3> = self
            .mesh
            .positions
            .iter()
            .map(|p| {
                let away = Vec2::new(p.x, p.y) * radius(p.z);
                (centre + away).extend(level - drop(away))
            })
            .collect();
        let relief = vec![amplitude; self.topology.edges.len()];
        let range = vec![[-amplitude, amplitude]; self.mesh.patches.len()];
        let posed = PosedMesh {
            mesh: &self.mesh,
            topology: &self.topology,
            positions: &positions,
            normals: &self.mesh.normals,
            edge_texels: &[],
            edge_relief: &relief,
            height_range: &range,
            height_scale: 1.0,
        };
        let settings = TessellationSettings { to_texels: false, ..*tessellation };
        self.list = DrawList::new(posed, clip_from_world, lens, &settings);
        let mut spacing = vec![(0.0f32, 0.0f32); positions.len()];
        for (&[a, b], &factor) in self.topology.edges.iter().zip(&self.list.edge_factors) {
            let length = positions[a as usize].distance(positions[b as usize]) / factor;
            for vertex in [a, b] {
                spacing[vertex as usize].0 += length;
                spacing[vertex as usize].1 += 1.0;
            }
        }
        let vertices: Vec<VertexGpu> = positions
            .iter()
            .zip(&spacing)
            .map(|(p, &(sum, count))| VertexGpu { position: [p.x, p.y], spacing: sum / count.max(1.0), unused: 0.0 })
            .collect();
        self.vertices.write(0, &vertices)?;
        self.edge_factors.write(0, &self.list.edge_factors)?;
        if !self.list.visible.is_empty() {
            self.visible.write(0, &self.list.visible)?;
        }
        let shrink = Mat4::from_scale(Vec3::new(1.0 / GUARD_BAND, 1.0 / GUARD_BAND, 1.0));
        let view = ViewGpu {
            clip_from_world: (shrink * clip_from_world).to_cols_array_2d(),
            centre: [centre.x, centre.y, level, 0.5 / EARTH],
        };
        self.view.write(0, &[view])?;
        let o = &self.ocean;
        let water = WaterGpu {
            centre: [centre.x, centre.y, 1.0 / EARTH, 0.0],
            tail: o.tail.extend(WATER_ROUGHNESS).to_array(),
            color: o.color.extend(WATER_F0).to_array(),
            foam: o.foam.extend(if o.foam_threshold > 0.0 { o.foam_threshold } else { -1e9 }).to_array(),
        };
        self.water.write(0, &[water])
    }

    /// Records the waves at `time`, seconds.
    pub fn record_waves(&self, cmd: &mut Commands, time: f64) {
        match self.reference() {
            Some(march) => march.record_waves(cmd, time, self.ocean.choppiness),
            None => self.fields.record(cmd, time, self.ocean.choppiness),
        }
    }

    /// The passes of the reference, where it is drawn.
    fn reference(&self) -> Option<&OceanMarch> {
        self.march.as_ref().filter(|_| self.technique == Technique::Reference)
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
                (0, Descriptor::Uniform(&self.view)),
                (1, Descriptor::Storage(&self.vertices)),
                (2, Descriptor::Storage(&self.patches)),
                (3, Descriptor::Storage(&self.patch_edges)),
                (4, Descriptor::Storage(&self.edge_factors)),
                (5, Descriptor::Storage(&self.visible)),
                (6, Descriptor::Storage(&self.fields.cascades)),
                (7, Descriptor::Sampled(self.fields.displacement.whole(), &self.trilinear)),
            ],
        );
        for &(first, count) in &self.list.draws {
            cmd.draw(first * 4..(first + count) * 4, 0..1);
        }
    }

    /// Filters the waves under the sea's pixels into a G-buffer that holds the other objects already.
    pub fn record_filter(&self, cmd: &mut Commands, visible: &VisibleSurface, target: &GBuffer) {
        for image in target.colors() {
            cmd.transition(image, Use::ColorTarget);
        }
        let colors = target.colors().map(|image| ColorTarget { view: image.whole(), load: Load::Keep });
        cmd.begin_rendering(&colors, None);
        match self.reference() {
            Some(march) => march.draw_filter(cmd, visible, &self.water),
            None => self.draw_filter(cmd, visible),
        }
        cmd.end_rendering();
        for image in target.colors() {
            cmd.transition(image, Use::Sampled);
        }
    }

    fn draw_filter(&self, cmd: &mut Commands, visible: &VisibleSurface) {
        cmd.bind(
            &self.filter,
            &[
                (0, Descriptor::Sampled(visible.texture.whole(), &self.nearest)),
                (1, Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                (2, Descriptor::Sampled(self.fields.slopes.whole(), &self.trilinear)),
                (3, Descriptor::Sampled(self.fields.joint.whole(), &self.trilinear)),
                (4, Descriptor::Storage(&self.fields.cascades)),
                (5, Descriptor::Uniform(&self.water)),
            ],
        );
        cmd.draw(0..3, 0..1);
    }

    /// Upper bound on the triangles that are drawn.
    #[must_use]
    pub fn triangles(&self) -> u64 {
        self.list.triangles
    }
}

/// Beckmann roughness of the water itself, below all waves.
const WATER_ROUGHNESS: f32 = 0.01;
/// Reflectance of water at normal incidence.
const WATER_F0: f32 = 0.02;

fn filter_pipeline(gpu: &Arc<Gpu>, technique: Technique) -> Result<GraphicsPipeline> {
    GraphicsPipeline::new(
        gpu,
        "ocean filter",
        &GraphicsDesc {
            vertex: "passes/fullscreen.vert",
            fragment: Some("passes/ocean/filter.frag"),
            colors: &GBuffer::FORMATS,
            spec: &[(0, SpecValue::I32(technique.code())), (1, SpecValue::U32(SEA_INDEX))],
            ..Default::default()
        },
    )
}

/// Rings of patches: direction in xy, number of the ring in z (0 is the centre).
fn rings() -> PatchMesh {
    let mut mesh = PatchMesh::default();
    for ring in 0..=RINGS {
        for spoke in 0..SPOKES {
            let (sin, cos) = (TAU * spoke as f32 / SPOKES as f32).sin_cos();
            mesh.positions.push(Vec3::new(cos, sin, ring as f32));
            mesh.normals.push(Vec3::Z);
        }
    }
    for ring in 0..RINGS {
        for spoke in 0..SPOKES {
            let next = (spoke + 1) % SPOKES;
            let at = |ring: u32, spoke: u32| ring * SPOKES + spoke;
            mesh.patches.push([at(ring, spoke), at(ring + 1, spoke), at(ring + 1, next), at(ring, next)]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_face_up_and_meet() {
        let mesh = rings();
        assert_eq!(mesh.patches.len(), (RINGS * SPOKES) as usize);
        for patch in mesh.patches.iter().skip(SPOKES as usize) {
            let p = patch.map(|v| {
                let p = mesh.positions[v as usize];
                Vec2::new(p.x, p.y) * p.z
            });
            assert!((p[2] - p[0]).perp_dot(p[3] - p[1]) > 0.0);
        }
        let topology = Topology::new(&mesh.patches);
        // Open are the outermost ring, and the innermost, which is one point.
        assert_eq!(topology.irregular_edges(), 2 * SPOKES as usize);
    }
}
