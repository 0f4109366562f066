//! A posed object, and its buffers for one view.

use std::sync::Arc;

use glam::{Mat4, Vec3};

use super::object::{GpuObject, ObjectGpu, PatchGpu};
use super::patch_mesh::{PatchMesh, PosedVertices};
use super::sphere::Sphere;
use super::tessellation::{DrawList, Draws, Lens, PosedMesh, TessellationSettings};
use crate::gpu::{Buffer, Gpu, Memory, Result, SharedStruct, StructLayout, shared_struct};
use crate::render::constants::GUARD_BAND;
use crate::render::view::View;

shared_struct! {
    /// One vertex as the shaders read it (`Vertex` in `passes/geometry/interface.glsl`).
    pub struct VertexGpu for "Vertex" {
        /// World position; w: ambient accessibility.
        pub position: [f32; 4],
        /// World displacement direction; w: LOD of the boundary heights.
        pub normal: [f32; 4],
        /// Linear albedo; a: Beckmann roughness.
        pub color: [f32; 4],
    }
}

shared_struct! {
    /// The view block (`View`).
    pub struct ViewGpu for "View" {
        /// World to the clip space of a viewport that is [`GUARD_BAND`] times the size of the image.
        pub clip_from_world: [[f32; 4]; 4],
        /// Position of the viewer; w: number of samples of this image along a side of a pixel of the picture.
        pub camera_position: [f32; 4],
        /// x: metres per repeat of the map if a vertex stands at the centre of each of its texels, else 0; yz: size of the image,
        /// pixels.
        pub texel_grid: [f32; 4],
    }
}

/// The structs that the stages of the geometry pass share.
pub const GEOMETRY_STRUCTS: [StructLayout; 4] =
    [ViewGpu::LAYOUT, VertexGpu::LAYOUT, PatchGpu::LAYOUT, ObjectGpu::LAYOUT];

/// An object in the pose of a frame.
pub struct PosedObject {
    /// The object on the device.
    pub object: Arc<GpuObject>,
    /// Its vertices in the world.
    pub vertices: PosedVertices,
    /// Factor on the object's own height scale for the displacement; 0 leaves the geometry smooth.
    pub height_scale: f32,
}

impl PosedObject {
    /// Mean world length of a height texel; infinite for an object without heights.
    #[must_use]
    pub fn texel_length(&self) -> f32 {
        let positions = &self.vertices.positions;
        let lengths =
            self.object.topology.edges.iter().map(|e| positions[e[0] as usize].distance(positions[e[1] as usize]));
        let texels: f32 = self.object.edge_texels.iter().sum();
        if texels > 0.0 { lengths.sum::<f32>() / texels } else { f32::INFINITY }
    }

    /// A bounding sphere that includes the bumps.
    #[must_use]
    pub fn bounds(&self) -> Sphere {
        let (low, high) = self
            .vertices
            .positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        Sphere { centre: (low + high) * 0.5, radius: low.distance(high) * 0.5 + self.highest_bump() }
    }

    /// The largest distance between the displaced and the smooth surface, metres.
    #[must_use]
    pub fn highest_bump(&self) -> f32 {
        let bump = self.object.height_range.iter().flatten().fold(0.0f32, |a, h| a.max(h.abs()));
        bump * (self.height_scale * self.object.object.height_scale).abs()
    }
}

/// The place from which a surface is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// World to clip space.
    pub clip_from_world: Mat4,
    /// Position of the viewer, or a point on the light's side.
    pub eye: Vec3,
    /// The camera's lens, also when a light's map is drawn: casters must be tessellated exactly as the camera sees them.
    pub lens: Lens,
    /// Number of samples along a side of a pixel in which the lens measures.
    pub grid: u32,
    /// Samples across and down the image.
    pub size: (u32, u32),
}

impl From<&View> for Viewpoint {
    fn from(view: &View) -> Self {
        let (clip_from_world, eye) = (view.clip_from_world(), view.camera.position);
        Self { clip_from_world, eye, lens: view.lens(), grid: view.grid(), size: view.size() }
    }
}

/// An object as a geometry pipeline draws it.
#[derive(Clone, Copy)]
pub struct DrawnObject<'a> {
    /// The object.
    pub posed: &'a PosedObject,
    /// Its buffers, prepared for the view.
    pub view: &'a ViewBuffers,
}

/// The buffers of one object in one view (the camera's, or that of the sun's shadow map). Clones share the buffers, but
/// each has its own list of draws.
#[derive(Clone)]
pub struct ViewBuffers {
    /// `Vertex` of every vertex.
    pub vertices: Buffer,
    /// Tessellation factor of each edge.
    pub edge_factors: Buffer,
    /// Patches to draw.
    pub visible: Buffer,
    /// The [`ViewGpu`] block.
    pub view: Buffer,
    /// Draws over `visible`.
    pub draws: Draws,
    /// Whether a vertex stands at the centre of each texel of the heights.
    pub at_texels: bool,
    /// Upper bound on the triangles of these draws.
    pub triangles: u64,
    /// Number of visible patches.
    pub patches: u32,
}

