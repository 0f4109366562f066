//! Teeth, claws, eyes, tongue, fingers and dew claws. All of these props are closed, smooth, rigid meshes of quads with vertex colours.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::dual::QuadSurface;
use super::noise::{hash, unit};
use super::parts::{Frame, Space};
use super::skin::Skin;
use leadr_maps::noise::smoothstep as ss;
use leadr_render::surfaces::patch_mesh::{PatchMesh, SkinWeights};

/// The left joints in the skeleton table. The index of the right joint is higher by [`RIGHT`].
const HEAD: u16 = 8;
const JAW: u16 = 9;
const EYE: u16 = 10;
const ANKLE: u16 = 22;
const TOES: [u16; 3] = [24, 25, 26];
const WRIST: u16 = 29;
/// The offset from the index of a left limb joint to the index of the right joint.
const RIGHT: u16 = 10;

/// The radius of the eyeball in metres.
const EYE_RADIUS: f32 = 0.047 * 1.09;
/// The number of sides of horns and fingers.
const SIDES: usize = 8;

/// The number of patches of the props. A few curved patches are as smooth as many patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// The mesh for views in which a patch covers pixels.
    Fine,
    /// The mesh for views in which the patches of the fine mesh are smaller than pixels.
    Coarse,
}

impl Detail {
    /// Returns the step between the sides of a tube that are kept. In the coarse mesh, it is `step`.
    fn step(self, step: usize) -> usize {
        match self {
            Self::Fine => 1,
            Self::Coarse => step,
        }
    }

    /// Whether a ring of a tube is kept. The coarse mesh keeps every third ring and the last ring.
    fn keeps(self, ring: usize, rings: usize) -> bool {
        ring.is_multiple_of(self.step(3)) || ring + 1 == rings
    }

    /// Removes the rings and points of a tube that are not kept.
    fn thin(self, rings: Vec<Vec<Vec3>>, step: usize) -> Vec<Vec<Vec3>> {
        let count = rings.len();
        let kept = rings.into_iter().enumerate().filter(|(i, _)| self.keeps(*i, count));
        kept.map(|(_, ring)| ring.into_iter().step_by(self.step(step)).collect()).collect()
    }
}

const ENAMEL: [f32; 4] = [0.74, 0.68, 0.52, 0.10];
const KERATIN: [f32; 4] = [0.09, 0.08, 0.07, 0.13];
const TONGUE: [f32; 4] = [0.40, 0.13, 0.12, 0.07];

/// Joins rings of points into a tube whose ends are fans of quads. Each ring must have an even number of points.
fn tube(rings: &[Vec<Vec3>], ends: [Vec3; 2]) -> QuadSurface {
    let n = rings[0].len();
    let mut positions = rings.concat();
    let mut quads = Vec::new();
    let at = |ring: usize, k: usize| (ring * n + k % n) as u32;
    let last = rings.len() - 1;
    for ring in 0..last {
        for k in 0..n {
            quads.push([at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)]);
        }
    }
    let tip = positions.len() as u32;
    positions.extend(ends);
    for k in (0..n).step_by(2) {
        quads.push([tip, at(0, k + 2), at(0, k + 1), at(0, k)]);
        quads.push([tip + 1, at(last, k), at(last, k + 1), at(last, k + 2)]);
    }
    let volume = |q: &[u32; 4]| wedge(q.map(|v| positions[v as usize]), positions[0]);
    if quads.iter().map(volume).sum::<f32>() < 0.0 {
        quads.iter_mut().for_each(|q| q.reverse());
    }
    QuadSurface { positions, quads }
}

/// Returns six times the signed volume between a quad (as two triangles) and `o`.
fn wedge(p: [Vec3; 4], o: Vec3) -> f32 {
    let [a, b, c, d] = p.map(|p| p - o);
    a.dot(b.cross(c)) + a.dot(c.cross(d))
}

