//! Selects the four strongest joints of each vertex from any number of sets of four.

use super::repair::Finding;
use crate::mesh::Influences;

/// The joints and weights of all vertices from one pair of attributes.
pub(super) type Set = (Vec<[u32; 4]>, Vec<[f32; 4]>);

/// A repair is reported if a sum of weights differs from 1 by more than this limit, which allows for four weights rounded
/// down to bytes.
const ROUNDING: f32 = 4.5 / 255.0;

/// Returns the four strongest joints of each vertex, with weights that sum to 1. Also returns what was repaired.
pub(super) fn strongest(sets: &[Set]) -> (Vec<Influences>, Vec<Finding>) {
    let vertices = sets.first().map_or(0, |(joints, _)| joints.len());
    let mut all = Vec::with_capacity(vertices);
    let (mut dropped, mut unequal, mut unbound, mut wrong) = (0, 0, 0, 0);
    let mut pairs: Vec<(u32, f32)> = Vec::new();
    for vertex in 0..vertices {
        pairs.clear();
        let mut bad = false;
        for (joints, weights) in sets {
            for (&joint, &weight) in joints[vertex].iter().zip(&weights[vertex]) {
                let is_good = (0.0..=f32::MAX).contains(&weight) && joint <= u32::from(u16::MAX);
                bad |= !is_good;
                let (joint, weight) = if is_good { (joint, weight) } else { (0, 0.0) };
                match pairs.iter_mut().find(|(known, _)| *known == joint) {
                    Some((_, sum)) => *sum += weight,
                    None => pairs.push((joint, weight)),
                }
            }
        }
        wrong += usize::from(bad);
        pairs.retain(|(_, weight)| *weight > 0.0);
        pairs.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        let whole: f32 = pairs.iter().map(|(_, weight)| weight).sum();
        dropped += usize::from(pairs.len() > 4);
        pairs.truncate(4);
        let kept: f32 = pairs.iter().map(|(_, weight)| weight).sum();
        let mut influences = Influences::default();
        if kept > 0.0 && kept.is_finite() {
            unequal += usize::from((whole - 1.0).abs() > ROUNDING);
            for (i, (joint, weight)) in pairs.iter().enumerate() {
                (influences.joints[i], influences.weights[i]) = (*joint as u16, weight / kept);
            }
        } else {
            unbound += 1;
            influences.weights[0] = 1.0;
        }
        all.push(influences);
    }
    let mut findings = Vec::new();
    let mut note = |count: usize, what: &str, repair| {
        if count > 0 {
            findings.push(Finding { what: format!("{count} of {vertices} vertices {what}"), repair });
        }
    };
    note(wrong, "have a weight that is negative or not a number", Some("such weights are read as 0"));
    note(dropped, "follow more than four joints; only the four strongest are kept", None);
    note(unequal, "have weights with a sum other than 1", Some("they are scaled"));
    note(unbound, "have only zero weights", Some("they follow the skin's first joint"));
    (all, findings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strongest_four_keep_their_proportions() {
        let sets: [Set; 2] =
            [(vec![[1, 2, 3, 4]], vec![[0.1, 0.3, 0.1, 0.05]]), (vec![[5, 2, 7, 0]], vec![[0.2, 0.1, 0.15, 0.0]])];
        let (all, remarks) = strongest(&sets);
        assert_eq!(all[0].joints[..3], [2, 5, 7]);
        let kept = 0.4 + 0.2 + 0.15 + 0.1;
        for (weight, wanted) in all[0].weights.iter().zip([0.4, 0.2, 0.15, 0.1]) {
            assert!((weight - wanted / kept).abs() < 1e-6);
        }
        assert_eq!(remarks.len(), 1);
    }

    #[test]
    fn invalid_weights_are_replaced() {
        let one = |weights| strongest(&[(vec![[3, 0, 0, 0]], vec![weights])]);
        for wrong in [f32::NAN, f32::INFINITY, -0.1] {
            let (all, remarks) = one([0.5, wrong, 0.5, 0.0]);
            assert_eq!((all[0].joints[..2].to_vec(), all[0].weights[..2].to_vec()), (vec![3, 0], vec![0.5, 0.5]));
            assert!(remarks.len() == 1 && remarks[0].what.contains("negative or not a number"), "{wrong}");
        }
        let (all, remarks) = one([0.0; 4]);
        assert_eq!((all[0].joints, all[0].weights, remarks.len()), ([0; 4], [1.0, 0.0, 0.0, 0.0], 1));
        let (all, remarks) = one([0.5, 0.0, 0.0, 0.0]);
        assert_eq!((all[0].weights[0], remarks.len()), (1.0, 1));
        assert!(one([1.0, 0.0, 0.0, 0.0]).1.is_empty());
    }
}
