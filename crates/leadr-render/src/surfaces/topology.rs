//! The edges of a quad mesh, and the direction in which each patch runs along its edges.

use std::collections::HashMap;

/// The edges of a quad mesh. Each edge runs from its lower to its higher vertex index.
#[derive(Clone, Debug, Default)]
pub struct Topology {
    /// The two vertices of each edge, with the lower index first.
    pub edges: Vec<[u32; 2]>,
    /// The value `edge << 1` for each side of each patch, in the order v=0, u=1, v=1, u=0. The lowest bit is set if the patch runs
    /// from the higher vertex to the lower. A side of zero length (in triangles) repeats the value of the previous side, and is not
    /// an edge.
    pub patch_edges: Vec<[u32; 4]>,
}

impl Topology {
    /// Finds the edges, and numbers them in order of their first use by the patches.
    pub fn new(patches: &[[u32; 4]]) -> Self {
        let mut index = HashMap::with_capacity(patches.len() * 2);
        let mut edges = Vec::with_capacity(patches.len() * 2);
        let patch_edges = patches
            .iter()
            .map(|patch| {
                std::array::from_fn(|side| {
                    let side = if has_length(patch, side) { side } else { (side + 3) & 3 };
                    let (from, to) = (patch[side], patch[(side + 1) & 3]);
                    let key = [from.min(to), from.max(to)];
                    let edge = *index.entry(key).or_insert_with(|| {
                        edges.push(key);
                        (edges.len() - 1) as u32
                    });
                    edge << 1 | u32::from(from > to)
                })
            })
            .collect();
        Self { edges, patch_edges }
    }

    /// Iterates over the sides of a patch, except sides of zero length.
    pub fn sides(&self, patch: usize) -> impl Iterator<Item = usize> + use<> {
        let edges = self.patch_edges[patch];
        (0..4).filter(move |&side| edges[side] != edges[(side + 3) & 3])
    }

    /// Returns the adjacent patch across each side of each patch, with the side of that patch. The entry is `None` if the edge does
    /// not join exactly two patches that run in opposite directions.
    pub fn neighbors(&self) -> Vec<[Option<(u32, u8)>; 4]> {
        let sides = self.sides_of_edges();
        let beyond = |edge: u32| {
            let both = sides[(edge >> 1) as usize];
            (both[0].0 == 1 && both[1].0 == 1).then_some(both[1 - (edge & 1) as usize].1)
        };
        self.patch_edges.iter().map(|edges| edges.map(beyond)).collect()
    }

    /// Returns the number of edges that do not join exactly two patches that run in opposite directions. The number is 0 on a
    /// closed, oriented surface.
    pub fn irregular_edges(&self) -> usize {
        self.sides_of_edges().iter().filter(|both| both.map(|(count, _)| count) != [1, 1]).count()
    }

    /// Returns, for each edge and direction, the number of patch sides that run along it, and the last of these sides.
    fn sides_of_edges(&self) -> Vec<[(u32, (u32, u8)); 2]> {
        let mut sides = vec![[(0, (0, 0)); 2]; self.edges.len()];
        for (patch, edges) in self.patch_edges.iter().enumerate() {
            for side in self.sides(patch) {
                let edge = edges[side];
                let (count, last) = &mut sides[(edge >> 1) as usize][(edge & 1) as usize];
                (*count, *last) = (*count + 1, (patch as u32, side as u8));
            }
        }
        sides
    }
}

fn has_length(patch: &[u32; 4], side: usize) -> bool {
    patch[side] != patch[(side + 1) & 3]
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUBE: [[u32; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

    #[test]
    fn a_cube_has_twelve_regular_edges() {
        let topology = Topology::new(&CUBE);
        assert_eq!(topology.edges.len(), 12);
        assert_eq!(topology.irregular_edges(), 0);
    }

    #[test]
    fn neighbors_meet_in_the_same_edge() {
        let topology = Topology::new(&CUBE);
        let neighbors = topology.neighbors();
        for (patch, sides) in neighbors.iter().enumerate() {
            for (side, neighbor) in sides.iter().enumerate() {
                let (other, beside) = neighbor.unwrap();
                assert_eq!(neighbors[other as usize][beside as usize], Some((patch as u32, side as u8)));
                let vertices = |p: usize, s: usize| [CUBE[p][s], CUBE[p][(s + 1) & 3]];
                let [from, to] = vertices(patch, side);
                assert_eq!(vertices(other as usize, beside as usize), [to, from]);
            }
        }
        let open = Topology::new(&CUBE[..5]).neighbors();
        assert_eq!(open.iter().flatten().filter(|n| n.is_none()).count(), 4);
    }

    #[test]
    fn triangles_have_three_sides() {
        // These patches form a tetrahedron.
        let topology = Topology::new(&[[0, 2, 1, 1], [0, 1, 3, 3], [1, 2, 3, 3], [2, 0, 3, 3]]);
        assert_eq!((topology.edges.len(), topology.irregular_edges()), (6, 0));
        assert!((0..4).all(|patch| topology.sides(patch).eq([0, 1, 3])));
        let neighbors = topology.neighbors();
        assert!(neighbors.iter().all(|sides| [0, 1, 3].iter().all(|&side: &usize| sides[side].is_some())));
    }

    #[test]
    fn missing_or_flipped_faces_are_detected() {
        assert_eq!(Topology::new(&CUBE[..5]).irregular_edges(), 4);
        let mut flipped = CUBE;
        flipped[2].reverse();
        assert!(Topology::new(&flipped).irregular_edges() > 0);
    }
}
