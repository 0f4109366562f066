//! Skins meshes, with normals that follow the deformed surface.
//!
//! If normals are only rotated by the blended joints, the skinning weights are treated as constant. But where weights change
//! quickly over a strongly bent joint, the surface also shears. Point-normal patches with the blended normals then show ripples.

use glam::{Mat4, Quat, Vec3};

use super::patch_mesh::{PatchMesh, PosedVertices};

/// Poses a mesh with linear blend skinning, where `joints` transform from rest to world space. Each normal is then corrected by the
/// rotation from the blended mean face normal to the mean face normal of the skinned mesh. Missing joints are ignored.
pub fn skin(mesh: &PatchMesh, joints: &[Mat4]) -> PosedVertices {
    let blends: Vec<Mat4> = mesh
        .skin
        .iter()
        .map(|skin| {
            let influences = skin.joints.iter().zip(skin.weights).filter(|(_, w)| *w > 0.0);
            influences.fold(Mat4::ZERO, |sum, (&j, w)| sum + joints.get(usize::from(j)).map_or(Mat4::ZERO, |m| *m * w))
        })
        .collect();
    let positions: Vec<Vec3> = mesh.positions.iter().zip(&blends).map(|(p, m)| m.transform_point3(*p)).collect();
    let (rest, posed) = (mean_normals(mesh, &mesh.positions), mean_normals(mesh, &positions));
    let normals = (0..positions.len())
        .map(|v| {
            let rotated = |n: Vec3| blends[v].transform_vector3(n).normalize_or(n);
            let (from, normal) = (rotated(rest[v]), rotated(mesh.normals[v]));
            // For a collapsed fold, or for a vertex without faces, the rotation would have no meaning.
            if rest[v] == Vec3::ZERO || from.dot(posed[v]) <= 0.0 {
                normal
            } else {
                Quat::from_rotation_arc(from, posed[v]) * normal
            }
        })
        .collect();
    PosedVertices::new(positions, normals)
}

/// Computes the area-weighted mean of the face normals around each vertex.
fn mean_normals(mesh: &PatchMesh, positions: &[Vec3]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    for q in &mesh.patches {
        let p = q.map(|i| positions[i as usize]);
        let n = (p[2] - p[0]).cross(p[3] - p[1]);
        q.iter().for_each(|&i| normals[i as usize] += n);
    }
    normals.into_iter().map(|n| n.normalize_or_zero()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surfaces::patch_mesh::SkinWeights;

    /// Returns a strip of twenty by four quads, whose weights change along x from joint 0 to joint 1.
    fn strip() -> PatchMesh {
        let mut mesh = PatchMesh::default();
        for i in 0..=20_u32 {
            for j in 0..=4_u32 {
                let t = i as f32 / 20.0;
                mesh.positions.push(Vec3::new(t, j as f32 / 20.0, 0.0));
                mesh.normals.push(Vec3::Z);
                mesh.skin.push(SkinWeights { joints: [0, 1, 0, 0], weights: [1.0 - t, t, 0.0, 0.0] });
                if i < 20 && j < 4 {
                    let v = i * 5 + j;
                    mesh.patches.push([v, v + 5, v + 6, v + 1]);
                }
            }
        }
        mesh
    }

    #[test]
    fn a_sheared_strip_gets_the_normals_of_its_surface() {
        // Joint 1 is only moved upwards, so the strip becomes a ramp although no joint rotates.
        let ramp = [Mat4::IDENTITY, Mat4::from_translation(Vec3::Z)];
        let expected = Vec3::new(-1.0, 0.0, 1.0).normalize();
        for n in skin(&strip(), &ramp).normals {
            assert!(n.distance(expected) < 1e-5, "{n}");
        }
    }

    #[test]
    fn rigid_motion_rotates_the_given_normals() {
        let mut mesh = strip();
        mesh.normals.iter_mut().for_each(|n| *n = Vec3::new(0.1, -0.2, 1.0).normalize());
        let rotation = Mat4::from_rotation_x(1.0) * Mat4::from_translation(Vec3::ONE);
        for (n, m) in skin(&mesh, &[rotation, rotation]).normals.iter().zip(&mesh.normals) {
            assert!(n.distance(rotation.transform_vector3(*m)) < 1e-5);
        }
    }
}
