//! Swept meshes: tubes of any outline. Normals, tangents and texture coordinates are derived.

use glam::{Vec2, Vec3};

/// A vertex.
#[derive(Clone, Copy)]
pub struct Vertex {
    pub position: Vec3,
    pub normal: Vec3,
    /// The direction of increasing `u`, and the sign of the bitangent. The bitangent points opposite to increasing `v`.
    pub tangent: [f32; 4],
    pub uv: Vec2,
    /// The joint indices and their weights.
    pub joints: [(u16, f32); 4],
}

/// A triangle mesh.
#[derive(Default)]
pub struct Mesh {
    pub vertices: Vec<Vertex>,
    pub indices: Vec<u16>,
}

impl Mesh {
    /// Appends a tube of `rings × sides` quads through `surface(u, v)`, with `u` along the tube and `v` around the tube, both from 0 to 1.
    /// `uv` returns texture coordinates, and `joints` returns the skinning. The outside is opposite to `∂u × ∂v`. The first and the last
    /// ring may shrink to points.
    pub fn tube(
        &mut self,
        [rings, sides]: [usize; 2],
        surface: impl Fn(f32, f32) -> Vec3,
        uv: impl Fn(f32, f32) -> Vec2,
        joints: impl Fn(f32, Vec3) -> [(u16, f32); 4],
    ) {
        let first = self.vertices.len() as u16;
        for i in 0..=rings {
            for j in 0..=sides {
                let (u, v) = (i as f32 / rings as f32, j as f32 / sides as f32);
                // Both ends of a ring are the same point, bit for bit.
                let position = surface(u, v % 1.0);
                // Differences inside the tube; points use those of the neighbouring ring.
                let at = u.clamp(0.5 / rings as f32, 1.0 - 0.5 / rings as f32);
                let along = surface((at + 1e-3).min(1.0), v) - surface((at - 1e-3).max(0.0), v);
                let around = surface(at, v + 1e-3) - surface(at, v - 1e-3);
                let normal = around.cross(along).normalize_or(Vec3::Y);
                let by_u = uv((at + 1e-3).min(1.0), v) - uv((at - 1e-3).max(0.0), v);
                let by_v = uv(at, v + 1e-3) - uv(at, v - 1e-3);
                let determinant = by_u.perp_dot(by_v);
                let tangent = (along * by_v.y - around * by_u.y) * determinant.signum();
                let tangent = (tangent - normal * normal.dot(tangent)).normalize_or(Vec3::Z);
                let up = (along * by_v.x - around * by_u.x) * determinant.signum();
                let sign = if normal.cross(tangent).dot(up) > 0.0 { 1.0 } else { -1.0 };
                let joints = joints(u, position);
                self.vertices.push(Vertex {
                    position,
                    normal,
                    tangent: tangent.extend(sign).to_array(),
                    uv: uv(u, v),
                    joints,
                });
            }
        }
        let row = sides as u16 + 1;
        for i in 0..rings as u16 {
            for j in 0..sides as u16 {
                let a = first + i * row + j;
                for triangle in [[a, a + 1, a + row], [a + 1, a + row + 1, a + row]] {
                    let p = triangle.map(|k| self.vertices[k as usize].position);
                    if (p[1] - p[0]).cross(p[2] - p[0]).length_squared() > 1e-26 {
                        self.indices.extend(triangle);
                    }
                }
            }
        }
    }
}
