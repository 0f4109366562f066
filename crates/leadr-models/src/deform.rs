//! Computes the vertices of a posed model. Morph targets apply first, then joints, then the node transform.

use glam::{DVec3, Mat3, Mat4, Vec3};

use super::mesh::{Influences, MorphTarget, Primitive};
use super::model::Model;
use super::pose::Pose;

/// The vertices of a posed primitive in model space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PosedVertices {
    /// The positions in metres.
    pub positions: Vec<[f32; 3]>,
    /// The unit normals.
    pub normals: Vec<[f32; 3]>,
    /// The tangents in the format of the primitive, or an empty list if it has none.
    pub tangents: Vec<[f32; 4]>,
    /// Whether the matrix mirrors. Triangles are then clockwise when seen from the front. For skinned vertices, the matrix
    /// of the first joint decides.
    pub mirrored: bool,
}

/// The joints of each vertex of a skinned primitive, and the joint matrices of a pose.
type Joints<'a> = Option<(&'a [Influences], &'a [Mat4])>;

impl Model {
    /// Whether the matrix of a primitive of a node's mesh mirrors in a pose, like [`PosedVertices::mirrored`].
    ///
    /// # Panics
    /// Panics under the conditions of [`Model::posed_vertices`].
    pub fn is_mirrored(&self, pose: &Pose, node: usize, primitive: usize) -> bool {
        let (primitive, joints) = self.rigged(pose, node, primitive);
        let first = if primitive.positions.is_empty() { Mat4::IDENTITY } else { carried(pose, node, joints, 0) };
        Mat3::from_mat4(first).determinant() < 0.0
    }

    /// Returns a primitive of a node's mesh, and its joints if it is skinned.
    fn rigged<'a>(&'a self, pose: &'a Pose, node: usize, primitive: usize) -> (&'a Primitive, Joints<'a>) {
        let shown = &self.nodes[node];
        let primitive = &self.meshes[shown.mesh.expect("a node with a mesh")].primitives[primitive];
        let skin = shown.skin.map(|skin| &pose.world_from_bind[skin][..]);
        (primitive, primitive.influences.as_deref().zip(skin))
    }

    /// Computes the vertices of a primitive of a node's mesh.
    ///
    /// Normals are transformed by the inverse transpose. Normals of flat primitives are recomputed.
    ///
    /// # Panics
    /// Panics if the node has no mesh, if the mesh has no such primitive, or if the pose belongs to another model.
    pub fn posed_vertices(&self, pose: &Pose, node: usize, primitive: usize) -> PosedVertices {
        let mirrored = self.is_mirrored(pose, node, primitive);
        let (primitive, joints) = self.rigged(pose, node, primitive);
        let weights = &pose.weights[node];
        let positions = morphed(&primitive.positions, primitive, weights, |target| &target.positions);
        let normals = morphed(&primitive.normals, primitive, weights, |target| &target.normals);
        let given = primitive.tangents.as_deref().unwrap_or_default();
        let directions: Vec<[f32; 3]> = given.iter().map(|t| [t[0], t[1], t[2]]).collect();
        let directions = morphed(&directions, primitive, weights, |target| &target.tangents);

        let mut posed = PosedVertices { mirrored, ..PosedVertices::default() };
        for (vertex, &position) in positions.iter().enumerate() {
            let matrix = carried(pose, node, joints, vertex);
            posed.positions.push(matrix.transform_point3(position).to_array());
            if !primitive.flat {
                posed.normals.push(carried_normal(Mat3::from_mat4(matrix), normals[vertex]).to_array());
            }
            if let Some(&direction) = directions.get(vertex) {
                let [x, y, z] = matrix.transform_vector3(direction).normalize_or(Vec3::X).to_array();
                posed.tangents.push([x, y, z, given[vertex][3]]);
            }
        }
        if primitive.flat {
            posed.normals = flat_normals(&posed.positions, &primitive.triangles);
        }
        if posed.mirrored && primitive.flat {
            posed.normals.iter_mut().for_each(|n| *n = n.map(|v| -v));
        }
        posed
    }
}

/// Returns the matrix from a vertex of the mesh to model space.
fn carried(pose: &Pose, node: usize, joints: Joints<'_>, vertex: usize) -> Mat4 {
    let Some((influences, joints)) = joints else { return pose.world_from_node[node] };
    let Influences { joints: indices, weights } = influences[vertex];
    let all = indices.iter().zip(weights).filter(|(_, weight)| *weight > 0.0);
    all.fold(Mat4::ZERO, |sum, (&joint, weight)| sum + joints[usize::from(joint)] * weight)
}

/// Returns the vertices plus the weighted differences of the primitive's targets.
fn morphed<'a>(
    base: &[[f32; 3]],
    primitive: &'a Primitive,
    weights: &[f32],
    of: impl Fn(&'a MorphTarget) -> &'a [[f32; 3]],
) -> Vec<Vec3> {
    let mut sums: Vec<Vec3> = base.iter().map(|&v| Vec3::from(v)).collect();
    for (target, &weight) in primitive.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
        for (sum, &difference) in sums.iter_mut().zip(of(target)) {
            *sum += Vec3::from(difference) * weight;
        }
    }
    sums
}

/// Transforms a normal by the cofactors of a matrix. Cofactors equal the inverse transpose times the determinant, but also
/// exist for singular matrices. The sign is corrected if the matrix mirrors.
fn carried_normal(matrix: Mat3, normal: Vec3) -> Vec3 {
    // The matrix is scaled first, because products of very small or very large columns exceed the range of 32 bits.
    let size = matrix.to_cols_array().into_iter().fold(0.0, |most: f32, v| most.max(v.abs()));
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|column| column / size.max(f32::MIN_POSITIVE));
    let cofactors = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    let carried = cofactors * normal * x.dot(y.cross(z)).signum();
    carried.normalize_or(normal.normalize_or(Vec3::Z))
}

/// Returns the plane normals of triangles that share no vertices. The normal of a degenerate triangle is +z.
pub(super) fn flat_normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut normals = vec![[0.0, 0.0, 1.0]; positions.len()];
    for triangle in triangles {
        let normal = plane_normal(triangle.map(|v| positions[v as usize])).normalize_or(DVec3::Z).as_vec3();
        triangle.iter().for_each(|&v| normals[v as usize] = normal.to_array());
    }
    normals
}

/// Returns the normal of a triangle, multiplied by twice the triangle's area.
pub(super) fn plane_normal(corners: [[f32; 3]; 3]) -> DVec3 {
    let [a, b, c] = corners.map(|corner| Vec3::from(corner).as_dvec3());
    (b - a).cross(c - a)
}
