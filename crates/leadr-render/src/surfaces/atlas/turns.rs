//! Quarter turns that align the coordinates of patches.
//!
//! Every patch has its own coordinate directions, but classes of facets depend on direction: walls along a course of bricks differ from walls
//! across it. A patch is therefore turned, so that its coordinates continue those of its neighbours. Where three or five patches meet,
//! this is impossible along some edges.

use glam::Vec3;
use leadr_maps::Moments;

/// The patches across the sides of each patch, as in [`Topology::neighbors`](crate::surfaces::topology::Topology::neighbors).
type Neighbors = [[Option<(u32, u8)>; 4]];

/// Returns the number of quarter turns, from 0 to 3, from the first coordinate direction of each patch to its aligned direction.
pub fn quarter_turns(neighbors: &Neighbors) -> Vec<u32> {
    let mut turns = vec![None; neighbors.len()];
    let mut found = std::collections::VecDeque::new();
    for first in 0..neighbors.len() {
        if turns[first].is_none() {
            turns[first] = Some(0);
            found.push_back(first);
        }
        while let Some(patch) = found.pop_front() {
            let turn = turns[patch].unwrap_or(0);
            for (side, neighbor) in (0..4).zip(neighbors[patch]) {
                let Some((other, beside)) = neighbor.filter(|(other, _)| turns[*other as usize].is_none()) else {
                    continue;
                };
                // The direction out of a side is `side − 1` quarter turns from the first coordinate direction.
                turns[other as usize] = Some((turn + u32::from(beside) + 6 - side) % 4);
                found.push_back(other as usize);
            }
        }
    }
    turns.into_iter().map(|turn| turn.unwrap_or(0)).collect()
}

/// Returns the tangents in aligned directions.
pub fn turned_tangents([s, t]: [Vec3; 2], turn: u32) -> [Vec3; 2] {
    (0..turn).fold([s, t], |[s, t], _| [t, -s])
}

/// Returns moments with the slopes along aligned directions.
pub fn turned_moments(moments: Moments, turn: u32) -> Moments {
    (0..turn).fold(moments, |Moments { mean_slope: [s, t], second: [ss, tt], cross, height }, _| Moments {
        mean_slope: [t, -s],
        second: [tt, ss],
        cross: -cross,
        height,
    })
}

/// Returns a texture coordinate, from 0 to 1, along aligned directions.
pub fn turned_texcoord(at: [f64; 2], turn: u32) -> [f64; 2] {
    (0..turn).fold(at, |[s, t], _| [t, 1.0 - s])
}

/// Returns the texels of a square with rows along aligned directions.
pub fn turned_texels<T: Copy>(texels: Vec<T>, side: usize, turn: u32) -> Vec<T> {
    (0..turn)
        .fold(texels, |texels, _| (0..side * side).map(|i| texels[i % side * side + side - 1 - i / side]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surfaces::topology::Topology;

    #[test]
    fn rotated_patches_of_a_grid_agree() {
        let vertex = |x: usize, y: usize| (y * 4 + x) as u32;
        let positions: Vec<Vec3> = (0..16).map(|i| Vec3::new((i % 4) as f32, (i / 4) as f32, 0.0)).collect();
        let mut patches = Vec::new();
        for i in 0..9 {
            let (x, y) = (i % 3, i / 3);
            let mut patch = [vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)];
            patch.rotate_left(i * 7 / 3 % 4);
            patches.push(patch);
        }
        let turns = quarter_turns(&Topology::new(&patches).neighbors());
        for (patch, turn) in patches.iter().zip(turns) {
            let [a, b, _, d] = patch.map(|vertex| positions[vertex as usize]);
            assert_eq!(
                turned_tangents([b - a, d - a], turn)[0],
                positions[patches[0][1] as usize] - positions[patches[0][0] as usize]
            );
        }
    }

    #[test]
    fn texels_turn_with_their_texcoords() {
        let texels: Vec<usize> = (0..9).collect();
        for turn in 0..4 {
            let turned = turned_texels(texels.clone(), 3, turn);
            for i in 0..9 {
                let centre = |i: usize| [i % 3, i / 3].map(|k| (k as f64 + 0.5) / 3.0);
                let [s, t] = turned_texcoord(centre(i), turn).map(|v| (v * 3.0) as usize);
                assert_eq!(turned[t * 3 + s], i, "{turn}");
            }
        }
    }
}
