//! Relaxes the extracted surface, so that it consists of uniform, square quads on the distance field.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::dual::QuadSurface;
use super::sdf::TrexSdf;
use leadr_render::surfaces::patch::Patch;

/// The maximum Newton step in metres.
const STEP_LIMIT: f32 = 0.03;
/// The number of rounds of tangential smoothing, and of fitting squares afterwards.
const SMOOTHING_ROUNDS: usize = 24;
const SQUARING_ROUNDS: usize = 30;

/// Returns the edge neighbours of every vertex, in ascending order.
pub fn neighbors(surface: &QuadSurface) -> Vec<Vec<u32>> {
    let mut out: Vec<Vec<u32>> = vec![Vec::new(); surface.positions.len()];
    for q in &surface.quads {
        for k in 0..4 {
            out[q[k] as usize].push(q[(k + 1) % 4]);
            out[q[(k + 1) % 4] as usize].push(q[k]);
        }
    }
    for list in &mut out {
        list.sort_unstable();
        list.dedup();
    }
    out
}

/// Smooths the vertices, makes the quads uniform, and projects the vertices onto the field. `ring` is the result of [`neighbors`].
pub fn relax(surface: &mut QuadSurface, ring: &[Vec<u32>], sdf: &TrexSdf) {
    // Taubin's pair of steps removes the staircase of the grid without shrinking the surface.
    for pass in 0..6 {
        let step = if pass % 2 == 0 { 0.55 } else { -0.25 };
        let pull = laplacian(&surface.positions, ring);
        surface.positions.iter_mut().zip(&pull).for_each(|(p, d)| *p += *d * step);
    }
    for round in 0..SMOOTHING_ROUNDS {
        let mut pull = laplacian(&surface.positions, ring);
        if round % 2 == 1 {
            let mean = mean_over(&pull, ring);
            pull.iter_mut().zip(&mean).for_each(|(d, m)| *d -= *m * 0.35);
        }
        move_on_surface(surface, &pull, ring, sdf);
    }
    for _ in 0..SQUARING_ROUNDS {
        // The sum and the number of the target positions of each vertex. Each adjacent quad has one target.
        let mut sums = vec![(Vec3::ZERO, 0.0f32); surface.positions.len()];
        for q in &surface.quads {
            for (&v, corner) in q.iter().zip(nearest_square(surface, *q)) {
                let (target, count) = &mut sums[v as usize];
                *target += corner;
                *count += 1.0;
            }
        }
        let means = sums.iter().map(|(target, count)| *target / *count);
        let pull: Vec<Vec3> = means.zip(&surface.positions).map(|(mean, p)| mean - *p).collect();
        move_on_surface(surface, &pull, ring, sdf);
    }
}

/// The largest number of smoothing rounds for folded patches.
const UNFOLD_ROUNDS: usize = 30;

/// Smooths the corners of patches that fold or nearly fold. Tips and clefts narrower than a quad become rounder than in the field.
pub fn unfold(surface: &mut QuadSurface, ring: &[Vec<u32>]) {
    for _ in 0..UNFOLD_ROUNDS {
        let normals = vertex_normals(surface, ring);
        let mut folded = vec![false; surface.positions.len()];
        for q in surface.quads.iter().filter(|q| folds(surface, &normals, **q)) {
            q.iter().for_each(|&i| folded[i as usize] = true);
        }
        if !folded.contains(&true) {
            return;
        }
        let pull = laplacian(&surface.positions, ring);
        let moved = surface.positions.iter_mut().zip(&pull).zip(folded).filter(|(_, f)| *f);
        moved.for_each(|((p, d), _)| *p += *d * 0.2);
    }
}

fn folds(surface: &QuadSurface, normals: &[Vec3], quad: [u32; 4]) -> bool {
    let patch = Patch::new(quad.map(|i| surface.positions[i as usize]), quad.map(|i| normals[i as usize]));
    (0..25).any(|i| {
        let point = patch.at(Vec2::new((i % 5) as f32, (i / 5) as f32) / 4.0);
        point.du.cross(point.dv).normalize_or_zero().dot(point.normal) < 0.05
    })
}