impl ViewBuffers {
    /// Buffers large enough for every patch of the object.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn new(gpu: &Arc<Gpu>, object: &GpuObject, view: &str) -> Result<Self> {
        let name = &object.object.name;
        let buffer = |what: &str, count: usize, size: usize| {
            Buffer::new(gpu, &format!("{name} {view} {what}"), (count.max(1) * size) as u64, Memory::Upload)
        };
        let mesh = &object.object.mesh;
        Ok(Self {
            vertices: buffer("vertices", mesh.positions.len(), size_of::<VertexGpu>())?,
            edge_factors: buffer("edge factors", object.topology.edges.len(), 4)?,
            visible: buffer("visible patches", mesh.patches.len(), 4)?,
            view: buffer("view", 1, size_of::<ViewGpu>())?,
            draws: Draws::default(),
            at_texels: false,
            triangles: 0,
            patches: 0,
        })
    }

    /// Chooses tessellation factors, culls, and writes the buffers. The device must not be reading them.
    ///
    /// # Errors
    /// A failed write, which does not happen in practice.
    pub fn update(&mut self, posed: &PosedObject, from: &Viewpoint, settings: &TessellationSettings) -> Result<()> {
        let PosedObject { object, vertices, height_scale } = posed;
        let mesh = &object.object.mesh;
        let posed_mesh = PosedMesh {
            mesh,
            topology: &object.topology,
            positions: &vertices.positions,
            normals: &vertices.normals,
            edge_texels: &object.edge_texels,
            edge_relief: &object.edge_relief,
            height_range: &object.height_range,
            height_scale: height_scale * object.object.height_scale,
        };
        let posed_positions = &vertices.positions;
        let list = DrawList::new(posed_mesh, from.clip_from_world, from.lens, settings);
        let vertices: Vec<VertexGpu> = (0..mesh.positions.len())
            .map(|i| {
                let (position, normal) = (vertices.positions[i], vertices.normals[i]);
                let lifted = position + normal * list.vertex_lifts[i];
                VertexGpu {
                    position: lifted.extend(mesh.accessibility_of(i)).to_array(),
                    normal: normal.extend(list.vertex_lods[i]).to_array(),
                    color: mesh.color_of(i),
                }
            })
            .collect();
        self.vertices.write(0, &vertices)?;
        self.edge_factors.write(0, &list.edge_factors)?;
        self.visible.write(0, &list.visible)?;
        let repeat = if list.every_texel { repeat_on_plane(mesh, posed_positions) } else { 0.0 };
        let shrink = Mat4::from_scale(Vec3::new(1.0 / GUARD_BAND, 1.0 / GUARD_BAND, 1.0));
        let view = ViewGpu {
            clip_from_world: (shrink * from.clip_from_world).to_cols_array_2d(),
            camera_position: from.eye.extend(from.grid as f32).to_array(),
            texel_grid: [repeat, from.size.0 as f32, from.size.1 as f32, 0.0],
        };
        self.view.write(0, &[view])?;
        self.draws = list.draws;
        self.at_texels = repeat > 0.0;
        self.triangles = list.triangles;
        self.patches = list.visible.len() as u32;
        Ok(())
    }
}

/// [`PatchMesh::flat_repeat`], or 0 where no such plane is left: it was moved or bent.
fn repeat_on_plane(mesh: &PatchMesh, positions: &[Vec3]) -> f32 {
    let Some(repeat) = mesh.flat_repeat else { return 0.0 };
    let mut corners = mesh.patches.iter().flatten().zip(mesh.texcoords.iter().flatten());
    let in_place = corners.all(|(&vertex, &texcoord)| {
        let place = (texcoord * repeat).extend(0.0);
        positions[vertex as usize].distance(place) <= 1e-5 * place.length().max(repeat)
    });
    if in_place { repeat } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_that_moved_has_no_vertices_at_its_texels() {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let texcoords = vec![[0, 1, 2, 3].map(|i: usize| positions[i].truncate() / 2.0)];
        let mesh = PatchMesh {
            patches: vec![[0, 1, 2, 3]],
            texcoords,
            flat_repeat: Some(2.0),
            positions,
            ..Default::default()
        };
        assert_eq!(repeat_on_plane(&mesh, &mesh.positions), 2.0);
        let lifted: Vec<Vec3> = mesh.positions.iter().map(|p| *p + 0.1 * Vec3::Z).collect();
        assert_eq!(repeat_on_plane(&mesh, &lifted), 0.0);
        assert_eq!(repeat_on_plane(&PatchMesh { flat_repeat: None, ..mesh.clone() }, &mesh.positions), 0.0);
    }
}
