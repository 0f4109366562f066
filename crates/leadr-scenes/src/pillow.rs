//! A quilted cushion on a floor (after LEADR Figure 9). Seams and buttons form diamonds on woven cloth, and the rim has a twisted cord.
//! Seams, buttons, threads and cord are displaced.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::{Affine3A, Vec2, Vec3};

use super::plane::{self, plane};
use super::sphere::{bake_patches, color_code, tiled_object};
use super::stage::{Stage, Views};
use leadr_maps::noise::smoothstep;
use leadr_render::camera::Camera;
use leadr_render::scene::{Object, Pose};
use leadr_render::surfaces::patch_mesh::PatchMesh;

/// Half the width of the cushion in metres.
const HALF: f32 = 0.25;
/// Height of the upper face above the rim, and of the rim above the floor, metres.
const THICKNESS: f32 = 0.1;
const LOWER: f32 = 0.026;
/// Patches along a side of each face.
const PATCHES: u32 = 12;
/// The number of metres of cloth per unit of the parameters `(s, t)`.
const CLOTH: f32 = HALF * 1.25;
/// Albedo and roughness of the floor.
const FLOOR: [f32; 4] = [0.46, 0.42, 0.37, 0.45];
/// Side and height of a diamond, metres.
const DIAMOND: f32 = 0.092;
const PUFF: f32 = 0.013;
/// The width of a thread in metres.
const THREAD: f32 = 0.0055;

/// Returns the point of the cushion at `(s, t)` in `[-1, 1]²`. `side` is 1 on the upper face and −1 on the lower face. The outline is
/// concave between pointed corners.
fn shape(s: f32, t: f32, side: f32) -> Vec3 {
    let (a, b) = ((FRAC_PI_2 * s).sin(), (FRAC_PI_2 * t).sin());
    let (ca, cb) = ((FRAC_PI_2 * s).cos(), (FRAC_PI_2 * t).cos());
    let pinch = |across: f32| 1.0 - 0.1 * across * across;
    // The lower face lies flat on the floor up to a few centimetres from the rim.
    let depth = if side > 0.0 { THICKNESS * ca * cb } else { -LOWER * (1.0 - (1.0 - ca * cb).powi(4)) };
    Vec3::new(HALF * a * pinch(cb), HALF * b * pinch(ca), depth)
}

/// Builds the two faces, which share their vertices at the rim.
fn mesh() -> PatchMesh {
    let n = PATCHES;
    let mut mesh = PatchMesh::default();
    let at = |i: u32| 2.0 * i as f32 / n as f32 - 1.0;
    let mut index = std::collections::HashMap::new();
    for side in [1.0f32, -1.0] {
        let mut vertex = |i: u32, j: u32| {
            let rim = i == 0 || i == n || j == 0 || j == n;
            *index.entry((i, j, !rim && side < 0.0)).or_insert_with(|| {
                let (s, t) = (at(i), at(j));
                mesh.positions.push(shape(s, t, side));
                let e = 1e-3;
                let ds = shape(s + e, t, side) - shape(s - e, t, side);
                let dt = shape(s, t + e, side) - shape(s, t - e, side);
                // The surface continues on the other face beyond the rim, so derivatives at the rim are smooth. The derivatives vanish at
                // the pointed corners.
                let corner = (i == 0 || i == n) && (j == 0 || j == n);
                let normal = if corner { Vec3::new(s, t, 0.0) } else { ds.cross(dt) * side };
                mesh.normals.push(normal.normalize());
                (mesh.positions.len() - 1) as u32
            })
        };
        for j in 0..n {
            for i in 0..n {
                let mut patch = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
                if side < 0.0 {
                    // The lower face is visible from below, so its orientation is reversed.
                    patch.swap(1, 3);
                }
                mesh.patches.push(patch);
            }
        }
    }
    mesh.colors = vec![[1.0; 4]; mesh.positions.len()];
    // The floor hides the lower hemisphere from points that face it.
    mesh.accessibility = mesh.normals.iter().map(|n| 0.55 + 0.45 * n.z).collect();
    mesh
}

