//! Measurements and pictures of the baked body for people and tests: a z-buffer of the atlas' own micro-quads.

use std::path::Path;
use std::time::Instant;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::Trex;
use crate::render::surfaces::patch::Patch;
use crate::render::surfaces::patch_mesh::PatchMesh;

struct Vertex {
    position: Vec3,
    normal: Vec3,
    color: [f32; 4],
    open: f32,
}

fn patch_of(mesh: &PatchMesh, i: usize) -> Patch {
    let q = mesh.patches[i];
    Patch::new(q.map(|v| mesh.positions[v as usize]), q.map(|v| mesh.normals[v as usize]))
}

fn bilinear(c: [f32; 4], uv: Vec2) -> f32 {
    let (a, b) = (c[0] + (c[1] - c[0]) * uv.x, c[3] + (c[2] - c[3]) * uv.x);
    a + (b - a) * uv.y
}

/// Filtered height at a patch parameter, as the renderer samples it.
fn height(trex: &Trex, patch: usize, uv: Vec2) -> f32 {
    let (x0, y0) = trex.layout.origin(patch as u32);
    let t = uv * trex.layout.inner() as f32 + trex.layout.gutter as f32 - 0.5;
    let (i, j) = (t.x.floor(), t.y.floor());
    let width = trex.layout.size().0 as usize;
    let at =
        |di: usize, dj: usize| trex.heights[(y0 as usize + j as usize + dj) * width + x0 as usize + i as usize + di];
    bilinear([at(0, 0), at(1, 0), at(1, 1), at(0, 1)], t - Vec2::new(i, j))
}

fn linear(c: u8) -> f32 {
    let y = f32::from(c) / 255.0;
    if y <= 0.04045 { y / 12.92 } else { ((y + 0.055) / 1.055).powf(2.4) }
}

/// A grid of `n + 1` by `n + 1` vertices of a body patch.
fn tessellate(trex: &Trex, patch: usize, n: usize) -> Vec<Vertex> {
    let surface = patch_of(&trex.body, patch);
    let (x0, y0) = trex.layout.origin(patch as u32);
    let width = trex.layout.size().0 as usize;
    let open = trex.body.patches[patch].map(|v| trex.body.accessibility[v as usize]);
    let side = n + 1;
    let mut out: Vec<Vertex> = (0..side * side)
        .map(|k| {
            let uv = Vec2::new((k % side) as f32, (k / side) as f32) / n as f32;
            let p = surface.at(uv);
            let t = (uv * trex.layout.inner() as f32 + trex.layout.gutter as f32).floor();
            let c = trex.colors[(y0 as usize + t.y as usize) * width + x0 as usize + t.x as usize];
            Vertex {
                position: p.position + p.normal * height(trex, patch, uv),
                normal: p.normal,
                color: [linear(c[0]), linear(c[1]), linear(c[2]), f32::from(c[3]) / 255.0],
                open: bilinear(open, uv),
            }
        })
        .collect();
    let normals: Vec<Vec3> = (0..side * side)
        .map(|k| {
            let (i, j) = (k % side, k / side);
            let at = |i: usize, j: usize| out[j * side + i].position;
            let du = at((i + 1).min(n), j) - at(i.saturating_sub(1), j);
            let dv = at(i, (j + 1).min(n)) - at(i, j.saturating_sub(1));
            du.cross(dv).normalize_or(out[k].normal)
        })
        .collect();
    for (v, n) in out.iter_mut().zip(normals) {
        v.normal = n;
    }
    out
}

