//! The meshes of the sand from land to water: the dunes, the strip along the water, and the wet sand.

use glam::{DVec2, Vec2, Vec3};

use super::sand::{JOINS, OVERLAPS, PERIOD, SQUARE, STRIP, Sand, dry, strip, wet};
use crate::plane::grid;
use leadr_maps::HeightMap;
use leadr_render::scene::{MaterialMap, Object, Tiling};
use leadr_render::surfaces::displacement::HeightField;
use leadr_render::surfaces::ocean::shore::Shore;
use leadr_render::surfaces::patch_mesh::PatchMesh;

/// The extent of the land in metres, which reaches beyond the horizon.
const FAR: f64 = 20e3;
/// The radius of the Earth with standard atmospheric refraction, in metres. The sea uses the same radius.
const EARTH: f64 = 6.371e6 * 7.0 / 6.0;

/// The depth in metres by which a piece of sand sinks below its neighbour past the join between them. This depth is larger than the bumps.
/// At the join, it is 0, which avoids a crease.
const SINKS: [f64; 2] = [0.15, 0.04];

/// The waves of the dunes. The waves are 29 to 59 m long, run in all directions, and have no common multiple. Each has a height in metres,
/// a number of crests per period, a phase per metre from the waterline, and a phase.
const HILLS: [(f64, f64, f64, f64); 7] = [
    (0.30, 3.0, 0.05, 0.0),
    (0.24, 2.0, -0.11, 2.1),
    (0.20, 5.0, 0.10, 1.0),
    (0.18, 1.0, 0.16, 4.0),
    (0.16, 4.0, -0.17, 5.2),
    (0.14, 6.0, -0.05, 0.7),
    (0.14, 2.0, 0.21, 3.0),
];

/// Builds all sand meshes, from land to water.
pub fn sand(shore: &Shore) -> [Object; 3] {
    let (dunes, (beach, bed)) = rayon::join(|| dunes(shore), || rayon::join(|| beach(shore), || bed(shore)));
    [dunes, beach, bed]
}

/// Returns the depth at `s` by which one side of a join has sunk. The land side is −1, and the sea side is 1.
fn sunk(join: usize, side: f64, s: f64) -> f64 {
    SINKS[join] * smooth(0.0, OVERLAPS[join], (JOINS[join] - s) * side)
}

/// Builds the strip along the water, which has a dry and a wet side.
fn beach(shore: &Shore) -> Object {
    let [dry, wet] = JOINS;
    let columns = spaced(&[(STRIP[0], 2), (dry, 5), (wet, 2)], STRIP[1]);
    let height = |s: f64, _: f64| shore.ground(s) - sunk(0, 1.0, s) - sunk(1, -1.0, s);
    let whole = |s: f64, y: f64| DVec2::new((s - STRIP[0]) / (STRIP[1] - STRIP[0]), y / PERIOD).as_vec2();
    let mesh = mesh(shore, &columns, &coast(), height, whole);
    object("beach", mesh, strip()).with_tiling(Tiling::OneVariant)
}

/// Builds the wet sand and the part of the sea floor that is visible.
fn bed(shore: &Shore) -> Object {
    let columns = spaced(&[(JOINS[1] - OVERLAPS[1], 2), (JOINS[1], 14)], 12.0);
    let height = |s: f64, _: f64| shore.ground(s) - sunk(1, 1.0, s);
    object("bed", mesh(shore, &columns, &coast(), height, square), wet()).with_tiling(Tiling::ByExampleInWorld)
}