/// Returns `(s, t)` of a point on a patch.
fn parameters(patch: usize, uv: Vec2) -> Vec2 {
    let per_face = (PATCHES * PATCHES) as usize;
    let uv = if patch < per_face { uv } else { Vec2::new(uv.y, uv.x) };
    let cell = (patch % per_face) as u32;
    (Vec2::new((cell % PATCHES) as f32, (cell / PATCHES) as f32) + uv) * (2.0 / PATCHES as f32) - 1.0
}

/// The properties of the cloth at a point.
#[derive(Clone, Copy, Debug)]
struct Cloth {
    /// The height above the smooth cushion, in metres.
    height: f32,
    /// The linear albedo.
    color: Vec3,
    /// Beckmann roughness.
    roughness: f32,
}

/// Evaluates two crossing threads of a plain weave. Returns the height in `[0, 1]`, and whether the warp is on top.
fn weave(p: Vec2) -> (f32, bool) {
    let cell = (p / THREAD).floor();
    let local = p / THREAD - cell - 0.5;
    let warp = (cell.x + cell.y).rem_euclid(2.0) < 1.0;
    let (across, along) = if warp { (local.x, local.y) } else { (local.y, local.x) };
    ((PI * across).cos().max(0.0).sqrt() * (0.45 + 0.55 * (PI * along).cos()), warp)
}

fn cloth(parameter: Vec2) -> Cloth {
    // Points beyond the rim lie on the other face.
    let parameter = parameter.clamp(Vec2::NEG_ONE - 0.1, Vec2::ONE + 0.1);
    let p = parameter * CLOTH;
    let inside = (1.0 - parameter.abs()) * CLOTH;
    let rim = inside.min_element();

    // Seams along u and v are the sides of the diamonds. The quilting starts a little inside the cord.
    let (u, v) = ((p.x + p.y) / DIAMOND + 0.5, (p.x - p.y) / DIAMOND + 0.5);
    let quilted = smoothstep(0.012, 0.05, rim);
    let puff = (PI * u).sin().abs() * (PI * v).sin().abs();
    let mut height = PUFF * (quilted * 1.5 * puff / (puff + 0.5) + (1.0 - quilted) * 0.55);
    let (thread, warp) = weave(p);
    height += 0.0007 * thread;
    let lift = smoothstep(0.0, 0.9, puff);
    let mut color = Vec3::new(0.012, 0.085, 0.105).lerp(Vec3::new(0.03, 0.17, 0.19), lift * quilted);
    color *= if warp { 1.1 } else { 0.9 } * (0.55 + 0.45 * thread) * (0.65 + 0.35 * lift);
    let mut roughness = 0.55;

    // The seams have stitches.
    let seam = |x: f32| (x - x.round()) * DIAMOND * std::f32::consts::FRAC_1_SQRT_2;
    for (across, along) in [(seam(u), v), (seam(v), u)] {
        let dash = (along * DIAMOND / 0.0095).fract().abs();
        let end = smoothstep(0.0, 0.18, dash) * smoothstep(1.0, 0.7, dash);
        let round = (1.0 - (across / 0.0019).powi(2)).max(0.0).sqrt() * end * quilted;
        if round > 0.0 {
            height += 0.0014 * round;
            color = color.lerp(Vec3::new(0.72, 0.5, 0.2), smoothstep(0.1, 0.4, round));
        }
    }

    // Every second crossing has a button in a dimple.
    let (cu, cv) = (u.round(), v.round());
    if quilted > 0.99 && (cu + cv).rem_euclid(2.0) < 0.5 {
        // Seams cross at right angles, so distances along u and v are orthogonal.
        let r = Vec2::new(seam(u), seam(v)).length();
        height -= 0.006 * (-(r / 0.02).powi(2)).exp();
        let edge = 1.0 - (r / 0.0125).powi(2);
        if edge > 0.0 {
            let groove = (1.0 - ((r - 0.009) / 0.0013).powi(2)).max(0.0);
            height += 0.0075 * smoothstep(0.0, 0.45, edge) * (0.8 + 0.2 * edge) - 0.0012 * groove;
            let thread = Vec3::new(0.62, 0.4, 0.12).lerp(Vec3::new(0.3, 0.18, 0.05), groove);
            color = color.lerp(thread, smoothstep(0.05, 0.25, edge));
            roughness = 0.3;
        }
    }

    // The rim has a cord that is twisted from two strands.
    let along = if inside.x < inside.y { p.y } else { p.x };
    let cord = 1.0 - (rim / 0.011).powi(2);
    if cord > 0.0 {
        let strand = (TAU * (along / 0.016 + rim.abs() / 0.03)).cos();
        height = height.max(0.004 + 0.011 * cord.sqrt()) + 0.0016 * strand * cord.sqrt();
        color = Vec3::new(0.5, 0.3, 0.085) * (0.75 + 0.25 * strand);
        roughness = 0.35;
    }
    Cloth { height, color, roughness }
}