/// Micro-faces at texel spacing: all, folded (against the patch normal), steep (below 0.5), and folded per patch.
fn folds(trex: &Trex) -> (usize, usize, usize, Vec<(usize, usize)>) {
    let n = trex.layout.inner() as usize;
    let per_patch: Vec<(usize, usize)> = (0..trex.body.patches.len())
        .into_par_iter()
        .map(|patch| {
            let surface = patch_of(&trex.body, patch);
            let at = |i: usize, j: usize| {
                let uv = Vec2::new(i as f32, j as f32) / n as f32;
                let p = surface.at(uv);
                p.position + p.normal * height(trex, patch, uv)
            };
            let (mut folded, mut steep) = (0, 0);
            for k in 0..n * n {
                let (i, j) = (k % n, k / n);
                let normal = surface.at((Vec2::new(i as f32, j as f32) + 0.5) / n as f32).normal;
                let face = (at(i + 1, j + 1) - at(i, j)).cross(at(i, j + 1) - at(i + 1, j));
                let dot = face.normalize_or_zero().dot(normal);
                folded += usize::from(dot < 0.0);
                steep += usize::from(dot < 0.5);
            }
            (folded, steep)
        })
        .collect();
    let worst = per_patch.iter().enumerate().filter(|(_, f)| f.0 > 0).map(|(i, f)| (i, f.0)).collect();
    let sum = |f: fn(&(usize, usize)) -> usize| per_patch.iter().map(f).sum();
    (n * n * per_patch.len(), sum(|f| f.0), sum(|f| f.1), worst)
}

/// Worst difference of filtered heights (metres) over edges seen from both sides.
fn worst_edge(trex: &Trex) -> f32 {
    let mut seen = std::collections::HashMap::new();
    let mut worst = 0.0_f32;
    for (patch, q) in trex.body.patches.iter().enumerate() {
        for side in 0..4 {
            let (a, b) = (q[side], q[(side + 1) % 4]);
            for k in 0..=20 {
                let s = k as f32 / 20.0;
                let uv = [Vec2::new(s, 0.0), Vec2::new(1.0, s), Vec2::new(1.0 - s, 1.0), Vec2::new(0.0, 1.0 - s)][side];
                let h = height(trex, patch, uv);
                let id = (a.min(b), a.max(b), if a < b { k } else { 20 - k });
                if let Some(other) = seen.insert(id, h) {
                    worst = worst.max((h - other).abs());
                }
            }
        }
    }
    worst
}

fn quick() -> Trex {
    Trex::load_from(None, 16, &|_| ()).unwrap()
}

