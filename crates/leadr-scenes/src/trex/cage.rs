//! The control mesh: one closed surface of quads around the coarse distance field.
//!
//! The mesh is extracted by dual marching cubes on a warped grid, which has small cells for detail, and then relaxed onto the field. A test
//! checks that it is a topological ball.

use glam::Vec3;
use rayon::prelude::*;

use super::dual::{SampledGrid, extract};
use super::relax::{neighbors, relax, unfold, vertex_normals};
use super::sdf::TrexSdf;
use super::weights::skin_weights;
use leadr_render::surfaces::patch_mesh::PatchMesh;

/// The spacing of the grid in metres.
const SPACING: f32 = 0.11;

/// The low and the high corner of the grid before it is warped, in metres. `y` is symmetric about half a cell.
const GRID_LOW: Vec3 = Vec3::new(-8.4, -1.5, -1.1);
const GRID_HIGH: Vec3 = Vec3::new(7.0, 1.5, 5.9);

/// The warps that shrink cells. Each has a centre, a radius, and the reduction at the centre (0.6 leaves 0.4 of the spacing).
const WARPS: [([f32; 3], f32, f32); 9] = [
    ([4.15, 0.0, 3.80], 1.75, 0.56),
    ([0.0, 0.48, 0.75], 0.80, 0.30),
    ([0.0, -0.48, 0.75], 0.80, 0.30),
    ([4.30, 0.0, 3.20], 1.00, 0.26),
    ([0.62, 0.45, 0.10], 1.15, 0.77),
    ([0.62, -0.45, 0.10], 1.15, 0.77),
    ([2.15, 0.57, 1.95], 0.55, 0.60),
    ([2.15, -0.57, 1.95], 0.55, 0.60),
    ([-6.6, 0.0, 2.70], 1.7, 0.72),
];

/// Builds the cage with positions, normals, accessibility, skin weights and patches. Colours and texture coordinates remain empty.
pub fn build(sdf: &TrexSdf) -> PatchMesh {
    let mut surface = extract(&sample(sdf));
    let ring = neighbors(&surface);
    relax(&mut surface, &ring, sdf);
    unfold(&mut surface, &ring);
    let normals = vertex_normals(&surface, &ring);
    let accessibility = accessibility(sdf, &surface.positions, &normals);
    let skin = skin_weights(sdf, &surface.positions, &ring);
    PatchMesh {
        skin,
        positions: surface.positions,
        normals,
        accessibility,
        patches: surface.quads,
        ..PatchMesh::default()
    }
}

/// Moves a grid point towards the centres of detail.
fn warp(u: Vec3) -> Vec3 {
    let mut p = u;
    for (center, radius, strength) in WARPS {
        let d = u - Vec3::from(center);
        let w = (1.0 - d.length_squared() / (radius * radius)).max(0.0);
        p -= d * (strength * w * w);
    }
    p
}

fn sample(sdf: &TrexSdf) -> SampledGrid {
    let half = (GRID_HIGH.y / SPACING).ceil();
    let low = Vec3::new(GRID_LOW.x, (0.5 - half) * SPACING, GRID_LOW.z);
    let extent = (GRID_HIGH - GRID_LOW) / SPACING;
    let size = [extent.x.ceil() as usize, 2 * half as usize, extent.z.ceil() as usize];
    let [_, ny, nz] = size;
    let points: Vec<Vec3> = (0..size[0] * ny * nz)
        .map(|i| {
            let node = Vec3::new((i / (ny * nz)) as f32, (i / nz % ny) as f32, (i % nz) as f32);
            warp(low + node * SPACING)
        })
        .collect();
    // The field is not evaluated at points far outside the animal.
    let outside = |p: Vec3| p.x < -7.0 || p.x > 5.2 || p.y.abs() > 1.2 || p.z < -0.3 || p.z > 4.7;
    let values =
        points.par_iter().with_min_len(1024).map(|&p| if outside(p) { 1.0 } else { sdf.coarse.distance(p) }).collect();
    SampledGrid { size, points, values }
}

