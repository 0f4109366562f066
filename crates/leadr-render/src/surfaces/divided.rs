//! A posed object, tessellated for a lens. Suns draw shadow casters with the camera's tessellation, or with a coarser tessellation
//! if their shadow maps cannot resolve it. A finer tessellation would protrude from the visible surface and cast shadows on it.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::object::GpuObject;
use super::patch_mesh::PatchMesh;
use super::posed::PosedObject;
use super::tessellation::{Division, Lens, TessellationSettings};
use crate::constants::HEIGHT_WITH_DETAIL;
use leadr_gpu::{Buffer, Gpu, Result, shared_struct};

shared_struct! {
    /// A vertex in the layout of the shaders (`Vertex` in `passes/geometry/interface.glsl`).
    pub struct VertexGpu for "Vertex" {
        /// The position in world space (xyz), and the ambient accessibility (w).
        pub position: [f32; 4],
        /// The displacement direction in world space (xyz), and the LOD of the boundary heights (w).
        pub normal: [f32; 4],
        /// The linear albedo (rgb), and the Beckmann roughness (a).
        pub color: [f32; 4],
        /// The shading normal, for a vertex of a triangle (xyz), and the factor on the height scale (w).
        pub facing: [f32; 4],
    }
}

/// The buffers of a tessellation, which are large enough for every vertex and edge of an object.
pub struct DivisionBuffers {
    /// A buffer with one `Vertex` struct per vertex.
    pub vertices: Buffer,
    /// The tessellation factor of each edge.
    pub edge_factors: Buffer,
}

impl DivisionBuffers {
    /// Creates the buffers for an object.
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

/// The tessellation of an object in a frame.
pub struct DividedObject {
    /// The device buffers.
    pub buffers: Arc<DivisionBuffers>,
    /// The tessellation factors.
    pub division: Division,
    /// Whether each texel of the heights has a vertex at its centre.
    pub at_texels: bool,
    /// The lens and settings for which the tessellation was computed.
    of: Option<(Lens, TessellationSettings)>,
}

impl DividedObject {
    /// Creates an empty tessellation with these buffers.
    pub fn new(buffers: Arc<DivisionBuffers>) -> Self {
        Self { buffers, division: Division::default(), at_texels: false, of: None }
    }

    /// Tessellates the object, unless it is already tessellated for the same lens and settings. The result depends only on the
    /// lens, the settings and the pose. The device must not be reading the buffers.
    pub fn divide(&mut self, posed: &PosedObject, lens: Lens, settings: &TessellationSettings) -> Result<()> {
        if self.of.is_some_and(|(of, so)| of == lens && so.divides_as(settings)) {
            return Ok(());
        }
        self.of = Some((lens, *settings));
        self.write(posed, Division::new(posed.mesh(), lens, settings))
    }

    /// Writes a coarser tessellation, with vertices at least `spacing` metres apart, to other buffers. Returns `None` if the
    /// vertices are nowhere closer than `spacing`. The device must not be reading the buffers.
    pub fn with_min_spacing(
        &self,
        spacing: f32,
        posed: &PosedObject,
        buffers: &Arc<DivisionBuffers>,
    ) -> Result<Option<Self>> {
        let Some(division) = self.division.with_min_spacing(spacing, posed.mesh()) else { return Ok(None) };
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
                    facing: posed_vertices.normals[i].extend(mesh.height_scale_of(i)).to_array(),
                }
            })
            .collect();
        self.buffers.vertices.write(0, &vertices)?;
        self.buffers.edge_factors.write(0, edge_factors)?;
        // A displacing detail has finer texels than the heights.
        let has_own_texels = posed.object.kind.height_terms & HEIGHT_WITH_DETAIL == 0;
        self.at_texels = *every_texel
            && has_own_texels
            && posed.object.kind.flat
            && is_undeformed_plane(mesh, &posed_vertices.positions);
        self.division = division;
        Ok(())
    }
}

/// Whether a mesh still matches [`PatchMesh::flat_repeat`], because no pose has moved or bent it.
fn is_undeformed_plane(mesh: &PatchMesh, positions: &[Vec3]) -> bool {
    let Some(repeat) = mesh.flat_repeat else { return false };
    let mut corners = mesh.patches.iter().flatten().zip(mesh.texcoords.iter().flatten());
    corners.all(|(&vertex, &texcoord)| {
        let expected = (texcoord * repeat).extend(0.0);
        positions[vertex as usize].distance(expected) <= 1e-5 * expected.length().max(repeat)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moved_plane_has_no_vertices_at_texels() {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        let texcoords = vec![[0, 1, 2, 3].map(|i: usize| positions[i].truncate() / 2.0)];
        let mesh = PatchMesh {
            patches: vec![[0, 1, 2, 3]],
            texcoords,
            flat_repeat: Some(2.0),
            positions,
            ..Default::default()
        };
        assert!(is_undeformed_plane(&mesh, &mesh.positions));
        let lifted: Vec<Vec3> = mesh.positions.iter().map(|p| *p + 0.1 * Vec3::Z).collect();
        assert!(!is_undeformed_plane(&mesh, &lifted));
        assert!(!is_undeformed_plane(&PatchMesh { flat_repeat: None, ..mesh.clone() }, &mesh.positions));
    }
}
