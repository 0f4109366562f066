//! Straightens the few crumpled quads of the cage, whose limit surface would fold over.
//!
//! Vertices may leave the distance field for this: displacement brings the skin back onto it.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::render::patch::Patch;
use crate::render::patch_mesh::PatchMesh;

/// Rounds of smoothing at most.
const ROUNDS: usize = 60;
/// Least cosine between the limit surface's own normal and the displacement direction.
const LEAST_COSINE: f32 = 0.35;
/// Least ratio of the surface element to its mean over the patch.
const LEAST_ELEMENT: f32 = 0.06;

/// Whether the limit surface of a patch turns against its displacement direction or nearly degenerates.
fn is_crumpled(patch: &Patch) -> bool {
    let elements: Vec<f32> = (0..49)
        .map(|i| {
            let p = patch.at(Vec2::new((i % 7) as f32, (i / 7) as f32) / 6.0);
            let area = p.du.cross(p.dv);
            let cosine = area.normalize_or_zero().dot(p.normal);
            if cosine < LEAST_COSINE { 0.0 } else { area.dot(p.normal) }
        })
        .collect();
    let mean = elements.iter().sum::<f32>() / 49.0;
    elements.iter().any(|e| *e <= LEAST_ELEMENT * mean)
}

/// Crumpled patches of a mesh, by index.
#[must_use]
pub fn crumpled(mesh: &PatchMesh) -> Vec<usize> {
    let test = |i: &usize| {
        let q = mesh.patches[*i];
        is_crumpled(&Patch::new(q.map(|v| mesh.positions[v as usize]), q.map(|v| mesh.normals[v as usize])))
    };
    (0..mesh.patches.len()).into_par_iter().filter(test).collect()
}

fn corner_normals(mesh: &PatchMesh, v: usize, faces: &[usize]) -> Vec3 {
    let face = |f: &usize| {
        let q = mesh.patches[*f];
        let k = q.iter().position(|&i| i as usize == v).expect("a face around the vertex");
        let p = |k: usize| mesh.positions[q[k % 4] as usize];
        (p(k + 1) - p(k)).cross(p(k + 3) - p(k)).normalize_or_zero()
    };
    faces.iter().map(face).sum::<Vec3>()
}

/// Smooths positions and normals around crumpled patches until none is left or the rounds are used up; returns how
/// many remain.
pub fn untangle(mesh: &mut PatchMesh) -> usize {
    let mut faces = vec![Vec::new(); mesh.positions.len()];
    for (f, q) in mesh.patches.iter().enumerate() {
        q.iter().for_each(|&v| faces[v as usize].push(f));
    }
    for _ in 0..ROUNDS {
        let bad = crumpled(mesh);
        if bad.is_empty() {
            return 0;
        }
        let mut moved: Vec<usize> = bad.iter().flat_map(|&f| mesh.patches[f]).map(|v| v as usize).collect();
        moved.sort_unstable();
        moved.dedup();
        let targets: Vec<Vec3> = moved
            .iter()
            .map(|&v| {
                let around = faces[v].iter().flat_map(|&f| mesh.patches[f]).filter(|&i| i as usize != v);
                let (sum, count) = around.fold((Vec3::ZERO, 0.0), |(s, c), i| (s + mesh.positions[i as usize], c + 1.0));
                sum / count
            })
            .collect();
        for (&v, target) in moved.iter().zip(&targets) {
            mesh.positions[v] = mesh.positions[v].lerp(*target, 0.25);
        }
        let mut touched: Vec<usize> =
            moved.iter().flat_map(|&v| &faces[v]).flat_map(|&f| mesh.patches[f]).map(|v| v as usize).collect();
        touched.sort_unstable();
        touched.dedup();
        let normals: Vec<Vec3> = touched
            .iter()
            .map(|&v| {
                let near = faces[v].iter().flat_map(|&f| mesh.patches[f]).map(|i| mesh.normals[i as usize]).sum::<Vec3>();
                let own = corner_normals(mesh, v, &faces[v]).normalize_or_zero();
                (own + 0.5 * near.normalize_or_zero()).normalize_or(mesh.normals[v])
            })
            .collect();
        for (&v, n) in touched.iter().zip(normals) {
            mesh.normals[v] = n;
        }
    }
    crumpled(mesh).len()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat 5 by 5 sheet with one inner vertex dragged across its neighbours.
    fn sheet(dragged: bool) -> PatchMesh {
        let mut mesh = PatchMesh::default();
        for j in 0..5 {
            for i in 0..5 {
                mesh.positions.push(Vec3::new(i as f32, j as f32, 0.0));
                mesh.normals.push(Vec3::Z);
            }
        }
        for j in 0..4 {
            for i in 0..4 {
                let a = j * 5 + i;
                mesh.patches.push([a, a + 1, a + 6, a + 5]);
            }
        }
        if dragged {
            mesh.positions[12] = Vec3::new(3.4, 2.1, 0.0);
        }
        mesh
    }

    #[test]
    fn a_dragged_vertex_is_found_and_put_right() {
        assert!(crumpled(&sheet(false)).is_empty());
        let mut mesh = sheet(true);
        assert!(!crumpled(&mesh).is_empty());
        assert_eq!(untangle(&mut mesh), 0);
        assert!(crumpled(&mesh).is_empty());
    }
}
