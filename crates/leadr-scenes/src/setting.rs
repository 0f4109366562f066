//! Settings of scenes: concrete ground out to the horizon, a plinth for the sphere and a kerb for the plane. None of them is displaced, so
//! the flags for relief and roughness do not change them.

use std::f32::consts::{FRAC_PI_4, TAU};

use glam::{Vec2, Vec3};

use super::plane::{plane, toward_horizon};
use super::sphere::color_code;
use super::stage::{Stage, Views};
use leadr_maps::procedural;
use leadr_render::camera::Camera;
use leadr_render::scene::{MaterialMap, Object, Tiling};
use leadr_render::surfaces::patch_mesh::PatchMesh;

/// Half the side of the ground, metres.
const HALF: f32 = 4000.0;
/// Width of one repeat of the ground's map, metres.
const REPEAT: f32 = 5.0;
/// Texels along a side of the ground's map.
const TEXELS: u32 = 512;
/// Mean albedo of the ground.
const CONCRETE: [f32; 3] = [0.27, 0.26, 0.245];
/// Albedo and roughness of the plinth and the kerb.
const STONE: [f32; 4] = [0.50, 0.475, 0.43, 0.55];

/// Places the sphere on a low round plinth. The camera is beside the default sun, whose light grazes the relief.
pub fn around_sphere(stage: Stage) -> Stage {
    let top = [[0.05, -0.985], [0.60, -0.985], [0.632, -0.993], [0.645, -1.015]];
    let side = [[0.645, -1.015], [0.645, -1.25], [0.655, -1.275], [0.68, -1.285]];
    let foot = [[0.68, -1.285], [0.735, -1.285], [0.748, -1.298], [0.75, -1.31], [0.75, -1.36]];
    let plinth = revolved(&[&top, &side, &foot], &round(48));
    let from = |distance: f32, up: f32, target: Vec3| {
        Camera::looking_at(target + Vec3::new(-0.33, -0.93, up).normalize() * distance, target, 30.0)
    };
    let low = Vec3::new(0.0, 0.0, -0.12);
    let views = Views { near: from(2.2, 0.22, Vec3::ZERO), mid: from(5.4, 0.17, low), far: from(20.0, 0.17, low) };
    on_ground(stage.with_still(Object::new("plinth", plinth)).with_views(views), -1.35)
}

/// Places the plane as a bed within a kerb, seen low enough to show the horizon.
pub fn around_plane(stage: Stage) -> Stage {
    let inner = [[3.995, -0.3], [3.995, 0.09], [4.0, 0.108], [4.018, 0.115]];
    let top = [[4.018, 0.115], [4.28, 0.115], [4.298, 0.108], [4.305, 0.09], [4.305, -0.3]];
    let kerb = revolved(&[&inner, &top], &square());
    let from = |distance: f32, up: f32| {
        Camera::looking_at(Vec3::new(-0.36, -0.92, up).normalize() * distance, Vec3::ZERO, 35.0)
    };
    let views = Views { near: from(2.0, 0.42), mid: from(6.4, 0.25), far: from(34.0, 0.18) };
    on_ground(stage.with_still(Object::new("kerb", kerb)).with_views(views), -0.2)
}

/// Places the objects of a stage on the ground at this height, in metres.
pub fn on_ground(stage: Stage, height: f32) -> Stage {
    stage.with_still(ground(height)).with_albedo_below(CONCRETE)
}

/// Builds concrete ground at this height, in metres. It is tiled by example, so that no repeat shows toward the horizon.
fn ground(height: f32) -> Object {
    let mut mesh = plane(HALF, 48, REPEAT, [1.0; 4], toward_horizon);
    // Vertices are not always on texels, and the ground is not at height 0.
    mesh.flat_repeat = None;
    mesh.positions.iter_mut().for_each(|p| p.z = height);
    let noise = |seed, cells, octaves| procedural::fbm(TEXELS, TEXELS, seed, cells, octaves, 0.55).texels;
    let (stains, grain) = (noise(6, 4, 5), noise(5, 128, 3));
    let colors = stains.iter().zip(grain).map(|(stain, grain)| {
        let shade = 1.0 + 0.12 * (stain - 0.5) + 0.25 * (grain - 0.5);
        color_code(CONCRETE.map(|albedo| albedo * shade), 0.62 - 0.1 * (stain - 0.5))
    });
    Object::new("ground", mesh)
        .with_material(MaterialMap::new(TEXELS, TEXELS, colors.collect()))
        .with_tiling(Tiling::ByExample)
        .with_specular_f0(0.03)
        .without_shadow()
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

/// Sweeps an outline around the z axis. Each piece lists radii and heights, from the top outward and down. A piece is smooth, and there are
/// sharp edges between pieces.
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
}
