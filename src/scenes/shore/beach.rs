//! The sand as meshes: a strip along the water that holds the map across the beach, and the dunes behind it.

use glam::{DVec2, Vec2, Vec3};

use super::sand::{DRY_REPEAT, STRIP, STRIP_REPEAT, Sand, dry, strip};
use crate::render::scene::{MaterialMap, Object, Tiling};
use crate::render::surfaces::displacement::{Border, HeightField};
use crate::render::surfaces::ocean::shore::Shore;
use crate::render::surfaces::patch_mesh::PatchMesh;

/// How far the land reaches, metres: beyond the horizon.
const FAR: f64 = 20e3;
/// Radius of the earth with the usual refraction of the air, metres, as the sea's.
const EARTH: f64 = 6.371e6 * 7.0 / 6.0;

/// By how much beach and dunes sink under each other where they meet, metres: more than their bumps, over five metres, so that no crease
/// shows.
const SINK: f64 = 0.15;

/// Metres along the coast after which the dunes repeat: a multiple of the bends', and of the dry sand's.
pub const DUNES_PERIOD: f64 = 200.0;

/// Waves that the dunes are made of, 29 to 59 m long in all directions, none a multiple of another: height in metres, crests along a
/// period, phase by metre from the waterline, and phase.
const HILLS: [(f64, f64, f64, f64); 7] = [
    (0.30, 3.0, 0.05, 0.0),
    (0.24, 2.0, -0.11, 2.1),
    (0.20, 5.0, 0.10, 1.0),
    (0.18, 1.0, 0.16, 4.0),
    (0.16, 4.0, -0.17, 5.2),
    (0.14, 6.0, -0.05, 0.7),
    (0.14, 2.0, 0.21, 3.0),
];

/// The strip from the dry sand into the water.
#[must_use]
pub fn beach(shore: &Shore) -> Object {
    let columns = spaced(f64::from(STRIP[0]), f64::from(STRIP[1]), 40);
    let rows = mirrored(&[(30.0, 1.0), (120.0, 2.5)]);
    // Its inland rim sinks under the dunes.
    let height = |s: f64, _: f64| shore.ground(s) - SINK * smooth(-23.0, -28.0, s);
    let across = |s: f64| (s as f32 - STRIP[0]) / (STRIP[1] - STRIP[0]);
    object("beach", mesh(shore, &columns, &rows, height, |s, y| Vec2::new(across(s), y as f32 / STRIP_REPEAT)), strip())
}

/// The dunes and the land behind the beach.
#[must_use]
pub fn dunes(shore: &Shore) -> Object {
    let mut columns = mirrored(&[(34.0, 2.0), (134.0, 5.0), (500.0, 10.0)]);
    columns.truncate(columns.len() / 2 + 1);
    columns.iter_mut().for_each(|s| *s -= 22.0);
    let rows = mirrored(&[(240.0, 4.0), (560.0, 10.0)]);
    let height = |s: f64, y: f64| {
        let turn = std::f64::consts::TAU / DUNES_PERIOD;
        let hills: f64 = HILLS.iter().map(|&(height, k, by_s, at)| height * (k * turn * y + by_s * s + at).sin()).sum();
        // They end before columns and rows are too far apart for them, slowly, so that nothing jumps when the dunes follow the animal.
        let there = smooth(-32.0, -60.0, s) * smooth(-500.0, -250.0, s) * smooth(760.0, 360.0, y.abs());
        shore.ground(s) + there * (0.9 + hills) + 1.2 * smooth(-40.0, -200.0, s) - SINK * smooth(-28.0, -23.0, s)
    };
    let dunes =
        object("dunes", mesh(shore, &columns, &rows, height, |s, y| Vec2::new(s as f32, y as f32) / DRY_REPEAT), dry());
    dunes.with_tiling(Tiling::ByExampleInWorld)
}

fn smooth(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// `count + 1` even steps.
fn spaced(from: f64, to: f64, count: u32) -> Vec<f64> {
    (0..=count).map(|i| from + (to - from) * f64::from(i) / f64::from(count)).collect()
}

/// Places from −[`FAR`] to [`FAR`], symmetric: even steps up to each `(reach, step)`, then increasingly longer ones.
fn mirrored(even: &[(f64, f64)]) -> Vec<f64> {
    let (mut half, mut step) = (vec![0.0], 1.0);
    for &(reach, length) in even {
        step = length;
        while half[half.len() - 1] + step <= reach {
            half.push(half[half.len() - 1] + step);
        }
    }
    while half[half.len() - 1] < FAR {
        step *= 1.22;
        half.push(half[half.len() - 1] + step);
    }
    half.iter().skip(1).rev().map(|y| -y).chain(half.iter().copied()).collect()
}

/// Patches over the product of `columns` (metres from the waterline) and `rows` (metres along it, toward −y).
fn mesh(
    shore: &Shore,
    columns: &[f64],
    rows: &[f64],
    height: impl Fn(f64, f64) -> f64,
    texcoord: impl Fn(f64, f64) -> Vec2,
) -> PatchMesh {
    let drop = |p: DVec2| p.length_squared() / (2.0 * EARTH);
    let place = |s: f64, y: f64| {
        let p = -DVec2::new(s + shore.waterline(y), y);
        p.extend(height(s, y) - drop(p)).as_vec3()
    };
    let mut mesh = PatchMesh::default();
    for &y in rows {
        for &s in columns {
            let e = 0.02;
            let along = place(s, y + e) - place(s, y - e);
            let across = place(s + e, y) - place(s - e, y);
            mesh.positions.push(place(s, y));
            mesh.normals.push(across.cross(along).normalize_or(Vec3::Z));
        }
    }
    mesh.colors = vec![[1.0; 4]; mesh.positions.len()];
    mesh.accessibility = vec![1.0; mesh.positions.len()];
    let width = columns.len() as u32;
    for j in 0..rows.len() - 1 {
        for i in 0..columns.len() - 1 {
            let v = j as u32 * width + i as u32;
            mesh.patches.push([v, v + 1, v + width + 1, v + width]);
            let at = |i: usize, j: usize| texcoord(columns[i], rows[j]);
            mesh.texcoords.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh
}

fn object(name: &str, mesh: PatchMesh, sand: Sand) -> Object {
    let Sand { width, height, heights, colors } = sand;
    Object::new(name, mesh)
        .with_heights(HeightField { width, height, texels: heights, border: Border::Wrap }, 1.0)
        .with_material(MaterialMap::new(width, height, colors))
        .with_specular_f0(0.025)
        .without_shadow()
}
