//! The smooth body of the snake: a tube along a coiled curve, which is flattened on the ground and has a head at its end.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use leadr_maps::noise::smoothstep;
use leadr_render::surfaces::patch_mesh::PatchMesh;

/// The number of patches around the body.
pub const AROUND: u32 = 12;
/// The number of patches along the body.
pub const ALONG: u32 = 108;

/// The largest radius of the body, in metres.
pub const THICK: f32 = 0.115;

/// A cross-section of the body.
#[derive(Clone, Copy, Debug)]
pub struct Ring {
    /// The centre of the cross-section.
    pub centre: Vec3,
    /// The direction toward the head.
    pub forward: Vec3,
    /// The direction to the left of the snake.
    pub left: Vec3,
    /// The direction away from the belly.
    pub up: Vec3,
    /// Half the width and half the height of the cross-section.
    pub half: Vec2,
}

/// The cross-sections from the tip of the tail to the snout.
#[derive(Clone, Debug)]
pub struct Body {
    /// The cross-sections, of which there are `ALONG + 1`.
    pub rings: Vec<Ring>,
    /// The distance along the body to each ring, in metres.
    pub distance: Vec<f32>,
    /// The ratio of length to girth from the tail to each ring: `∫ ds / (2π r)`.
    pub girths: Vec<f32>,
}

/// The length of the curve of `control_points` from tail to snout, in metres.
const LENGTH: f32 = 8.47;

/// Returns the distance in metres to the snout from `x`, which runs from the tail (0) to the snout (1).
pub fn to_snout(x: f32) -> f32 {
    (1.0 - x) * LENGTH
}

/// Returns half the width and half the height at `x`, from the tail (0) to the snout (1).
fn section(x: f32) -> Vec2 {
    let d = to_snout(x);
    let trunk = 0.009 + (THICK - 0.009) * smoothstep(-0.06, 0.52, x).powf(1.1);
    let neck = 1.0 - 0.52 * smoothstep(3.0, 0.42, d);
    // The jaws are wide at the back, and a blunt snout is in front of them.
    let jaw = smoothstep(0.4, 0.22, d) * smoothstep(-0.05, 0.2, d);
    let front = smoothstep(0.26, -0.02, d);
    let width = trunk * neck * (1.0 - 0.42 * front) + 0.034 * jaw;
    let height = trunk * neck * (1.0 - 0.5 * front) + 0.007 * jaw;
    // The snout is rounded off over its last centimetres.
    let round = 0.45 + 0.55 * (1.0 - (1.0 - (d / 0.07).clamp(0.0, 1.0)).powi(2)).sqrt();
    Vec2::new(width, height) * round
}

/// Returns the control points of the curve. The tail is outside, then come two turns inwards, and then the curve rises over the coil.
fn control_points() -> Vec<Vec3> {
    let turns = 2.05;
    let steps = 26;
    let mut points: Vec<Vec3> = (0..=steps)
        .map(|i| {
            let t = i as f32 / steps as f32;
            let angle = TAU * (0.36 + turns * t);
            let radius = 0.80 - 0.50 * t + 0.035 * (3.0 * angle).sin() * (1.0 - t);
            let x = t * 0.72;
            Vec3::new(radius * angle.cos(), radius * angle.sin(), section(x).y * 0.96)
        })
        .collect();
    // The inner turn rises from the centre. The neck is drawn back behind the head.
    points.extend([
        Vec3::new(-0.19, -0.13, 0.17),
        Vec3::new(0.02, -0.22, 0.26),
        Vec3::new(0.19, -0.1, 0.35),
        Vec3::new(0.17, 0.1, 0.45),
        Vec3::new(0.02, 0.12, 0.53),
        Vec3::new(-0.07, -0.02, 0.575),
        Vec3::new(-0.06, -0.19, 0.575),
        Vec3::new(-0.02, -0.34, 0.55),
        Vec3::new(0.01, -0.46, 0.52),
    ]);
    points
}

/// Returns a point of the uniform cubic B-spline, which smooths the polygon of its control points.
fn spline(points: &[Vec3], t: f32) -> Vec3 {
    let last = points.len() as i64 - 1;
    let i = (t.floor() as i64).clamp(0, last - 1);
    let f = t - i as f32;
    // The mirrored ends make the curve start at the first control point and end at the last.
    let at = |k: i64| match k {
        k if k < 0 => 2.0 * points[0] - points[1],
        k if k > last => 2.0 * points[last as usize] - points[last as usize - 1],
        k => points[k as usize],
    };
    let g = 1.0 - f;
    (at(i - 1) * (g * g * g)
        + at(i) * (3.0 * f * f * f - 6.0 * f * f + 4.0)
        + at(i + 1) * (3.0 * g * g * g - 6.0 * g * g + 4.0)
        + at(i + 2) * (f * f * f))
        / 6.0
}