/// The number of cones over the hemisphere that sample the accessibility.
const CONES: usize = 36;

/// Returns, for each point, the cosine-weighted fraction of the hemisphere that the animal does not occlude, in `[0, 1]`. Cones are marched
/// through the full field for up to a metre. The ground does not occlude.
fn accessibility(sdf: &TrexSdf, positions: &[Vec3], normals: &[Vec3]) -> Vec<f32> {
    let cosine_directions: Vec<Vec3> = (0..CONES)
        .map(|i| {
            // A golden-angle spiral over the disk is projected up onto the hemisphere (Malley's method).
            let r2 = (i as f32 + 0.5) / CONES as f32;
            let phi = i as f32 * 2.399_963;
            Vec3::new(r2.sqrt() * phi.cos(), r2.sqrt() * phi.sin(), (1.0 - r2).sqrt())
        })
        .collect();
    let open = |p: Vec3, n: Vec3| {
        let (mut start, mut n) = (p, n);
        for _ in 0..3 {
            let gradient = sdf.full.gradient(start, 2e-3);
            start -= gradient.normalize_or_zero() * sdf.full.distance(start).clamp(-0.05, 0.05);
            n = (n + gradient).normalize_or(n);
        }
        let (t, b) = n.any_orthonormal_pair();
        let sum: f32 = cosine_directions
            .iter()
            .map(|d| {
                let direction = t * d.x + b * d.y + n * d.z;
                let (mut distance, mut visible) = (0.025_f32, 1.0_f32);
                while distance < 1.0 && visible > 0.0 {
                    let clearance = sdf.full.distance(start + direction * distance + n * 0.004);
                    // If the surface touches the axis of a cone of half-angle 0.2, the cone is half closed.
                    visible = visible.min((0.5 + clearance / (0.4 * distance)).clamp(0.0, 1.0));
                    distance += (0.5 * distance).max(clearance * 0.7);
                }
                visible
            })
            .sum();
        sum / CONES as f32
    };
    positions.par_iter().zip(normals).with_min_len(32).map(|(&p, &n)| open(p, n)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trex::dual::QuadSurface;
    use crate::trex::dual::tests::{BALL, shape};
    use glam::Vec2;
    use leadr_render::surfaces::patch::Patch;
    use std::time::Instant;

    fn percentiles(mut values: Vec<f32>) -> [f32; 4] {
        values.sort_by(f32::total_cmp);
        [0.5, 0.95, 0.99, 1.0].map(|q| values[((values.len() - 1) as f32 * q) as usize])
    }

    #[test]
    fn cage_is_a_ball_of_good_quads_near_the_surface() {
        let start = Instant::now();
        let sdf = TrexSdf::new();
        let fields = start.elapsed();
        let mesh = build(&sdf);
        println!(
            "{} vertices, {} quads; field {fields:?}, field and cage {:?}",
            mesh.positions.len(),
            mesh.patches.len(),
            start.elapsed()
        );
        let surface = QuadSurface { positions: mesh.positions.clone(), quads: mesh.patches.clone() };
        assert_eq!(shape(&surface), BALL);
        let mut valence = [0; 9];
        neighbors(&surface).iter().for_each(|r| valence[r.len().min(8)] += 1);
        let shapes: Vec<_> = mesh.patches.iter().map(|q| quad_shape(q.map(|i| mesh.positions[i as usize]))).collect();
        let of = |f: fn(&QuadShape) -> f32| percentiles(shapes.iter().map(f).collect());
        println!("valence {valence:?}\naspect {:.2?} off plane {:.3?}", of(|s| s.aspect), of(|s| s.off_plane));
        let angles = of(|s| -s.min_angle).map(|a| -a);
        println!(
            "min angle {angles:.1?} edge {:.3?} area {:.2}",
            of(|s| s.edge),
            shapes.iter().map(|s| s.area).sum::<f32>()
        );
        let (mut off, mut slope, mut folds, mut samples, mut bad) = (Vec::new(), Vec::new(), 0, 0, Vec::new());
        for q in &mesh.patches {
            let patch = Patch::new(q.map(|i| mesh.positions[i as usize]), q.map(|i| mesh.normals[i as usize]));
            let (mut worst, mut here) = (0.0_f32, 0);
            for i in 0..25 {
                let point = patch.at(Vec2::new((i % 5) as f32, (i / 5) as f32) / 4.0);
                let d = sdf.coarse.distance(point.position);
                off.push(d.abs());
                worst = worst.max(d.abs());
                slope.push(-sdf.coarse.gradient(point.position, 2e-3).normalize_or(Vec3::Z).dot(point.normal));
                samples += 1;
                here += usize::from(point.du.cross(point.dv).dot(point.normal) <= 0.0);
            }
            if here > 0 {
                println!("   {here} folds at {:.2}", patch.at(Vec2::splat(0.5)).position);
            }
            folds += here;
            if worst > 0.025 {
                bad.push(q.map(|i| mesh.positions[i as usize]).iter().sum::<Vec3>() / 4.0);
            }
        }
        println!(
            "patch to field {:.4?} m, normal cosine {:.3?}, folded {folds} of {samples}",
            percentiles(off.clone()),
            percentiles(slope).map(|c| -c)
        );
        println!("{} patches off by more than 25 mm", bad.len());
        for b in bad.iter().take(20) {
            println!("   {b:.2}");
        }
        let a = percentiles(mesh.accessibility.clone());
        println!("accessibility {a:.2?}, least {:.2}", mesh.accessibility.iter().copied().fold(1.0, f32::min));
        assert!(of(|s| s.aspect)[1] < 1.7 && angles[1] > 45.0);
        assert!(percentiles(off)[2] < 0.03 && folds * 1000 < samples);
        assert!(mesh.normals.iter().all(|n| n.is_normalized()));
        assert!(mesh.accessibility.iter().all(|a| (0.0..=1.0).contains(a)));
    }

    #[test]
    fn the_same_cage_every_time() {
        let sdf = TrexSdf::new();
        let (a, b) = (build(&sdf), build(&sdf));
        assert!(a.positions == b.positions && a.normals == b.normals && a.patches == b.patches);
        assert!(a.skin == b.skin && a.accessibility == b.accessibility);
    }

    /// Measures of a quad's shape.
    #[derive(Clone, Copy, Debug)]
    struct QuadShape {
        /// The ratio of the longer midline to the shorter midline.
        aspect: f32,
        /// The smallest inner angle in degrees.
        min_angle: f32,
        /// The ratio of the corners' distance from the mean plane to the mean length of the edges.
        off_plane: f32,
        /// The mean length of the edges in metres.
        edge: f32,
        /// The area in square metres.
        area: f32,
    }

    /// Measures the shape of one quad.
    fn quad_shape(p: [Vec3; 4]) -> QuadShape {
        let midline = |a: usize, b: usize, c: usize, d: usize| ((p[a] + p[b] - p[c] - p[d]) * 0.5).length();
        let (m0, m1) = (midline(0, 1, 2, 3), midline(1, 2, 3, 0));
        let edge = (0..4).map(|k| (p[(k + 1) % 4] - p[k]).length()).sum::<f32>() / 4.0;
        let normal = (p[2] - p[0]).cross(p[3] - p[1]);
        let center = (p[0] + p[1] + p[2] + p[3]) * 0.25;
        let min_angle = (0..4)
            .map(|k| (p[(k + 1) % 4] - p[k]).angle_between(p[(k + 3) % 4] - p[k]).to_degrees())
            .fold(f32::MAX, f32::min);
        QuadShape {
            aspect: m0.max(m1) / m0.min(m1).max(1e-6),
            min_angle,
            off_plane: (p[0] - center).dot(normal.normalize_or_zero()).abs() / edge,
            edge,
            area: normal.length() * 0.5,
        }
    }
}