/// Builds the static stage, with atlas tiles of `tile` texels.
pub fn stage(tile: u32) -> Stage {
    let mut mesh = mesh();
    let (layout, texels) = bake_patches(&mut mesh, tile, |patch, uv, _| {
        let Cloth { height, color, roughness } = cloth(parameters(patch, uv));
        (height, color_code(color.to_array(), roughness))
    });
    let (heights, colors) = texels.into_iter().unzip();
    let pillow = tiled_object("pillow", mesh, layout, heights, colors);
    let from = |direction: Vec3, distance: f32, target: Vec3| {
        Camera::looking_at(target + direction.normalize() * distance, target, 30.0)
    };
    let direction = Vec3::new(-0.5, -1.0, 0.78);
    let views = Views {
        near: from(Vec3::new(-0.35, -1.0, 0.75), 0.42, Vec3::new(0.02, -0.06, 0.1)),
        mid: from(direction, 1.05, Vec3::Z * 0.06),
        far: from(direction, 4.5, Vec3::Z * 0.08),
    };
    let lifted = Affine3A::from_translation(Vec3::Z * (LOWER + 0.5 * PUFF));
    let still = move |_| vec![Pose::Rigid(lifted), Pose::REST];
    let [r, g, b, _] = FLOOR;
    Stage::moving(vec![pillow, floor()], views, still, |_| Vec3::ZERO).with_albedo_below([r, g, b])
}

/// Builds a pale floor that is darker under the cushion.
fn floor() -> Object {
    let mut mesh = plane(400.0, 112, 1.0, FLOOR, |t| (9.0 * t).sinh() / 9.0f32.sinh());
    mesh.accessibility = mesh
        .positions
        .iter()
        .map(|p| {
            // The occlusion is approximately that of a disc just above the floor.
            let outside = ((p.x.powi(4) + p.y.powi(4)).powf(0.25) - 0.7 * HALF).max(0.0);
            1.0 - 0.85 * (-(outside / 0.06).powi(2)).exp() - 0.12 * (-(outside / 0.3)).exp()
        })
        .collect();
    plane::floor(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_render::surfaces::topology::Topology;

    #[test]
    fn the_cushion_is_closed_and_faces_outwards() {
        let mesh = mesh();
        assert_eq!(Topology::new(&mesh.patches).irregular_edges(), 0);
        for patch in &mesh.patches {
            let p = patch.map(|v| mesh.positions[v as usize]);
            let flat = (p[2] - p[0]).cross(p[3] - p[1]);
            let normal: Vec3 = patch.iter().map(|&v| mesh.normals[v as usize]).sum();
            assert!(flat.dot(normal) > 0.0, "{p:?}");
        }
    }

    #[test]
    fn pillow_faces_agree_along_rim() {
        let mesh = mesh();
        for (index, patch) in mesh.patches.iter().enumerate() {
            let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
            for (&vertex, uv) in patch.iter().zip(corners) {
                let st = parameters(index, uv);
                let side = if index < mesh.patches.len() / 2 { 1.0 } else { -1.0 };
                assert!(shape(st.x, st.y, side).distance(mesh.positions[vertex as usize]) < 1e-6);
            }
        }
    }

    #[test]
    fn the_cloth_is_as_high_as_it_should_be() {
        for i in 0..10_000u32 {
            let at = Vec2::new((i % 100) as f32, (i / 100) as f32) / 49.5 - 1.0;
            let cloth = cloth(at);
            assert!((-0.007..0.022).contains(&cloth.height), "{at} {}", cloth.height);
            assert!(cloth.color.min_element() > 0.0 && cloth.color.max_element() < 1.0);
        }
    }
}
