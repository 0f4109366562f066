//! A posed object, divided as finely as a lens asks for. The suns whose shadows a camera sees draw the same division, or where their
//! maps cannot show it a coarser one; a finer one would stand out of the surface that the camera sees, and shade it.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::object::GpuObject;
use super::patch_mesh::PatchMesh;
use super::posed::PosedObject;
use super::tessellation::{Division, Lens, TessellationSettings};
use leadr_gpu::{Buffer, Gpu, Result, shared_struct};

shared_struct! {
    /// One vertex as the shaders read it (`Vertex` in `passes/geometry/interface.glsl`).
    pub struct VertexGpu for "Vertex" {
        /// World position; w: ambient accessibility.
        pub position: [f32; 4],
        /// World displacement direction; w: LOD of the boundary heights.
        pub normal: [f32; 4],
        /// Linear albedo; a: Beckmann roughness.
        pub color: [f32; 4],
        /// Normal that a triangle is shaded with.
        pub facing: [f32; 4],
    }
}

/// The buffers of a division, large enough for every vertex and edge of an object.
pub struct DivisionBuffers {
    /// `Vertex` of every vertex.
    pub vertices: Buffer,
    /// Tessellation factor of each edge.
    pub edge_factors: Buffer,
}

impl DivisionBuffers {
    /// Buffers for an object.
    pub fn new(gpu: &Arc<Gpu>, object: &GpuObject) -> Result<Self> {
        Ok(Self {
            vertices: object.frame_buffer(
                gpu,
                "vertices",
                object.object.mesh.positions.len(),
                size_of::<VertexGpu>(),
            )?,
            edge_factors: object.frame_buffer(gpu, "edge factors", object.topology.edges.len(), 4)?,
        })
    }
}

/// An object's division for a frame.
pub struct DividedObject {
    /// What the device reads.
    pub buffers: Arc<DivisionBuffers>,
    /// The factors.
    pub division: Division,
    /// Whether a vertex stands at the centre of each texel of the heights.
    pub at_texels: bool,
    /// What it was divided for.
    of: Option<(Lens, TessellationSettings)>,
}

impl DividedObject {
    /// A division that is still to be made, in these buffers.
    pub fn new(buffers: Arc<DivisionBuffers>) -> Self {
        Self { buffers, division: Division::default(), at_texels: false, of: None }
    }

    /// Divides the object, which is always the same in the same pose, unless that was done for the same lens. The device must not
    /// be reading the buffers.
    pub fn divide(&mut self, posed: &PosedObject, lens: Lens, settings: &TessellationSettings) -> Result<()> {
        if self.of.is_some_and(|(of, so)| of == lens && so.divides_as(settings)) {
            return Ok(());
        }
        self.of = Some((lens, *settings));
        self.write(posed, Division::new(posed.mesh(), lens, settings))
    }

    /// The same division with vertices no closer together than so many metres, in other buffers; `None` if none of its vertices are.
    /// The device must not be reading the buffers.
    pub fn no_finer_than(
        &self,
        spacing: f32,
        posed: &PosedObject,
        buffers: &Arc<DivisionBuffers>,
    ) -> Result<Option<Self>> {
        let Some(division) = self.division.no_finer_than(spacing, posed.mesh()) else { return Ok(None) };
        let mut coarser = Self::new(buffers.clone());
        coarser.write(posed, division)?;
        Ok(Some(coarser))
    }

    fn write(&mut self, posed: &PosedObject, division: Division) -> Result<()> {
        let (mesh, posed_vertices) = (&posed.object.object.mesh, &posed.vertices);
        let Division { edge_factors, vertex_lods, vertex_lifts, every_texel } = &division;
        let vertices: Vec<VertexGpu> = (0..mesh.positions.len())
            .into_par_iter()
            .with_min_len(1024)
            .map(|i| {
                let (position, normal) = (posed_vertices.positions[i], posed_vertices.displaced_along()[i]);
                let lifted = position + normal * vertex_lifts[i];
                VertexGpu {
                    position: lifted.extend(mesh.accessibility_of(i)).to_array(),
                    normal: normal.extend(vertex_lods[i]).to_array(),
                    color: mesh.color_of(i),
                    facing: posed_vertices.normals[i].extend(0.0).to_array(),
                }
            })
            .collect();
        self.buffers.vertices.write(0, &vertices)?;
        self.buffers.edge_factors.write(0, edge_factors)?;
        self.at_texels = *every_texel && posed.object.kind.flat && repeats_in_place(mesh, &posed_vertices.positions);
        self.division = division;
        Ok(())
    }
}

/// Whether a mesh still lies as [`PatchMesh::flat_repeat`] says: it was neither moved nor bent.
fn repeats_in_place(mesh: &PatchMesh, positions: &[Vec3]) -> bool {
    let Some(repeat) = mesh.flat_repeat else { return false };
    let mut corners = mesh.patches.iter().flatten().zip(mesh.texcoords.iter().flatten());
    corners.all(|(&vertex, &texcoord)| {
        let place = (texcoord * repeat).extend(0.0);
        positions[vertex as usize].distance(place) <= 1e-5 * place.length().max(repeat)
    })
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
        assert!(repeats_in_place(&mesh, &mesh.positions));
        let lifted: Vec<Vec3> = mesh.positions.iter().map(|p| *p + 0.1 * Vec3::Z).collect();
        assert!(!repeats_in_place(&mesh, &lifted));
        assert!(!repeats_in_place(&PatchMesh { flat_repeat: None, ..mesh.clone() }, &mesh.positions));
    }
}
