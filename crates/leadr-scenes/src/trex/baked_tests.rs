//! Tests that the tiles of the baked body meet, do not fold, and are deterministic.

use std::time::Instant;

use glam::Vec2;
use rayon::prelude::*;

use super::Trex;
use super::stage::unbaked_body;
use leadr_maps::cache::MapCache;
use leadr_render::surfaces::patch::Patch;
use leadr_render::surfaces::patch_mesh::PatchMesh;

fn patch_of(mesh: &PatchMesh, i: usize) -> Patch {
    let q = mesh.patches[i];
    Patch::new(q.map(|v| mesh.positions[v as usize]), q.map(|v| mesh.normals[v as usize]))
}

fn bilinear(c: [f32; 4], uv: Vec2) -> f32 {
    let (a, b) = (c[0] + (c[1] - c[0]) * uv.x, c[3] + (c[2] - c[3]) * uv.x);
    a + (b - a) * uv.y
}

/// Returns the filtered height at a parameter of a patch, sampled in the same way as in the renderer.
fn height(trex: &Trex, patch: usize, uv: Vec2) -> f32 {
    let (x0, y0) = trex.layout.origin(patch as u32);
    let t = uv * trex.layout.inner() as f32 + trex.layout.gutter as f32 - 0.5;
    let (i, j) = (t.x.floor(), t.y.floor());
    let width = trex.layout.size().0 as usize;
    let at =
        |di: usize, dj: usize| trex.heights[(y0 as usize + j as usize + dj) * width + x0 as usize + i as usize + di];
    bilinear([at(0, 0), at(1, 0), at(1, 1), at(0, 1)], t - Vec2::new(i, j))
}

/// Counts the micro-faces at texel spacing: all faces, folded faces (against the patch normal), and steep faces (cosine with the normal
/// below 0.5).
fn folds(trex: &Trex) -> (usize, usize, usize) {
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
    let sum = |f: fn(&(usize, usize)) -> usize| per_patch.iter().map(f).sum();
    (n * n * per_patch.len(), sum(|f| f.0), sum(|f| f.1))
}

/// Returns the largest difference of filtered heights across edges, in metres.
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
#[ignore = "long"]
fn tiles_agree_on_their_edges_and_do_not_fold() {
    let start = Instant::now();
    let mut trex = quick();
    println!("baked tile 16 in {:?}: {} patches", start.elapsed(), trex.body.patches.len());
    let unbaked = unbaked_body(16).heights.unwrap();
    assert_eq!((unbaked.map.width, unbaked.map.height), trex.layout.size());
    let worst = worst_edge(&trex);
    let (all, folded, steep) = folds(&trex);
    let (low, high) = trex.heights.iter().fold((f32::MAX, f32::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    println!("edge mismatch {worst:e} m; {all} faces, {folded} folded, {steep} steep; heights {low} .. {high}");
    assert!(worst < 1e-5, "{worst}");
    assert!((folded as f32) < 2e-4 * all as f32, "{folded} of {all}");
    assert!(trex.heights.iter().all(|h| h.is_finite() && h.abs() < 0.4));
    // Each measure detects a fault that is introduced here.
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
#[ignore = "long"]
fn baking_twice_gives_the_same_animal_and_the_cache_returns_it() {
    let dir = tempfile::tempdir().unwrap();
    let cache = MapCache::in_folder(dir.path());
    let load = || Trex::load_from(Some(&cache), 8, &|_| ()).unwrap();
    let (first, cached) = (load(), load());
    let files: Vec<_> = std::fs::read_dir(&dir).unwrap().map(|entry| entry.unwrap().path()).collect();
    let [file] = &files[..] else { panic!("{files:?}") };
    std::fs::write(file, b"not an animal").unwrap();
    let again = load();
    for other in [&cached, &again] {
        assert!(first.heights == other.heights && first.colors == other.colors);
        assert_eq!(first.body.positions, other.body.positions);
        assert_eq!(first.body.patches, other.body.patches);
    }
    assert!(std::fs::metadata(file).unwrap().len() > 1000, "the damaged file was replaced");
    // The folder cannot be created, because a file already has its name.
    assert!(Trex::load_from(Some(&MapCache::in_folder(file.join("below"))), 8, &|_| ()).is_ok());
}

#[test]
fn odd_tile_sizes_are_refused() {
    for tile in [0, 4, 48, 256, 1 << 30] {
        assert!(matches!(Trex::load_from(None, tile, &|_| ()), Err(crate::error::SceneError::Tile(_))));
    }
}
