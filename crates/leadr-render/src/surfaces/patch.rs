//! The smooth limit surface of one quad, a bicubic point-normal patch.
//!
//! Each boundary curve depends only on the positions and the normals of its two end points, so adjacent patches meet without
//! cracks. `shaders-glsl/passes/geometry` evaluates the same formulas on the device, and displacement is baked with the code of
//! this module. Corners run counter-clockwise seen from outside, in the order `(u, v)` = (0,0), (1,0), (1,1), (0,1), so `∂X/∂u ×
//! ∂X/∂v` points outwards.

use glam::{Vec2, Vec3};

/// The source code of this module, as part of cache keys. A change to the code invalidates cached results.
pub const SOURCE: &str = include_str!("patch.rs");

/// The position, the first derivatives and the displacement direction of a patch at one parameter.
#[derive(Clone, Copy, Debug, Default)]
pub struct PatchPoint {
    /// The position on the limit surface.
    pub position: Vec3,
    /// The derivative `∂X/∂u`, per unit of the patch parameter.
    pub du: Vec3,
    /// The derivative `∂X/∂v`, per unit of the patch parameter.
    pub dv: Vec3,
    /// The displacement direction as a unit vector, the normalised bilinear blend of the normals at the corners.
    pub normal: Vec3,
    /// The derivative `∂N/∂u`, per unit of the patch parameter.
    pub normal_du: Vec3,
    /// The derivative `∂N/∂v`, per unit of the patch parameter.
    pub normal_dv: Vec3,
}

/// The sixteen Bézier control points (`control[j][i]` with `i` along u), and the normals at the four corners.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    control: [[Vec3; 4]; 4],
    normals: [Vec3; 4],
}

/// Returns the inner Bézier point next to `a`, on the boundary from `a` to `b`. The point lies a third of the way to `b`, projected
/// onto the tangent plane of `a`.
fn edge_point(a: Vec3, normal_a: Vec3, b: Vec3) -> Vec3 {
    let chord = (b - a) / 3.0;
    a + chord - normal_a * chord.dot(normal_a)
}

impl Patch {
    /// Builds the patch from the positions and the unit normals of its corners, in the corner order of this module.
    pub fn new(p: [Vec3; 4], n: [Vec3; 4]) -> Self {
        let mut c = [[Vec3::ZERO; 4]; 4];
        (c[0][0], c[0][3], c[3][3], c[3][0]) = (p[0], p[1], p[2], p[3]);
        c[0][1] = edge_point(p[0], n[0], p[1]);
        c[0][2] = edge_point(p[1], n[1], p[0]);
        c[1][3] = edge_point(p[1], n[1], p[2]);
        c[2][3] = edge_point(p[2], n[2], p[1]);
        c[3][2] = edge_point(p[2], n[2], p[3]);
        c[3][1] = edge_point(p[3], n[3], p[2]);
        c[2][0] = edge_point(p[3], n[3], p[0]);
        c[1][0] = edge_point(p[0], n[0], p[3]);
        // The inner points are those of the discrete Coons patch of the boundary, which avoids flat spots at the corners.
        for j in 1..3 {
            for i in 1..3 {
                let (s, t) = (i as f32 / 3.0, j as f32 / 3.0);
                let ruled_u = c[j][0].lerp(c[j][3], s);
                let ruled_v = c[0][i].lerp(c[3][i], t);
                let bilinear = p[0].lerp(p[1], s).lerp(p[3].lerp(p[2], s), t);
                c[j][i] = ruled_u + ruled_v - bilinear;
            }
        }
        Self { control: c, normals: n }
    }

    /// Evaluates the patch at `(u, v)`. Parameters slightly outside `[0, 1]` extrapolate smoothly, which the gutters of an atlas
    /// require.
    pub fn at(&self, uv: Vec2) -> PatchPoint {
        let (bu, du) = cubic_bernstein(uv.x);
        let (bv, dv) = cubic_bernstein(uv.y);
        let mut point = PatchPoint::default();
        for j in 0..4 {
            for i in 0..4 {
                let c = self.control[j][i];
                point.position += c * (bu[i] * bv[j]);
                point.du += c * (du[i] * bv[j]);
                point.dv += c * (bu[i] * dv[j]);
            }
        }
        let n = &self.normals;
        let (bottom, top) = (n[0].lerp(n[1], uv.x), n[3].lerp(n[2], uv.x));
        let blend = bottom.lerp(top, uv.y);
        let length = blend.length();
        point.normal = blend / length;
        let tangential = |d: Vec3| (d - point.normal * d.dot(point.normal)) / length;
        point.normal_du = tangential((n[1] - n[0]).lerp(n[2] - n[3], uv.y));
        point.normal_dv = tangential(top - bottom);
        point
    }
}

/// Returns the four cubic Bernstein polynomials at `t`, and their derivatives.
fn cubic_bernstein(t: f32) -> ([f32; 4], [f32; 4]) {
    let s = 1.0 - t;
    (
        [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t],
        [-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t],
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curved() -> Patch {
        let p = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.2), Vec3::Y];
        let n =
            [Vec3::new(-0.2, -0.1, 1.0), Vec3::new(0.3, 0.0, 1.0), Vec3::new(0.1, 0.2, 1.0), Vec3::new(0.0, 0.3, 1.0)];
        Patch::new(p, n.map(Vec3::normalize))
    }

    #[test]
    fn derivatives_match_finite_differences() {
        let patch = curved();
        let e = 1e-2;
        for &(u, v) in &[(0.1, 0.2), (0.5, 0.5), (0.9, 0.35), (-0.02, 1.03)] {
            let at = |du: f32, dv: f32| patch.at(Vec2::new(u + du, v + dv));
            let p = at(0.0, 0.0);
            let fd = |f: fn(&PatchPoint) -> Vec3| {
                ((f(&at(e, 0.0)) - f(&at(-e, 0.0))) / (2.0 * e), (f(&at(0.0, e)) - f(&at(0.0, -e))) / (2.0 * e))
            };
            let (du, dv) = fd(|p| p.position);
            assert!((du - p.du).length() < 1e-3 && (dv - p.dv).length() < 1e-3, "{u} {v}");
            let (nu, nv) = fd(|p| p.normal);
            assert!((nu - p.normal_du).length() < 1e-3 && (nv - p.normal_dv).length() < 1e-3, "{u} {v}");
        }
    }

    #[test]
    fn tangent_planes_at_the_corners_are_those_of_the_normals() {
        let patch = curved();
        for (k, &(u, v)) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].iter().enumerate() {
            let p = patch.at(Vec2::new(u, v));
            assert!(p.du.cross(p.dv).normalize().dot(patch.normals[k]) > 0.999_99);
        }
    }
}