/// Returns the area-weighted mean of the face normals, smoothed once. The smoothing makes patches bend evenly at creases that are finer
/// than a quad.
pub fn vertex_normals(surface: &QuadSurface, ring: &[Vec<u32>]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; surface.positions.len()];
    for q in &surface.quads {
        let p = q.map(|i| surface.positions[i as usize]);
        let n = (p[2] - p[0]).cross(p[3] - p[1]);
        q.iter().for_each(|&i| normals[i as usize] += n);
    }
    normals.iter_mut().for_each(|n| *n = n.normalize_or(Vec3::Z));
    let mean = mean_over(&normals, ring);
    normals.iter().zip(&mean).map(|(n, m)| (*n + *m * 0.5).normalize_or(*n)).collect()
}

/// Moves vertices by half of the tangential part of `pull`, and then by two Newton steps towards the zero of the field.
fn move_on_surface(surface: &mut QuadSurface, pull: &[Vec3], ring: &[Vec<u32>], sdf: &TrexSdf) {
    let steps = difference_steps(&surface.positions, ring);
    surface.positions.par_iter_mut().zip(pull).zip(&steps).with_min_len(64).for_each(|((p, d), &e)| {
        let mut n = sdf.coarse.gradient(*p, e).normalize_or_zero();
        *p += (*d - n * d.dot(n)) * 0.5;
        *p -= n * (0.9 * sdf.coarse.distance(*p).clamp(-STEP_LIMIT, STEP_LIMIT));
        n = sdf.coarse.gradient(*p, e).normalize_or_zero();
        *p -= n * (0.9 * sdf.coarse.distance(*p).clamp(-STEP_LIMIT, STEP_LIMIT));
    });
}

/// Returns the step of the differences for gradients. A step is a tenth of the local edge length, which averages over creases that are
/// finer than the quads.
fn difference_steps(positions: &[Vec3], ring: &[Vec<u32>]) -> Vec<f32> {
    let edge = |v: usize| {
        ring[v].iter().map(|&w| positions[w as usize].distance(positions[v])).sum::<f32>() / ring[v].len() as f32
    };
    (0..positions.len()).map(|v| (0.1 * edge(v)).clamp(0.003, 0.012)).collect()
}

/// Returns the mean of the neighbours' values.
fn mean_over(values: &[Vec3], ring: &[Vec<u32>]) -> Vec<Vec3> {
    ring.iter().map(|r| r.iter().map(|&w| values[w as usize]).sum::<Vec3>() / r.len().max(1) as f32).collect()
}

fn laplacian(positions: &[Vec3], ring: &[Vec<u32>]) -> Vec<Vec3> {
    let mut mean = mean_over(positions, ring);
    mean.iter_mut().zip(positions).for_each(|(m, p)| *m -= *p);
    mean
}

/// Returns the square that fits the corners of a quad best in the least-squares sense, in their mean plane.
fn nearest_square(surface: &QuadSurface, quad: [u32; 4]) -> [Vec3; 4] {
    let p = quad.map(|i| surface.positions[i as usize]);
    let center = (p[0] + p[1] + p[2] + p[3]) * 0.25;
    let normal = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
    // If corner k is rotated back by k right angles, all four corners of a square coincide.
    let turn = |v: Vec3, k: usize| match k {
        0 => v,
        1 => normal.cross(v),
        2 => -v,
        _ => v.cross(normal),
    };
    let mut arm = Vec3::ZERO;
    for (k, corner) in p.iter().enumerate() {
        let flat = *corner - center;
        arm += turn(flat - normal * flat.dot(normal), (4 - k) % 4) * 0.25;
    }
    [0, 1, 2, 3].map(|k| center + turn(arm, k))
}