/// Builds the dunes and the land behind the beach.
fn dunes(shore: &Shore) -> Object {
    let mut columns = mirrored(&[(16.0, 1.0), (52.0, 2.0), (152.0, 5.0), (520.0, 10.0)]);
    columns.truncate(columns.len() / 2);
    columns.iter_mut().for_each(|s| *s += JOINS[0]);
    columns.extend(spaced(&[(JOINS[0], 2)], JOINS[0] + OVERLAPS[0]));
    let rows = mirrored(&[(240.0, 3.0), (560.0, 10.0)]);
    let height = |s: f64, y: f64| {
        // The dunes fade out before columns and rows get too coarse for them. The fade is gradual, so that nothing jumps when the mesh
        // follows the animal.
        let there = smooth(-32.0, -60.0, s) * smooth(-500.0, -250.0, s) * smooth(760.0, 360.0, y.abs());
        let hills = if there > 0.0 { there * (0.9 + hills(s, y)) } else { 0.0 };
        shore.ground(s) + hills + 1.2 * smooth(-40.0, -200.0, s) - sunk(0, -1.0, s)
    };
    object("dunes", mesh(shore, &columns, &rows, height, square), dry()).with_tiling(Tiling::ByExampleInWorld)
}

fn hills(s: f64, y: f64) -> f64 {
    let turn = std::f64::consts::TAU / PERIOD;
    HILLS.iter().map(|&(height, crests, by_s, phase)| height * (crests * turn * y + by_s * s + phase).sin()).sum()
}

/// Returns the texture coordinates of a point in the repeating squares of sand.
fn square(s: f64, y: f64) -> Vec2 {
    Vec2::new(s as f32, y as f32) / SQUARE
}

/// Returns rows along the water. The rows are dense enough for the bends of the waterline at any position of the animal.
fn coast() -> Vec<f64> {
    mirrored(&[(130.0, 1.0), (250.0, 2.5), (500.0, 5.0)])
}

fn smooth(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Returns positions up to `end`. Each pair of `parts` has a start, and a number of even steps.
fn spaced(parts: &[(f64, u32)], end: f64) -> Vec<f64> {
    let ends = parts.iter().skip(1).map(|&(next, _)| next).chain([end]);
    let steps = parts
        .iter()
        .zip(ends)
        .flat_map(|(&(from, count), to)| (0..count).map(move |i| from + (to - from) * f64::from(i) / f64::from(count)));
    steps.chain([end]).collect()
}

/// Returns positions from −[`FAR`] to [`FAR`], symmetric about 0. Each `(reach, step)` gives even steps up to `reach`, and then the steps
/// grow.
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

/// Builds patches from `columns` (metres from the waterline) and `rows` (metres along the waterline, toward −y).
fn mesh(
    shore: &Shore,
    columns: &[f64],
    rows: &[f64],
    height: impl Fn(f64, f64) -> f64,
    texcoord: impl Fn(f64, f64) -> Vec2,
) -> PatchMesh {
    let drop = |p: DVec2| p.length_squared() / (2.0 * EARTH);
    let point = |s: f64, (y, waterline): (f64, f64)| {
        let p = -DVec2::new(s + waterline, y);
        p.extend(height(s, y) - drop(p)).as_vec3()
    };
    let mut mesh = PatchMesh::default();
    let e = 0.02;
    for &y in rows {
        let [before, here, after] = [y - e, y, y + e].map(|y| (y, shore.waterline(y)));
        for &s in columns {
            let along = point(s, after) - point(s, before);
            let across = point(s + e, here) - point(s - e, here);
            mesh.positions.push(point(s, here));
            mesh.normals.push(across.cross(along).normalize_or(Vec3::Z));
        }
    }
    mesh.colors = vec![[1.0; 4]; mesh.positions.len()];
    mesh.accessibility = vec![1.0; mesh.positions.len()];
    mesh.patches = grid(columns.len() as u32 - 1, rows.len() as u32 - 1);
    let texcoord = |v: u32| texcoord(columns[v as usize % columns.len()], rows[v as usize / columns.len()]);
    mesh.texcoords = mesh.patches.iter().map(|patch| patch.map(texcoord)).collect();
    mesh
}

fn object(name: &str, mesh: PatchMesh, sand: Sand) -> Object {
    let Sand { width, height, heights, colors } = sand;
    Object::new(name, mesh)
        .with_heights(HeightField::repeating(HeightMap { width, height, texels: heights }), 1.0)
        .with_material(MaterialMap::new(width, height, colors))
        .with_specular_f0(0.025)
        .without_shadow()
}
