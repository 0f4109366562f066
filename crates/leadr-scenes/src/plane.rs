//! A square of patches in the plane z = 0 with a repeating height map, for floors and for the `plane` scene.

use glam::Vec3;
use leadr_render::scene::Object;
use leadr_render::surfaces::patch_mesh::PatchMesh;

/// Builds a smooth floor that casts no shadow.
pub fn floor(mesh: PatchMesh) -> Object {
    Object::new("floor", mesh).without_shadow()
}

/// Builds a square plane of half width `half` with `n × n` patches. `spacing` maps evenly spaced positions in `[-1, 1]` to positions in
/// `[-1, 1]`, so the middle can have smaller patches. One repeat of the map covers `repeat` metres.
pub fn plane(half: f32, n: u32, repeat: f32, color: [f32; 4], spacing: impl Fn(f32) -> f32) -> PatchMesh {
    let mut mesh = PatchMesh { flat_repeat: Some(repeat), ..PatchMesh::default() };
    let at = |i: u32| half * spacing(2.0 * i as f32 / n as f32 - 1.0);
    for j in 0..=n {
        for i in 0..=n {
            mesh.positions.push(Vec3::new(at(i), at(j), 0.0));
        }
    }
    mesh.normals = vec![Vec3::Z; mesh.positions.len()];
    mesh.colors = vec![color; mesh.positions.len()];
    mesh.accessibility = vec![1.0; mesh.positions.len()];
    mesh.patches = grid(n, n);
    let texcoord = |v: u32| mesh.positions[v as usize].truncate() / repeat;
    mesh.texcoords = mesh.patches.iter().map(|patch| patch.map(texcoord)).collect();
    mesh
}

/// Returns the patches of a grid of vertices, which has `columns` by `rows` patches.
pub fn grid(columns: u32, rows: u32) -> Vec<[u32; 4]> {
    let width = columns + 1;
    let first = |j: u32| (0..columns).map(move |i| j * width + i);
    (0..rows).flat_map(first).map(|v| [v, v + 1, v + width + 1, v + width]).collect()
}

/// Returns positions of even spacing for [`plane`].
pub fn even(t: f32) -> f32 {
    t
}

/// Returns positions for a wide ground, whose patches are a thousand times smaller at the centre than at the rim.
pub fn toward_horizon(t: f32) -> f32 {
    let steepness = 7.6f32;
    (steepness * t).sinh() / steepness.sinh()
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_render::surfaces::topology::Topology;

    #[test]
    fn planes_face_up_and_share_edges() {
        let mesh = plane(10.0, 8, 2.0, [0.5; 4], toward_horizon);
        for patch in &mesh.patches {
            let p = patch.map(|v| mesh.positions[v as usize]);
            assert!((p[1] - p[0]).cross(p[3] - p[0]).z > 0.0);
        }
        // Each direction has 8 × 9 edges. Each of the 32 edges at the rim belongs to a single patch.
        let topology = Topology::new(&mesh.patches);
        assert_eq!(topology.edges.len(), 144);
        assert_eq!(topology.irregular_edges(), 32);
        assert!((mesh.positions.last().unwrap().x - 10.0).abs() < 1e-4);
    }
}
