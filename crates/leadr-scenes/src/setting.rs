//! The setting of the plane and the sphere: a pavement of pale slabs out to the horizon, a plinth and a kerb, all undisplaced. Relief and
//! roughness flags affect only the plane or sphere, whose appearance does not depend on the setting.

use std::f32::consts::{FRAC_PI_4, TAU};

use glam::{Vec2, Vec3};

use super::plane::{plane, toward_horizon};
use super::sphere::color_code;
use super::stage::{Stage, Views};
use leadr_maps::noise::{hash, unit};
use leadr_maps::procedural;
use leadr_render::camera::Camera;
use leadr_render::scene::{MaterialMap, Object};
use leadr_render::surfaces::patch_mesh::PatchMesh;

/// Half the side of the pavement, metres.
const HALF: f32 = 4000.0;
/// Width of one repeat in metres, slab rows per repeat, and slabs per row.
const REPEAT: f32 = 8.0;
const ROWS: usize = 10;
const SLABS: usize = 6;
/// Texels along a side of the pavement map.
const TEXELS: usize = 1024;
/// Albedo and roughness of the plinth and the kerb.
const STONE: [f32; 4] = [0.50, 0.475, 0.43, 0.55];

/// Places the sphere on a low round plinth. The camera is beside the default sun, whose light grazes the relief.
pub fn around_sphere(mut stage: Stage) -> Stage {
    let top = [[0.05, -0.985], [0.60, -0.985], [0.632, -0.993], [0.645, -1.015]];
    let side = [[0.645, -1.015], [0.645, -1.25], [0.655, -1.275], [0.68, -1.285]];
    let foot = [[0.68, -1.285], [0.735, -1.285], [0.748, -1.298], [0.75, -1.31], [0.75, -1.36]];
    let plinth = revolved(&[&top, &side, &foot], &round(48));
    stage.objects.extend([Object::new("plinth", plinth), pavement(-1.35)]);
    let from = |distance: f32, up: f32, target: Vec3| {
        Camera::looking_at(target + Vec3::new(-0.33, -0.93, up).normalize() * distance, target, 30.0)
    };
    let low = Vec3::new(0.0, 0.0, -0.12);
    let views = Views { near: from(2.2, 0.22, Vec3::ZERO), mid: from(5.4, 0.17, low), far: from(36.0, 0.17, low) };
    Stage::still(stage.objects, views)
}

/// Places the plane as a bed within a kerb, seen low enough to show the horizon.
pub fn around_plane(mut stage: Stage) -> Stage {
    let inner = [[3.995, -0.3], [3.995, 0.09], [4.0, 0.108], [4.018, 0.115]];
    let top = [[4.018, 0.115], [4.28, 0.115], [4.298, 0.108], [4.305, 0.09], [4.305, -0.3]];
    let kerb = revolved(&[&inner, &top], &square());
    stage.objects.extend([Object::new("kerb", kerb), pavement(-0.2)]);
    let from = |distance: f32, up: f32| {
        Camera::looking_at(Vec3::new(-0.36, -0.92, up).normalize() * distance, Vec3::ZERO, 35.0)
    };
    Stage::still(stage.objects, Views { near: from(2.0, 0.42), mid: from(6.4, 0.29), far: from(60.0, 0.29) })
}

