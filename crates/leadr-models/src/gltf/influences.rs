//! Selects the four strongest joints of each vertex from any number of sets of four.

use crate::mesh::Influences;

/// The joints and weights of all vertices from one pair of attributes.
pub(super) type Set = (Vec<[u32; 4]>, Vec<[f32; 4]>);

/// A repair is reported if a sum of weights differs from 1 by more than this limit, which allows for four weights rounded
/// down to bytes.
const ROUNDING: f32 = 4.5 / 255.0;

/// Returns the four strongest joints of each vertex, with weights that sum to 1. Also returns messages about repairs.
///
/// Negative weights and NaN are errors, because their meaning is unclear.
pub(super) fn strongest(sets: &[Set]) -> Result<(Vec<Influences>, Vec<String>), String> {
    let vertices = sets.first().map_or(0, |(joints, _)| joints.len());
    let mut all = Vec::with_capacity(vertices);
    let (mut dropped, mut unequal, mut unbound) = (0, 0, 0);
    let mut pairs: Vec<(u32, f32)> = Vec::new();
    for vertex in 0..vertices {
        pairs.clear();
        for (joints, weights) in sets {
            for (&joint, &weight) in joints[vertex].iter().zip(&weights[vertex]) {
                if !(0.0..=f32::MAX).contains(&weight) {
                    return Err(format!("a weight of vertex {vertex} is {weight}, but must be at least 0"));
                }
                match pairs.iter_mut().find(|(known, _)| *known == joint) {
                    Some((_, sum)) => *sum += weight,
                    None => pairs.push((joint, weight)),
                }
            }
        }
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
                influences.joints[i] =
                    u16::try_from(*joint).map_err(|_| format!("joint {joint} of vertex {vertex}"))?;
                influences.weights[i] = weight / kept;
            }
        } else {
            unbound += 1;
            influences.weights[0] = 1.0;
        }
        all.push(influences);
    }
    let mut remarks = Vec::new();
    let mut note = |count: usize, what: &str| {
        if count > 0 {
            remarks.push(format!("{count} of {vertices} vertices {what}"));
        }
    };
    note(dropped, "follow more than four joints; only the four strongest are kept");
    note(unequal, "have weights with a sum other than 1; they were scaled");
    note(unbound, "have only zero weights; they follow the skin's first joint");
    Ok((all, remarks))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strongest_four_keep_their_proportions() {
        let sets: [Set; 2] =
            [(vec![[1, 2, 3, 4]], vec![[0.1, 0.3, 0.1, 0.05]]), (vec![[5, 2, 7, 0]], vec![[0.2, 0.1, 0.15, 0.0]])];
        let (all, remarks) = strongest(&sets).unwrap();
        assert_eq!(all[0].joints[..3], [2, 5, 7]);
        let kept = 0.4 + 0.2 + 0.15 + 0.1;
        for (weight, wanted) in all[0].weights.iter().zip([0.4, 0.2, 0.15, 0.1]) {
            assert!((weight - wanted / kept).abs() < 1e-6);
        }
        assert_eq!(remarks.len(), 1, "{remarks:?}");
    }

    #[test]
    fn invalid_weights_are_refused_or_replaced() {
        let one = |weights| strongest(&[(vec![[3, 0, 0, 0]], vec![weights])]);
        for wrong in [f32::NAN, f32::INFINITY, -0.1] {
            assert!(one([wrong, 0.5, 0.0, 0.0]).is_err(), "{wrong}");
        }
        let (all, remarks) = one([0.0; 4]).unwrap();
        assert_eq!((all[0].joints, all[0].weights, remarks.len()), ([0; 4], [1.0, 0.0, 0.0, 0.0], 1));
        let (all, remarks) = one([0.5, 0.0, 0.0, 0.0]).unwrap();
        assert_eq!((all[0].weights[0], remarks.len()), (1.0, 1));
        assert!(one([1.0, 0.0, 0.0, 0.0]).unwrap().1.is_empty());
    }
}