fn append(
    mesh: &mut PatchMesh,
    solid: &QuadSurface,
    joint: u16,
    color: &dyn Fn(Vec3) -> [f32; 4],
    open: &dyn Fn(Vec3) -> f32,
) {
    let base = mesh.positions.len() as u32;
    let mut normals = vec![Vec3::ZERO; solid.positions.len()];
    for q in &solid.quads {
        let p = q.map(|v| solid.positions[v as usize]);
        // The sum of unit corner normals is robust at tips whose corners coincide.
        for k in 0..4 {
            let (next, before) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
            normals[q[k] as usize] += next.cross(before).normalize_or_zero();
        }
        mesh.patches.push(q.map(|v| v + base));
        mesh.texcoords.push([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
    }
    mesh.normals.extend(normals.into_iter().map(|n| n.normalize_or(Vec3::Z)));
    mesh.colors.extend(solid.positions.iter().map(|&p| color(p)));
    mesh.accessibility.extend(solid.positions.iter().map(|&p| open(p)));
    mesh.positions.extend(&solid.positions);
    let skin = SkinWeights { joints: [joint, 0, 0, 0], weights: [1.0, 0.0, 0.0, 0.0] };
    mesh.skin.extend(std::iter::repeat_n(skin, solid.positions.len()));
}

/// Builds a tapered horn that is swept along a quadratic Bézier path.
fn horn(path: [Vec3; 3], radius: f32, taper: f32, detail: Detail) -> QuadSurface {
    let rings = [0.0, 0.18, 0.38, 0.58, 0.76, 0.89, 0.97];
    let at = |s: f32| path[0] * ((1.0 - s) * (1.0 - s)) + path[1] * (2.0 * s * (1.0 - s)) + path[2] * (s * s);
    let ring = |s: f32| {
        let tangent = ((path[1] - path[0]) * (1.0 - s) + (path[2] - path[1]) * s).normalize();
        let a = tangent.cross(Vec3::new(0.13, 0.97, 0.2)).normalize();
        let b = tangent.cross(a);
        let r = radius * (1.0 - s).powf(taper).max(0.03);
        let turn = TAU / SIDES as f32;
        (0..SIDES).map(|k| at(s) + (a * (k as f32 * turn).cos() + b * (0.75 * (k as f32 * turn).sin())) * r).collect()
    };
    tube(&detail.thin(rings.map(ring).into(), 2), [at(0.0) - (at(0.05) - at(0.0)) * 0.5, at(1.0)])
}

/// Builds a round cone with hemispherical ends, from rings of `SIDES` points.
fn round_cone(a: Vec3, b: Vec3, radius_a: f32, radius_b: f32, detail: Detail) -> QuadSurface {
    let axis = (b - a).normalize();
    let u = axis.any_orthonormal_vector();
    let v = axis.cross(u);
    let ring = |c: Vec3, r: f32| {
        let turn = TAU / SIDES as f32;
        (0..SIDES).map(|k| c + (u * (k as f32 * turn).cos() + v * (k as f32 * turn).sin()) * r).collect()
    };
    // Returns a ring of an end's hemisphere, `degrees` from its rim.
    let cap = |end: Vec3, outward: Vec3, radius: f32, degrees: f32| {
        let (s, c) = degrees.to_radians().sin_cos();
        ring(end + outward * (radius * s), radius * c)
    };
    let mut rings: Vec<Vec<Vec3>> = [60.0, 30.0].map(|degrees| cap(a, -axis, radius_a, degrees)).into();
    // Shallow transverse ripples look like scutes.
    for i in 0..=12 {
        let t = i as f32 / 12.0;
        let ripple = if i % 2 == 1 { 1.05 } else { 0.99 };
        rings.push(ring(a.lerp(b, t), (radius_a + (radius_b - radius_a) * t) * ripple));
    }
    rings.extend([30.0, 60.0].map(|degrees| cap(b, axis, radius_b, degrees)));
    tube(&detail.thin(rings, 2), [a - axis * radius_a, b + axis * radius_b])
}

/// Mirrors a point to the right side if `side` is −1.
fn mirror(p: Vec3, side: f32) -> Vec3 {
    Vec3::new(p.x, p.y * side, p.z)
}

/// Returns points on a polyline at equal spacing along its length, with their fractions of this length.
fn along(points: &[[f32; 3]], count: usize) -> Vec<(Vec3, f32)> {
    let points: Vec<Vec3> = points.iter().map(|p| Vec3::from_array(*p)).collect();
    let total: f32 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
    let at = |fraction: f32| {
        let mut left = fraction * total;
        for w in points.windows(2) {
            let length = w[0].distance(w[1]);
            if left <= length {
                return w[0].lerp(w[1], left / length);
            }
            left -= length;
        }
        points[points.len() - 1]
    };
    (0..count).map(|i| i as f32 / (count - 1) as f32).map(|t| (at(t), t)).collect()
}

const UPPER_ROW: [[f32; 3]; 7] = [
    [0.40, 0.262, -0.245],
    [0.58, 0.212, -0.275],
    [0.82, 0.172, -0.290],
    [1.02, 0.142, -0.265],
    [1.17, 0.106, -0.222],
    [1.275, 0.055, -0.203],
    [1.30, 0.015, -0.200],
];
const LOWER_ROW: [[f32; 3]; 6] = [
    [0.36, 0.238, -0.030],
    [0.60, 0.185, -0.026],
    [0.85, 0.148, -0.024],
    [1.04, 0.112, -0.026],
    [1.14, 0.072, -0.026],
    [1.175, 0.02, -0.028],
];

fn teeth(mesh: &mut PatchMesh, frame: &Frame, upper: bool, detail: Detail) {
    let (row, count, down, sunk, joint): (&[[f32; 3]], _, _, _, _) =
        if upper { (&UPPER_ROW, 15, -1.0, 0.03, HEAD) } else { (&LOWER_ROW, 13, 1.0, 0.025, JAW) };
    for (i, (base, t)) in along(row, count).into_iter().enumerate() {
        let random = unit(hash(i as i32, i32::from(upper), 0, 3));
        let bulge = (std::f32::consts::PI * (0.80 * t + 0.10)).sin();
        let mut length = (0.055 + 0.075 * bulge.powf(1.5)) * (0.78 + 0.35 * random);
        length *= if upper { 1.0 } else { 0.72 } * if t > 0.82 { 0.8 } else { 1.0 };
        let root = base - Vec3::Z * (down * sunk);
        let bend = root + Vec3::new(0.018, 0.006, down * (0.6 * length + sunk));
        let tip = root + Vec3::new(-0.020, 0.0, down * (length + sunk));
        let radius = if t < 0.82 { 0.026 } else { 0.018 } * frame.scale;
        for side in [1.0, -1.0] {
            let path = [root, bend, tip].map(|p| frame.point(mirror(p, side)));
            let reach = path[0].distance(path[2]);
            let stained = |p: Vec3| {
                // Teeth are browner near the gum.
                let s = ss(0.25, 0.7, path[0].distance(p) / reach);
                let tint = [0.55 + 0.45 * s, 0.46 + 0.54 * s, 0.36 + 0.64 * s, 1.0];
                std::array::from_fn(|k| ENAMEL[k] * tint[k])
            };
            let open = |p: Vec3| 0.45 + 0.5 * ss(0.2, 0.8, path[0].distance(p) / reach);
            append(mesh, &horn(path, radius, 0.62, detail), joint, &stained, &open);
        }
    }
}

fn claws(mesh: &mut PatchMesh, detail: Detail) {
    // The end and the direction of each toe's last cone, and the radius and the length of its claw.
    let toes = [
        (TOES[0], [0.4266, 0.2193, 0.100], [0.5988, 0.1390, 0.085], 0.058, 0.19),
        (TOES[1], [0.7297, 0.4368, 0.085], [0.8896, 0.4423, 0.075], 0.060, 0.20),
        (TOES[2], [0.5019, 0.7261, 0.085], [0.6026, 0.7914, 0.075], 0.052, 0.17),
    ];
    let mut paths: Vec<([Vec3; 3], f32, f32, u16)> = Vec::new();
    for (joint, from, to, radius, length) in toes {
        let (from, to) = (Vec3::from_array(from), Vec3::from_array(to));
        let d = ((to - from) * Vec3::new(1.0, 1.0, 0.0)).normalize();
        let root = to - d * 0.03 + Vec3::Z * 0.015;
        let path = [root, root + d * (0.6 * length) + Vec3::Z * 0.03, root + d * length - Vec3::Z * 0.075];
        paths.push((path, radius, 0.72, joint));
    }
    let v = Vec3::new;
    paths.push(([v(0.030, 0.305, 0.220), v(0.000, 0.275, 0.160), v(-0.010, 0.280, 0.100)], 0.034, 0.7, ANKLE));
    paths.push(([v(2.300, 0.528, 1.770), v(2.370, 0.510, 1.730), v(2.360, 0.505, 1.640)], 0.024, 0.7, WRIST));
    paths.push(([v(2.310, 0.600, 1.740), v(2.375, 0.600, 1.690), v(2.360, 0.600, 1.600)], 0.025, 0.7, WRIST));
    for (path, radius, taper, joint) in paths {
        for (side, joint) in [(1.0, joint), (-1.0, joint + RIGHT)] {
            let path = path.map(|p| mirror(p, side));
            let worn = |p: Vec3| {
                let s = ss(0.5, 1.0, path[0].distance(p) / path[0].distance(path[2]));
                [KERATIN[0] + 0.07 * s, KERATIN[1] + 0.06 * s, KERATIN[2] + 0.05 * s, KERATIN[3]]
            };
            append(mesh, &horn(path, radius, taper, detail), joint, &worn, &|_| 0.9);
        }
    }
}

fn digits(mesh: &mut PatchMesh, skin: &Skin, detail: Detail) {
    let v = Vec3::new;
    let cones = [
        (v(0.050, 0.3521, 0.320), v(0.020, 0.2906, 0.200), 0.050, 0.036, ANKLE),
        (v(2.195, 0.559, 1.853), v(2.310, 0.525, 1.760), 0.036, 0.025, WRIST),
        (v(2.205, 0.600, 1.845), v(2.320, 0.600, 1.730), 0.038, 0.026, WRIST),
    ];
    for (a, b, ra, rb, joint) in cones {
        for (side, joint) in [(1.0, joint), (-1.0, joint + RIGHT)] {
            let color = |p: Vec3| {
                let relief = super::skin::SkinPoint { height: 0.002, top: 0.75, fold: 0.0 };
                skin.shade(p, &relief, 0.0)
            };
            append(mesh, &round_cone(mirror(a, side), mirror(b, side), ra, rb, detail), joint, &color, &|_| 0.85);
        }
    }
}

/// The stations of the tongue in the jaw frame: x, z, half the width, and half the height up and down. The mesh covers the tongue of the
/// distance field, because the body's tiles can only approximate the tongue.
const TONGUE_STATIONS: [[f32; 5]; 9] = [
    [0.08, -0.112, 0.122, 0.030, 0.05],
    [0.14, -0.106, 0.160, 0.056, 0.07],
    [0.28, -0.094, 0.151, 0.058, 0.07],
    [0.45, -0.083, 0.134, 0.056, 0.07],
    [0.60, -0.073, 0.118, 0.052, 0.07],
    [0.75, -0.062, 0.099, 0.048, 0.06],
    [0.87, -0.054, 0.077, 0.042, 0.06],
    [0.94, -0.050, 0.052, 0.034, 0.05],
    [0.972, -0.052, 0.024, 0.018, 0.03],
];

fn tongue(mesh: &mut PatchMesh, jaw: &Frame, detail: Detail) {
    let sides = 12;
    let ring = |s: &[f32; 5]| {
        let turn = TAU / sides as f32;
        (0..sides)
            .map(|k| {
                let (sin, cos) = (k as f32 * turn).sin_cos();
                // A furrow runs along the middle of the upper side.
                let furrow = if sin > 0.0 { 0.16 * sin.powi(6) } else { 0.0 };
                let z = s[1] + (sin - furrow) * if sin > 0.0 { s[3] } else { s[4] };
                jaw.point(Vec3::new(s[0], s[2] * cos, z))
            })
            .collect()
    };
    let (first, last) = (TONGUE_STATIONS[0], TONGUE_STATIONS[8]);
    let ends = [(first, -0.03), (last, 0.008)].map(|(s, d)| jaw.point(Vec3::new(s[0] + d, 0.0, s[1])));
    let solid = tube(&detail.thin(TONGUE_STATIONS.iter().map(ring).collect(), 2), ends);
    let blotched = |p: Vec3| {
        let n = super::noise::value(p * 30.0, 71);
        [TONGUE[0] * (0.8 + 0.4 * n), TONGUE[1] * (0.7 + 0.6 * n), TONGUE[2] * (0.7 + 0.6 * n), TONGUE[3]]
    };
    append(mesh, &solid, JAW, &blotched, &|_| 0.55);
}

/// The rings of the eye about the line of sight. Each has the half angles across and along the slit (in radians), and a colour. Two rings
/// lie close together on both sides of each boundary, so vertex colours give sharp edges.
const EYE_RINGS: [(f32, f32, [f32; 3]); 16] = [
    (0.040, 0.200, PUPIL),
    (0.105, 0.420, PUPIL),
    (0.125, 0.450, INNER_IRIS),
    (0.230, 0.510, INNER_IRIS),
    (0.400, 0.580, IRIS),
    (0.560, 0.660, IRIS),
    (0.700, 0.740, IRIS),
    (0.820, 0.830, OUTER_IRIS),
    (0.870, 0.875, LIMBUS),
    (0.960, 0.960, LIMBUS),
    (1.050, 1.050, SCLERA),
    (1.300, 1.300, SCLERA),
    (1.650, 1.650, SCLERA),
    (2.050, 2.050, SCLERA),
    (2.500, 2.500, SCLERA),
    (2.850, 2.850, SCLERA),
];

const PUPIL: [f32; 3] = [0.006; 3];
const INNER_IRIS: [f32; 3] = [0.68, 0.46, 0.10];
const IRIS: [f32; 3] = [0.55, 0.30, 0.05];
const OUTER_IRIS: [f32; 3] = [0.30, 0.13, 0.025];
const LIMBUS: [f32; 3] = [0.025, 0.015, 0.010];
const SCLERA: [f32; 3] = [0.10, 0.06, 0.03];

fn eyes(mesh: &mut PatchMesh, head: &Frame, detail: Detail) {
    const SECTORS: usize = 32;
    const EYE_STEP: usize = 4;
    for (side, joint) in [(1.0, EYE), (-1.0, EYE + 1)] {
        let center = head.point(Vec3::new(0.418, 0.282 * side, 0.150));
        let look = (head.rotation * Vec3::new(0.44, 0.88 * side, 0.05)).normalize();
        let up = (head.rotation * Vec3::Z - look * look.dot(head.rotation * Vec3::Z)).normalize();
        let across = up.cross(look);
        let turn = TAU / SECTORS as f32;
        let point = |a: f32, b: f32, k: usize| {
            let (sin, cos) = (k as f32 * turn).sin_cos();
            let (x, y) = (a * cos, b * sin);
            let angle = x.hypot(y);
            let outwards = (across * x + up * y) / angle;
            center + (look * angle.cos() + outwards * angle.sin()) * EYE_RADIUS
        };
        let rings = EYE_RINGS.iter().map(|(a, b, _)| (0..SECTORS).map(|k| point(*a, *b, k)).collect()).collect();
        let ends = [center + look * EYE_RADIUS, center - look * EYE_RADIUS];
        let solid = tube(&detail.thin(rings, EYE_STEP), ends);
        let mut colors = Vec::new();
        let rings = EYE_RINGS.iter().enumerate().filter(|(ring, _)| detail.keeps(*ring, EYE_RINGS.len()));
        for (ring, &(.., color)) in rings {
            for k in (0..SECTORS).step_by(detail.step(EYE_STEP)) {
                // The iris has radial streaks, which are constant along a sector.
                let streak = 0.7 + 0.5 * unit(hash(k as i32, 0, 0, 5)) + 0.2 * unit(hash(k as i32, ring as i32, 0, 6));
                let is_iris = [INNER_IRIS, IRIS, OUTER_IRIS].contains(&color);
                let [r, g, b] = color.map(|c| if is_iris { c * streak } else { c });
                colors.push([r.min(0.9), g, b, 0.03]);
            }
        }
        colors.extend([PUPIL, SCLERA].map(|[r, g, b]| [r, g, b, 0.03]));
        let base = mesh.positions.len();
        append(mesh, &solid, joint, &|_| [0.0; 4], &|_| 0.8);
        mesh.colors[base..].copy_from_slice(&colors);
        for (n, p) in mesh.normals[base..].iter_mut().zip(&solid.positions) {
            *n = (*p - center).normalize();
        }
    }
}

/// Builds all props: teeth, claws, fingers, dew claws, tongue and eyes. All coordinates are in metres, in the bind pose. Each prop is
/// attached rigidly to one joint of the skeleton.
pub fn build(skin: &Skin, detail: Detail) -> PatchMesh {
    let (head, jaw) = (Space::Head.frame(), Space::Jaw.frame());
    let mut mesh = PatchMesh::default();
    teeth(&mut mesh, &head, true, detail);
    teeth(&mut mesh, &jaw, false, detail);
    claws(&mut mesh, detail);
    digits(&mut mesh, skin, detail);
    tongue(&mut mesh, &jaw, detail);
    eyes(&mut mesh, &head, detail);
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_render::surfaces::patch::Patch;
    use std::collections::HashMap;

    /// Counts boundary edges and non-manifold edges. Such edges are not used exactly once in each direction.
    fn open_edges(mesh: &PatchMesh) -> usize {
        let mut uses: HashMap<[u32; 2], i32> = HashMap::new();
        for q in &mesh.patches {
            for k in 0..4 {
                *uses.entry([q[k], q[(k + 1) % 4]]).or_default() += 1;
            }
        }
        uses.iter().filter(|([a, b], n)| **n != 1 || uses.get(&[*b, *a]) != Some(&1)).count()
    }

    #[test]
    fn closed_and_facing_outwards() {
        for detail in [Detail::Fine, Detail::Coarse] {
            is_closed_and_faces_outwards(build(&Skin::new(), detail));
        }
    }

    #[test]
    fn the_coarse_mesh_is_as_large_in_a_fifth_of_the_patches() {
        let [fine, coarse] = [Detail::Fine, Detail::Coarse].map(|detail| build(&Skin::new(), detail));
        let area = |mesh: &PatchMesh| {
            let corners = |q: &[u32; 4]| q.map(|v| mesh.positions[v as usize]);
            let area = |[a, b, c, d]: [Vec3; 4]| 0.5 * (c - a).cross(d - b).length();
            mesh.patches.iter().map(|q| area(corners(q))).sum::<f32>()
        };
        println!("{} and {} patches", fine.patches.len(), coarse.patches.len());
        assert!(coarse.patches.len() * 5 < fine.patches.len());
        assert!((area(&coarse) / area(&fine) - 1.0).abs() < 0.15, "{} {}", area(&coarse), area(&fine));
    }

    fn is_closed_and_faces_outwards(mut mesh: PatchMesh) {
        println!("{} patches, {} vertices", mesh.patches.len(), mesh.positions.len());
        assert_eq!(open_edges(&mesh), 0);
        let count = mesh.positions.len();
        assert!([mesh.normals.len(), mesh.colors.len(), mesh.accessibility.len(), mesh.skin.len()] == [count; 4]);
        // Every component has positive volume. The vertices of a component are contiguous.
        let mut component: Vec<usize> = (0..count).collect();
        fn find(c: &mut [usize], mut i: usize) -> usize {
            while c[i] != i {
                c[i] = c[c[i]];
                i = c[i];
            }
            i
        }
        for q in &mesh.patches {
            for k in 1..4 {
                let (a, b) = (find(&mut component, q[0] as usize), find(&mut component, q[k] as usize));
                component[a.max(b)] = a.min(b);
            }
        }
        let mut volumes: HashMap<usize, f32> = HashMap::new();
        for q in &mesh.patches {
            let root = find(&mut component, q[0] as usize);
            *volumes.entry(root).or_default() += wedge(q.map(|v| mesh.positions[v as usize]), mesh.positions[root]);
        }
        assert_eq!(volumes.len(), 2 * (15 + 13) + 12 + 6 + 1 + 2);
        assert!(volumes.values().all(|v| *v > 0.0), "{volumes:?}");
        // The limit surface agrees with the corner normals.
        for (i, q) in mesh.patches.iter().enumerate() {
            let patch = Patch::new(q.map(|v| mesh.positions[v as usize]), q.map(|v| mesh.normals[v as usize]));
            let p = patch.at(Vec2::splat(0.5));
            assert!(p.du.cross(p.dv).dot(p.normal) > 0.0, "patch {i}");
        }
        // The check fails if a patch is missing.
        mesh.patches.pop();
        assert!(open_edges(&mesh) > 0);
    }

    #[test]
    fn joints_are_those_of_the_skeleton() {
        use crate::trex::skeleton::{JOINTS, joint_index};
        let named = [(HEAD, "head"), (JAW, "jaw"), (EYE, "eye_L"), (EYE + 1, "eye_R"), (ANKLE, "ankle_L")];
        let more = [(TOES[0], "toe2_L"), (TOES[1], "toe3_L"), (TOES[2], "toe4_L"), (WRIST, "wrist_L")];
        for (index, name) in named.into_iter().chain(more) {
            assert_eq!(usize::from(index), joint_index(name), "{name}");
            if let Some(stem) = name.strip_suffix("_L").filter(|s| *s != "eye") {
                assert_eq!(usize::from(index + RIGHT), joint_index(&format!("{stem}_R")));
            }
        }
        let mesh = build(&Skin::new(), Detail::Fine);
        for (p, skin) in mesh.positions.iter().zip(&mesh.skin) {
            let joint = &JOINTS[usize::from(skin.joints[0])];
            // The point of the snout is the furthest from its joint. The side of the joint must match.
            assert!(p.distance(joint.position) < 1.7, "{} at {p}", joint.name);
            assert!(joint.position.y * p.y >= 0.0, "{} at {p}", joint.name);
        }
    }

    #[test]
    fn symmetric_about_the_middle_plane() {
        let mesh = build(&Skin::new(), Detail::Fine);
        let sum: Vec3 = mesh.positions.iter().sum();
        assert!(sum.y.abs() < 1e-2, "{sum}");
    }
}