#[test]
fn tiles_agree_on_their_edges_and_do_not_fold() {
    let start = Instant::now();
    let mut trex = quick();
    println!("baked tile 16 in {:?}: {} patches", start.elapsed(), trex.body.patches.len());
    let worst = worst_edge(&trex);
    let (all, folded, steep, _) = folds(&trex);
    let (low, high) = trex.heights.iter().fold((f32::MAX, f32::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    println!("edge mismatch {worst:e} m; {all} faces, {folded} folded, {steep} steep; heights {low} .. {high}");
    assert!(worst < 1e-5, "{worst}");
    assert!((folded as f32) < 2e-4 * all as f32, "{folded} of {all}");
    assert!(trex.heights.iter().all(|h| h.is_finite() && h.abs() < 0.4));
    // Both measures notice a fault.
    let broken = trex.layout.origin(100);
    let width = trex.layout.size().0;
    for y in 0..16 {
        for x in 0..8 {
            trex.heights[((broken.1 + y) * width + broken.0 + x) as usize] = -3.0 * x as f32;
        }
    }
    assert!(worst_edge(&trex) > 0.1);
}

#[test]
fn baking_twice_gives_the_same_animal_and_the_cache_returns_it() {
    let dir = tempfile::tempdir().unwrap();
    let first = Trex::load_from(Some(dir.path()), 8, &|_| ()).unwrap();
    let cached = Trex::load_from(Some(dir.path()), 8, &|_| ()).unwrap();
    let file = dir.path().join("trex-8.bin");
    std::fs::write(&file, b"not an animal").unwrap();
    let again = Trex::load_from(Some(dir.path()), 8, &|_| ()).unwrap();
    for other in [&cached, &again] {
        assert!(first.heights == other.heights && first.colors == other.colors);
        assert_eq!(first.body.positions, other.body.positions);
        assert_eq!(first.body.patches, other.body.patches);
    }
    assert!(std::fs::metadata(&file).unwrap().len() > 1000, "the damaged file was replaced");
    // A folder that cannot be made: a file stands in its place.
    assert!(Trex::load_from(Some(&file.join("below")), 8, &|_| ()).is_ok());
}

#[test]
fn odd_tile_sizes_are_refused() {
    for tile in [0, 4, 48, 256, 1 << 30] {
        assert!(matches!(Trex::load_from(None, tile, &|_| ()), Err(super::TrexError::Tile(_))));
    }
}

struct Canvas {
    size: [usize; 2],
    axes: [Vec3; 3],
    center: Vec3,
    scale: f32,
    depth: Vec<f32>,
    color: Vec<Vec3>,
}

impl Canvas {
    fn new(center: Vec3, width: f32, azimuth: f32, elevation: f32, size: [usize; 2]) -> Self {
        let (a, e) = (azimuth.to_radians(), elevation.to_radians());
        let towards = Vec3::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin());
        let right = Vec3::Z.cross(towards).normalize();
        let count = size[0] * size[1];
        Self {
            size,
            axes: [right, towards.cross(right), towards],
            center,
            scale: size[0] as f32 / width,
            depth: vec![f32::MIN; count],
            color: vec![Vec3::new(0.60, 0.66, 0.74); count],
        }
    }

    fn grid(&mut self, v: &[Vertex], n: usize) {
        let side = n + 1;
        for k in 0..n * n {
            let i = k / n * side + k % n;
            for t in [[i, i + 1, i + side + 1], [i, i + side + 1, i + side]] {
                self.triangle(t.map(|k| &v[k]));
            }
        }
    }

    fn triangle(&mut self, v: [&Vertex; 3]) {
        let [right, up, towards] = self.axes;
        let [w, h] = self.size;
        let s = v.map(|q| {
            let o = q.position - self.center;
            let (x, y) = (o.dot(right) * self.scale, o.dot(up) * self.scale);
            Vec3::new(w as f32 * 0.5 + x, h as f32 * 0.5 - y, o.dot(towards))
        });
        let cross = |a: Vec3, b: Vec3| a.truncate().perp_dot(b.truncate());
        let area = cross(s[1] - s[0], s[2] - s[0]);
        let (low, high) = (s[0].min(s[1]).min(s[2]), s[0].max(s[1]).max(s[2]));
        if high.x < 0.0 || high.y < 0.0 || low.x > w as f32 || low.y > h as f32 || area == 0.0 {
            return;
        }
        let key = (towards * 0.35 + up * 0.75 - right * 0.55).normalize();
        let half = (key + towards).normalize();
        for y in low.y.max(0.0) as usize..=(high.y.min(h as f32 - 1.0).max(0.0) as usize) {
            for x in low.x.max(0.0) as usize..=(high.x.min(w as f32 - 1.0).max(0.0) as usize) {
                let q = Vec3::new(x as f32 + 0.5, y as f32 + 0.5, 0.0);
                let b0 = cross(s[1] - q, s[2] - q) / area;
                let b1 = cross(s[2] - q, s[0] - q) / area;
                let b2 = 1.0 - b0 - b1;
                let z = b0 * s[0].z + b1 * s[1].z + b2 * s[2].z;
                let at = y * w + x;
                if b0 < 0.0 || b1 < 0.0 || b2 < 0.0 || z <= self.depth[at] {
                    continue;
                }
                self.depth[at] = z;
                if area > 0.0 {
                    self.color[at] = Vec3::new(1.0, 0.0, 0.6);
                    continue;
                }
                let b = [b0, b1, b2];
                let n = (0..3).map(|k| v[k].normal * b[k]).sum::<Vec3>().normalize_or(towards);
                let c: [f32; 4] = std::array::from_fn(|j| (0..3).map(|k| v[k].color[j] * b[k]).sum());
                let open: f32 = (0..3).map(|k| v[k].open * b[k]).sum();
                let sky = open * (0.5 + 0.5 * n.z);
                let light = Vec3::new(2.0, 1.87, 1.68) * n.dot(key).max(0.0) * (0.35 + 0.65 * open)
                    + Vec3::new(0.80, 0.90, 1.05) * sky
                    + Vec3::splat(0.2 * open);
                // Beckmann lobe at normal incidence, F0 = 0.04.
                let cos2 = n.dot(half).max(0.05).powi(2);
                let a2 = c[3] * c[3];
                let d = (-(1.0 - cos2) / (cos2 * a2)).exp() / (std::f32::consts::PI * a2 * cos2 * cos2);
                let spec = 0.04 * d * 0.25 * 2.0 * open * f32::from(u8::from(n.dot(key) > 0.0));
                self.color[at] = Vec3::new(c[0], c[1], c[2]) * light + Vec3::splat(spec.min(1.0));
            }
        }
    }

    fn save(&self, path: &str) {
        std::fs::create_dir_all("out").unwrap();
        let encode = |x: f32| (x.clamp(0.0, 1.0).powf(1.0 / 2.0) * 255.0) as u8;
        let bytes: Vec<u8> = self.color.iter().flat_map(|c| [encode(c.x), encode(c.y), encode(c.z)]).collect();
        let [w, h] = self.size.map(|s| s as u32);
        image::save_buffer(Path::new(path), &bytes, w, h, image::ColorType::Rgb8).unwrap();
    }
}

fn draw(trex: &Trex, canvas: &mut Canvas, n: usize) {
    for patch in 0..trex.body.patches.len() {
        canvas.grid(&tessellate(trex, patch, n), n);
    }
    let props = &trex.props;
    for patch in 0..props.patches.len() {
        let surface = patch_of(props, patch);
        let q = props.patches[patch];
        let m = 4;
        let grid: Vec<Vertex> = (0..(m + 1) * (m + 1))
            .map(|k| {
                let uv = Vec2::new((k % (m + 1)) as f32, (k / (m + 1)) as f32) / m as f32;
                let p = surface.at(uv);
                let color = std::array::from_fn(|j| bilinear(q.map(|v| props.colors[v as usize][j]), uv));
                let open = bilinear(q.map(|v| props.accessibility[v as usize]), uv);
                Vertex { position: p.position, normal: p.normal, color, open }
            })
            .collect();
        canvas.grid(&grid, m);
    }
}

/// `LEADR_TILE` sets the tile size (64).
#[test]
#[ignore = "pictures, for people"]
fn pictures() {
    let tile = std::env::var("LEADR_TILE").ok().and_then(|t| t.parse().ok()).unwrap_or(64);
    let start = Instant::now();
    let trex = Trex::load_from(Some(Path::new("out/cache")), tile, &|_| ()).unwrap();
    println!("tile {tile}: {:?}", start.elapsed());
    let (all, folded, steep, worst) = folds(&trex);
    println!("{all} faces, {folded} folded, {steep} steep; edge mismatch {:e}", worst_edge(&trex));
    for (patch, count) in worst.iter().take(25) {
        println!("  {count} folded at {}", trex.body.positions[trex.body.patches[*patch][0] as usize]);
    }
    let n = trex.layout.inner() as usize;
    let v = Vec3::new;
    let views = [
        ("side", v(-0.9, 0.0, 2.1), 12.2, 90.0, 3.0, [1600, 600], (n / 3).max(4)),
        ("front", v(1.0, 0.0, 2.15), 4.6, 35.0, 6.0, [900, 900], (n / 2).max(4)),
        ("head", v(4.05, 0.0, 3.65), 1.95, 90.0, 3.0, [1100, 800], n),
        ("head34", v(4.05, 0.0, 3.68), 1.9, 40.0, 10.0, [1100, 800], n),
        ("mouth", v(4.2, 0.0, 3.6), 1.5, 8.0, 14.0, [900, 900], n),
        ("eye", v(3.9, 0.3, 4.05), 0.8, 65.0, 8.0, [1000, 800], n),
        ("feet", v(0.35, 0.42, 0.25), 1.4, 45.0, 22.0, [1100, 700], n),
        ("trunk", v(1.0, 0.5, 2.6), 2.6, 80.0, 5.0, [1100, 900], n),
    ];
    let wanted = std::env::var("LEADR_VIEWS").unwrap_or_default();
    for (name, center, width, azimuth, elevation, size, n) in views {
        if wanted.is_empty() || wanted.split(',').any(|w| w == name) {
            let mut canvas = Canvas::new(center, width, azimuth, elevation, size);
            draw(&trex, &mut canvas, n);
            canvas.save(&format!("out/look_{name}.png"));
        }
    }
}