/// Builds a pavement at this height.
fn pavement(height: f32) -> Object {
    let mut mesh = plane(HALF, 48, REPEAT, [1.0; 4], toward_horizon);
    // Vertices are not always on texels, and the pavement is not at height 0.
    mesh.flat_repeat = None;
    mesh.positions.iter_mut().for_each(|p| p.z = height);
    let grain = procedural::fbm(TEXELS as u32, TEXELS as u32, 5, 128, 4, 0.6).texels;
    let stain = procedural::fbm(TEXELS as u32, TEXELS as u32, 6, 16, 4, 0.5).texels;
    let slab = |i: usize| {
        let at = Vec2::new((i % TEXELS) as f32 + 0.5, (i / TEXELS) as f32 + 0.5) / TEXELS as f32;
        let row = (at.y * ROWS as f32).floor();
        let along = (at.x + 0.0685 * row * row).fract() * SLABS as f32;
        let inside = Vec2::new(along.fract() / SLABS as f32, at.y - row / ROWS as f32) * REPEAT;
        let size = Vec2::new(REPEAT / SLABS as f32, REPEAT / ROWS as f32);
        let edge = inside.min(size - inside).min_element();
        // Random differences between slabs hide the repeats at a distance, while larger stains would reveal them.
        let own = unit(hash(6, along as i32, row as i32));
        let joint = 1.0 - 0.62 * (1.0 - edge / 0.012).clamp(0.0, 1.0);
        (0.275 + 0.045 * own + 0.10 * (grain[i] - 0.5) + 0.04 * (stain[i] - 0.5), joint)
    };
    let (mut shades, joints): (Vec<f32>, Vec<f32>) = (0..TEXELS * TEXELS).map(slab).unzip();
    without_stripes(&mut shades, TEXELS);
    let colors = shades.iter().zip(joints).map(|(shade, joint)| {
        let shade = shade * joint;
        color_code([shade * 1.02, shade * 0.985, shade * 0.925], 0.62)
    });
    Object::new("pavement", mesh)
        .with_material(MaterialMap::new(TEXELS as u32, TEXELS as u32, colors.collect()))
        .with_specular_f0(0.03)
        .without_shadow()
}

/// Line directions, in texels, along which the repeating map is free of stripes.
const EVEN: [[usize; 2]; 8] =
    [[1, 0], [0, 1], [1, 1], [1, TEXELS - 1], [1, 2], [1, TEXELS - 2], [2, 1], [TEXELS - 2, 1]];

/// Equalises the means of all texel lines along each of [`EVEN`] in a repeating square; `size` is a power of two. Otherwise stripes would
/// be visible as rays toward the horizon, where pixel footprints are long.
fn without_stripes(texels: &mut [f32], size: usize) {
    let all = texels.iter().map(|&texel| f64::from(texel)).sum::<f64>() / texels.len() as f64;
    let mut sums = vec![0.0f64; size];
    for [along, up] in EVEN {
        // Line number of a texel.
        let line = |i: usize| (up * i).wrapping_sub(along * (i / size)) & (size - 1);
        sums.fill(-all * size as f64);
        texels.iter().enumerate().for_each(|(i, &texel)| sums[line(i)] += f64::from(texel));
        texels.iter_mut().enumerate().for_each(|(i, texel)| *texel -= (sums[line(i)] / size as f64) as f32);
    }
}

/// A sector around an axis: directions of its two ends, scaled by the outline's width, and their normals.
type Sector = [(Vec2, Vec2); 2];

fn round(sectors: u32) -> Vec<Sector> {
    let direction = |k: u32| Vec2::from_angle(k as f32 * TAU / sectors as f32);
    (0..sectors).map(|k| [k, k + 1].map(|k| (direction(k), direction(k)))).collect()
}

fn square() -> Vec<Sector> {
    let corner = |k: u32| Vec2::from_angle((2 * k + 1) as f32 * FRAC_PI_4) * std::f32::consts::SQRT_2;
    let normal = |k: u32| Vec2::from_angle((k + 1) as f32 * 2.0 * FRAC_PI_4);
    (0..4).map(|k| [k, k + 1].map(|end| (corner(end), normal(k)))).collect()
}

