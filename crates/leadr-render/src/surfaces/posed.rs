//! An object in the pose of a frame.

use std::sync::Arc;

use glam::{Mat2, Vec2, Vec3};

use super::flat::Chart;
use super::object::{ByClass, GpuObject};
use super::patch_mesh::PosedVertices;
use super::records::ObjectRecords;
use super::sphere::Sphere;
use super::tessellation::PosedMesh;
use crate::scene::Tiling;

/// An object in the pose of a frame.
pub struct PosedObject {
    /// The object on the device.
    pub object: Arc<GpuObject>,
    /// The number of the object in the scene, counted from 1. Each instance has its own number.
    pub number: u32,
    /// The vertices in world space.
    pub vertices: PosedVertices,
    /// The factor for the object's height scale when the geometry is displaced. The value 0 keeps the geometry smooth.
    pub height_scale: f32,
    /// The records of all objects of the frame.
    pub records: Arc<ObjectRecords>,
    /// Whether the frame shades the object by several classes of facets.
    pub shades_classes: bool,
}

impl PosedObject {
    /// Whether the object is shaded by several classes of facets.
    pub fn has_classes(&self) -> bool {
        self.by_class().is_some()
    }

    /// Returns the inputs for the classes of the object, if the frame shades it by several.
    pub fn by_class(&self) -> Option<&ByClass> {
        self.object.by_class().filter(|_| self.shades_classes)
    }

    /// Returns the mean length of a height texel in the world, in metres, which is infinite without heights.
    pub fn texel_length(&self) -> f32 {
        let positions = &self.vertices.positions;
        let lengths =
            self.object.topology.edges.iter().map(|e| positions[e[0] as usize].distance(positions[e[1] as usize]));
        let texels: f32 = self.object.edge_texels.iter().sum();
        if texels > 0.0 { lengths.sum::<f32>() / texels } else { f32::INFINITY }
    }

    /// Returns the offset of the object in the lattice of by-example tiling, in map repeats. The offset keeps the tiling fixed in
    /// the world. Meshes other than planes move by whole repeats.
    pub fn tiling_shift(&self) -> [f32; 2] {
        let mesh = &self.object.object.mesh;
        let kind = self.object.kind;
        let ends = self.vertices.positions.first().zip(mesh.positions.first());
        let stays = kind.by_example && matches!(self.object.object.tiling, Tiling::ByExampleInWorld | Tiling::Ground);
        let (true, Some((&here, &rest))) = (stays, ends) else { return [0.0; 2] };
        let Some(Chart { tangent_s: s, tangent_t: t, .. }) = Chart::of(mesh, &self.vertices) else { return [0.0; 2] };
        let moved = here - rest;
        let along = Vec2::new(moved.dot(s), moved.dot(t));
        let shift = Mat2::from_cols_array(&[s.dot(s), s.dot(t), s.dot(t), t.dot(t)]).inverse() * along;
        (if kind.flat { shift } else { shift.round() }).to_array()
    }

    /// Iterates over the triangles of the patches in world space, ignoring the relief. The triangles run counter-clockwise seen
    /// from outside.
    pub fn triangles(&self) -> impl Iterator<Item = [Vec3; 3]> + Clone + '_ {
        let positions = &self.vertices.positions;
        let mesh = &self.object.object.mesh;
        // The third corner of a triangle repeats the last, so there is no second half.
        let halves = if mesh.triangles { 1 } else { 2 };
        mesh.patches.iter().flat_map(move |patch| {
            let [a, b, c, d] = patch.map(|vertex| positions[vertex as usize]);
            [[a, b, c], [a, c, d]].into_iter().take(halves)
        })
    }

    /// Returns a sphere that encloses the object, including its bumps.
    pub fn bounds(&self) -> Sphere {
        let (low, high) = self
            .vertices
            .positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        Sphere { centre: (low + high) * 0.5, radius: low.distance(high) * 0.5 + self.highest_bump() }
    }

    /// Returns the largest distance between the displaced surface and the smooth surface, in metres.
    pub fn highest_bump(&self) -> f32 {
        let bump = self.object.height_range.iter().flatten().fold(0.0f32, |a, h| a.max(h.abs()));
        bump * (self.height_scale * self.object.object.height_scale).abs()
    }

    /// Returns the mesh in the form that tessellation and culling take.
    pub(super) fn mesh(&self) -> PosedMesh<'_> {
        let Self { object, vertices, height_scale, .. } = self;
        PosedMesh {
            mesh: &object.object.mesh,
            topology: &object.topology,
            positions: &vertices.positions,
            normals: vertices.displaced_along(),
            edge_texels: &object.edge_texels,
            edge_relief: &object.edge_relief,
            height_range: &object.height_range,
            height_scale: height_scale * object.object.height_scale,
        }
    }
}