impl Body {
    /// Builds the coiled snake.
    pub fn new() -> Self {
        let points = control_points();
        let samples: Vec<Vec3> =
            (0..=4000).map(|i| spline(&points, i as f32 / 4000.0 * (points.len() - 1) as f32)).collect();
        let mut length = vec![0.0f32];
        for pair in samples.windows(2) {
            length.push(length[length.len() - 1] + pair[0].distance(pair[1]));
        }
        let total = length[length.len() - 1];
        // Rings are four times as dense at the head, where the girth changes fast.
        let fraction = |k: u32| {
            let t = k as f32 / ALONG as f32;
            t + 0.75 * t * t * (1.0 - t)
        };
        let at = |x: f32| {
            let s = (x * total).clamp(0.0, total);
            let i = length.partition_point(|&l| l < s).clamp(1, samples.len() - 1);
            samples[i - 1].lerp(samples[i], ((s - length[i - 1]) / (length[i] - length[i - 1])).clamp(0.0, 1.0))
        };
        let mut rings: Vec<Ring> = Vec::new();
        let (mut distance, mut girths) = (Vec::new(), vec![0.0]);
        let mut up = Vec3::Z;
        for k in 0..=ALONG {
            let x = fraction(k).clamp(0.0, 1.0);
            let forward = (at((x + 0.003).min(1.0)) - at((x - 0.003).max(0.0))).normalize();
            // The up vector is transported along the curve without twist. It is also pulled toward the vertical, to keep the belly down.
            up = (up + Vec3::Z * 0.35).reject_from(forward).normalize();
            let half = section(x);
            if let Some(last) = rings.last() {
                let mean = 0.25 * (half.x + half.y + last.half.x + last.half.y);
                let step = (x * total - distance[distance.len() - 1]) / (TAU * mean);
                girths.push(girths[girths.len() - 1] + step);
            }
            distance.push(x * total);
            rings.push(Ring { centre: at(x), forward, left: up.cross(forward), up, half });
        }
        Self { rings, distance, girths }
    }

    /// Returns the metres from tail to snout.
    pub fn length(&self) -> f32 {
        self.distance[ALONG as usize]
    }

    /// Returns a point at `angle` around ring `k`. An angle of 0 is left, and a quarter turn is up.
    pub fn point(&self, k: usize, angle: f32) -> Vec3 {
        let ring = self.rings[k];
        let (sin, cos) = angle.sin_cos();
        // The lower side of the body is flatter than the upper side.
        let height = if sin < 0.0 { 0.82 } else { 1.0 };
        ring.centre + ring.left * (cos * ring.half.x) + ring.up * (sin * ring.half.y * height)
    }

    /// Builds the tube, which is closed at both ends. There are `AROUND` patches per ring. The list of patches runs along the body, and the
    /// patches of the ends come last.
    pub fn mesh(&self) -> PatchMesh {
        let mut mesh = PatchMesh::default();
        for k in 0..=ALONG as usize {
            for j in 0..AROUND {
                mesh.positions.push(self.point(k, TAU * j as f32 / AROUND as f32));
            }
        }
        let at = |k: u32, j: u32| k * AROUND + j % AROUND;
        for k in 0..ALONG {
            for j in 0..AROUND {
                mesh.patches.push([at(k, j), at(k, j + 1), at(k + 1, j + 1), at(k + 1, j)]);
            }
        }
        // Each end is a fan of quads around a point slightly beyond the ring.
        for (k, beyond) in [(0, -1.0f32), (ALONG, 0.3)] {
            let ring = self.rings[k as usize];
            let tip = mesh.positions.len() as u32;
            mesh.positions.push(ring.centre + ring.forward * (beyond * ring.half.min_element()));
            for j in (0..AROUND).step_by(2) {
                let (a, b, c) = (at(k, j), at(k, j + 1), at(k, j + 2));
                mesh.patches.push(if k == 0 { [tip, c, b, a] } else { [tip, a, b, c] });
            }
        }
        mesh.normals = vec![Vec3::ZERO; mesh.positions.len()];
        for patch in &mesh.patches {
            let p = patch.map(|v| mesh.positions[v as usize]);
            for i in 0..4 {
                let (next, previous) = (p[(i + 1) & 3] - p[i], p[(i + 3) & 3] - p[i]);
                // Weighting by angles limits the influence of slivers at the tip.
                let normal = next.cross(previous).normalize_or_zero();
                let angle = next.angle_between(previous);
                mesh.normals[patch[i] as usize] += normal * if angle.is_finite() { angle } else { 0.0 };
            }
        }
        mesh.normals.iter_mut().for_each(|n| *n = n.normalize());
        mesh.colors = vec![[1.0; 4]; mesh.positions.len()];
        mesh.accessibility = vec![1.0; mesh.positions.len()];
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_render::surfaces::topology::Topology;

    #[test]
    fn the_body_is_closed_and_faces_outwards() {
        let body = Body::new();
        let mesh = body.mesh();
        assert_eq!(Topology::new(&mesh.patches).irregular_edges(), 0);
        for (index, patch) in mesh.patches.iter().enumerate() {
            let p = patch.map(|v| mesh.positions[v as usize]);
            let flat = (p[2] - p[0]).cross(p[3] - p[1]).normalize();
            let normal: Vec3 = patch.iter().map(|&v| mesh.normals[v as usize]).sum();
            assert!(flat.dot(normal.normalize()) > 0.5, "patch {index}: {}", flat.dot(normal.normalize()));
        }
    }

    #[test]
    fn coil_windings_do_not_intersect() {
        let body = Body::new();
        assert!((body.length() - LENGTH).abs() < 0.03, "{}", body.length());
        for (i, a) in body.rings.iter().enumerate() {
            assert!(a.centre.z - a.half.y * 0.82 > -0.02, "ring {i} is below the ground");
            for (j, b) in body.rings.iter().enumerate().skip(i + 16) {
                let gap = a.centre.distance(b.centre) - a.half.max_element() - b.half.max_element();
                assert!(gap > -0.04, "rings {i} and {j} overlap by {}", -gap);
            }
        }
    }
}
