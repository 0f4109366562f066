//! Straightens the few crumpled quads of the cage, whose limit surface would fold over.
//!
//! Vertices may leave the distance field for this: displacement brings the skin back onto it.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::render::patch::Patch;
use crate::render::patch_mesh::PatchMesh;

/// Rounds of smoothing at most.
const ROUNDS: usize = 60;
/// Rounds in which vertices return to the surface after each smoothing, so that thin tips do not shrink.
const RETURNING_ROUNDS: usize = 40;
/// Least cosine between the limit surface's own normal and the displacement direction.
const LEAST_COSINE: f32 = 0.15;
/// Least ratio of the surface element to its mean over the patch.
const LEAST_ELEMENT: f32 = 0.03;

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
/// many remain. `surface` brings a point back to the surface the mesh follows.
pub fn untangle(mesh: &mut PatchMesh, surface: &dyn Fn(Vec3) -> Vec3) -> usize {
    let mut faces = vec![Vec::new(); mesh.positions.len()];
    for (f, q) in mesh.patches.iter().enumerate() {
        q.iter().for_each(|&v| faces[v as usize].push(f));
    }
    for round in 0..ROUNDS {
        let bad = crumpled(mesh);
        if std::env::var("DBG").is_ok() { for &b in &bad { println!("round {round} {b} {}", mesh.positions[mesh.patches[b][0] as usize]); } }
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
            let p = mesh.positions[v].lerp(*target, 0.3);
            mesh.positions[v] = if round < RETURNING_ROUNDS { surface(p) } else { p };
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
    #[ignore = "dbg"]
    fn dbg() {
        let sdf = crate::scenes::trex::sdf::TrexSdf::new();
        let t = std::time::Instant::now();
        let mut m = crate::scenes::trex::cage::build(&sdf).unwrap();
        println!("cage {:?}", t.elapsed());
        let bad = crumpled(&m);
        for &f in &bad {
            let q = m.patches[f];
            let el: Vec<f32> = (0..4).map(|k| m.positions[q[k] as usize].distance(m.positions[q[(k+1)%4] as usize])).collect();
            let p = Patch::new(q.map(|v| m.positions[v as usize]), q.map(|v| m.normals[v as usize]));
            let mut least = 9.0_f32;
            for i in 0..49 { let p = p.at(Vec2::new((i % 7) as f32, (i / 7) as f32) / 6.0); least = least.min(p.du.cross(p.dv).normalize_or_zero().dot(p.normal)); }
            let fl = Patch::new(q.map(|v| m.positions[v as usize]), [ (m.positions[q[2] as usize]-m.positions[q[0] as usize]).cross(m.positions[q[3] as usize]-m.positions[q[1] as usize]).normalize(); 4]);
            let mut lf = 9.0_f32;
            for i in 0..49 { let p = fl.at(Vec2::new((i % 7) as f32, (i / 7) as f32) / 6.0); lf = lf.min(p.du.cross(p.dv).normalize_or_zero().dot(p.normal)); }
            println!("{f} at {:.3} edges {el:.3?} least {least:.2} flat {lf:.2}", m.positions[q[0] as usize]);
        }
        for step in [0.005, 0.01, 0.02, 0.04] {
            let mut k = m.clone();
            for v in 0..k.positions.len() { k.normals[v] = sdf.coarse_gradient(k.positions[v], step).normalize(); }
            println!("sdf normals {step}: {}", crumpled(&k).len());
            let mut k = m.clone();
            for &f in &bad { for v in m.patches[f] { let v = v as usize; k.normals[v] = sdf.coarse_gradient(k.positions[v], step).normalize(); } }
            println!("sdf normals, bad only {step}: {}", crumpled(&k).len());
        }
    }

    #[test]
    fn a_dragged_vertex_is_found_and_put_right() {
        assert!(crumpled(&sheet(false)).is_empty());
        let mut mesh = sheet(true);
        assert!(!crumpled(&mesh).is_empty());
        assert_eq!(untangle(&mut mesh, &|p| p), 0);
        assert!(crumpled(&mesh).is_empty());
    }
}