/// Sweeps an outline around the z axis. The pieces list radii and heights, outward and down over the top. Edges are between pieces, and
/// each piece is smooth.
fn revolved(pieces: &[&[[f32; 2]]], sectors: &[Sector]) -> PatchMesh {
    let mut mesh = PatchMesh::default();
    for piece in pieces {
        let points: Vec<Vec2> = piece.iter().map(|&p| Vec2::from(p)).collect();
        let rows = points.len() as u32;
        for sector in sectors {
            let first = mesh.positions.len() as u32;
            for (direction, side) in sector {
                for (i, p) in points.iter().enumerate() {
                    let along = points[(i + 1).min(points.len() - 1)] - points[i.saturating_sub(1)];
                    let [out, up] = [-along.y, along.x];
                    mesh.positions.push((*direction * p.x).extend(p.y));
                    mesh.normals.push((*side * out).extend(up).normalize());
                }
            }
            for i in 0..rows - 1 {
                let a = first + i;
                mesh.patches.push([a, a + 1, a + rows + 1, a + rows]);
                mesh.texcoords.push([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
            }
        }
    }
    mesh.colors = vec![STONE; mesh.positions.len()];
    mesh.accessibility = vec![1.0; mesh.positions.len()];
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::{ReliefOptions, plane_stage, sphere_stage};

    #[test]
    fn the_surface_is_the_bare_one() {
        let relief = || ReliefOptions { tile: 8, ..ReliefOptions::default() };
        for (bare, set) in [
            (sphere_stage(relief()), around_sphere(sphere_stage(relief()))),
            (plane_stage(relief()), around_plane(plane_stage(relief()))),
        ] {
            let [a, b] = [&bare.objects[0], &set.objects[0]];
            assert_eq!((&a.mesh.positions, a.height_scale), (&b.mesh.positions, b.height_scale));
            assert_eq!(a.heights.as_ref().unwrap().map.texels, b.heights.as_ref().unwrap().map.texels);
            assert!(set.objects[1..].iter().all(|object| object.heights.is_none()));
        }
    }

    #[test]
    fn stones_face_outwards_and_hide_the_edge_of_the_surface() {
        let sphere = around_sphere(sphere_stage(ReliefOptions { tile: 8, ..ReliefOptions::default() }));
        let plane = around_plane(plane_stage(ReliefOptions::default()));
        for object in [&sphere.objects[1], &plane.objects[1]] {
            for patch in &object.mesh.patches {
                let p = patch.map(|v| object.mesh.positions[v as usize]);
                let normal: Vec3 = patch.iter().map(|&v| object.mesh.normals[v as usize]).sum();
                assert!(
                    (p[1] - p[0]).cross(p[3] - p[0]).normalize().dot(normal.normalize()) > 0.7,
                    "{}: {p:?}",
                    object.name
                );
            }
        }
        let reach = plane.objects[1].mesh.positions.iter().map(|p| p.x.abs().max(p.y.abs()));
        let inner = reach.fold(f32::MAX, f32::min);
        assert!(inner < 4.0 && inner > 3.9, "{inner}");
    }

    #[test]
    fn no_stripe_is_left_and_the_mean_stays() {
        let size = 64;
        let before = procedural::fbm(size as u32, size as u32, 5, 8, 4, 0.6).texels;
        let mut after = before.clone();
        without_stripes(&mut after, size);
        let mean = |texels: &[f32]| texels.iter().sum::<f32>() / texels.len() as f32;
        let all = mean(&before);
        assert!((mean(&after) - all).abs() < 1e-5);
        let widest = |texels: &[f32], [along, up]: [usize; 2]| {
            let line = |k: usize| {
                (0..size).map(|i| texels[(i * up + k * along) % size * size + (i * along + k * up) % size]).sum::<f32>()
                    / size as f32
            };
            (0..size).map(|k| (line(k) - all).abs()).fold(0.0, f32::max)
        };
        for direction in [[1, 0], [0, 1]] {
            assert!(widest(&before, direction) > 0.02 && widest(&after, direction) < 1e-4, "{direction:?}");
        }
        let diagonal = |texels: &[f32]| (0..size).map(|i| texels[i * size + i]).sum::<f32>() / size as f32;
        assert!((diagonal(&after) - all).abs() < 1e-4 && (diagonal(&before) - all).abs() > 1e-3);
    }
}
