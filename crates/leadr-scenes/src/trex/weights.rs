//! The skinning weights of the cage, which depend on the parts near each vertex.

use glam::Vec3;
use rayon::prelude::*;

use super::parts::Binding;
use super::sdf::TrexSdf;
use super::skeleton::{AXIAL_CHAIN, JOINT_COUNT, joint_index};
use leadr_render::surfaces::patch_mesh::SkinWeights;

/// The length in metres over which the influence of a part falls to `1/e`. The length is shorter in the feet, which keeps toes rigid and
/// planted.
const FALLOFF: f32 = 0.055;
const FOOT_FALLOFF: f32 = 0.022;
/// The heights between which the falloff length changes, in metres.
const FOOT: [f32; 2] = [0.14, 0.50];
/// The fraction of the largest weight below which a weight is dropped.
const LEAST: f32 = 0.004;
/// The depth inside a part at which the distance is clamped, in metres.
const DEPTH: f32 = -0.02;
/// The number of smoothing passes. The passes blur as on a mesh with these edge lengths, in metres. The blur is small in the feet and
/// around the mouth, and larger where large muscles slide.
const PASSES: usize = 12;
const CRISP_EDGE: f32 = 0.028;
const SOFT_EDGE: f32 = 0.065;

type Row = [f32; JOINT_COUNT];

/// Returns the weights for these rest positions. `ring` lists the neighbours of each vertex, for smoothing.
pub fn skin_weights(sdf: &TrexSdf, positions: &[Vec3], ring: &[Vec<u32>]) -> Vec<SkinWeights> {
    let mut rows: Vec<Row> = positions.par_iter().with_min_len(64).map(|&p| raw_weights(sdf, p)).collect();
    // A pass blurs over one edge length, so areas with long edges use smaller steps for the same blur.
    let step: Vec<f32> = (0..positions.len())
        .map(|v| {
            let edges = ring[v].iter().map(|&w| positions[w as usize].distance(positions[v])).sum::<f32>();
            let edge = edges / ring[v].len().max(1) as f32;
            let p = positions[v];
            let crisp = (1.0 - above_foot(p)).max(((p.x - 3.0) / 0.4).clamp(0.0, 1.0));
            let blur = SOFT_EDGE + (CRISP_EDGE - SOFT_EDGE) * crisp;
            0.5 * (blur / edge).powi(2).min(1.0)
        })
        .collect();
    for _ in 0..PASSES {
        rows = (0..rows.len())
            .map(|v| {
                let mut row = rows[v];
                let share = step[v] / ring[v].len().max(1) as f32;
                row.iter_mut().for_each(|w| *w *= 1.0 - step[v]);
                for &n in &ring[v] {
                    row.iter_mut().zip(&rows[n as usize]).for_each(|(w, o)| *w += share * o);
                }
                row
            })
            .collect();
    }
    rows.iter().map(largest_four).collect()
}

/// Returns 0 in the feet and 1 above the feet.
fn above_foot(p: Vec3) -> f32 {
    ((p.z - FOOT[0]) / (FOOT[1] - FOOT[0])).clamp(0.0, 1.0)
}

fn raw_weights(sdf: &TrexSdf, p: Vec3) -> Row {
    let parts = sdf.near_parts(p, 0.6);
    let nearest = parts.iter().map(|(_, hit)| hit.distance.max(DEPTH)).fold(f32::MAX, f32::min);
    let falloff = FOOT_FALLOFF + (FALLOFF - FOOT_FALLOFF) * above_foot(p);
    let side = if p.y < 0.0 { "_R" } else { "_L" };
    let mut row = [0.0; JOINT_COUNT];
    for (binding, hit) in &parts {
        let influence = (-(hit.distance.max(DEPTH) - nearest) / falloff).exp();
        if influence < LEAST {
            continue;
        }
        let mut give = |name: &str, share: f32| row[joint_index(name)] += influence * share;
        let limb = |name: &str| {
            let paired = ["hip", "knee", "ankle", "toe", "arm", "elbow", "wrist"];
            if paired.iter().any(|s| name.starts_with(s)) { format!("{name}{side}") } else { name.to_owned() }
        };
        match *binding {
            Binding::Axis => {
                let c = hit.chain.clamp(0.0, 15.0);
                let i = (c as usize).min(14);
                give(AXIAL_CHAIN[i], 1.0 - (c - i as f32));
                give(AXIAL_CHAIN[i + 1], c - i as f32);
            }
            Binding::Blend(from, to) => {
                let c = hit.chain.clamp(0.0, 1.0);
                give(&limb(from), 1.0 - c);
                give(&limb(to), c);
            }
            Binding::Rigid(name) => give(&limb(name), 1.0),
        }
    }
    let sum: f32 = row.iter().sum();
    row.iter_mut().for_each(|w| *w /= sum);
    row
}

fn largest_four(row: &Row) -> SkinWeights {
    let mut order: Vec<usize> = (0..JOINT_COUNT).filter(|&j| row[j] > 1e-4).collect();
    order.sort_by(|&a, &b| row[b].total_cmp(&row[a]).then(a.cmp(&b)));
    order.truncate(4);
    let sum: f32 = order.iter().map(|&j| row[j]).sum();
    let mut out = SkinWeights::default();
    for (slot, &j) in order.iter().enumerate() {
        out.joints[slot] = j as u16;
        out.weights[slot] = row[j] / sum;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_follow_the_nearest_bone() {
        let sdf = TrexSdf::new();
        let samples = [
            (Vec3::new(-6.6, 0.0, 2.72), "tail8"),
            (Vec3::new(0.85, 0.44, 0.02), "toe3_L"),
            (Vec3::new(0.85, -0.44, 0.02), "toe3_R"),
            (Vec3::new(0.2, -0.42, 0.0), "toes_R"),
            (Vec3::new(4.6, 0.1, 4.0), "head"),
            (Vec3::new(4.3, 0.0, 2.95), "jaw"),
            (Vec3::new(2.2, 0.6, 1.85), "wrist_L"),
        ];
        let points: Vec<Vec3> = samples.iter().map(|p| p.0).collect();
        let alone = vec![Vec::new(); points.len()];
        for (skin, (p, name)) in skin_weights(&sdf, &points, &alone).iter().zip(samples) {
            assert!((skin.weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
            assert!(skin.weights.is_sorted_by(|a, b| a >= b));
            assert_eq!(usize::from(skin.joints[0]), joint_index(name), "{p} follows {skin:?}");
            assert!(skin.weights[0] > 0.6, "{name} {skin:?}");
        }
    }
}
