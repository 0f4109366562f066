//! Topology checks and shape measures of a quad surface.

use std::collections::HashMap;

use super::dual::QuadSurface;

/// Counts that tell whether a quad surface is one closed ball.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Topology {
    /// Vertices − edges + faces.
    pub euler: i64,
    /// Connected pieces (over vertices).
    pub components: usize,
    /// Edges with one quad.
    pub boundary_edges: usize,
    /// Edges with more than two quads, or two that run along it in the same direction.
    pub nonmanifold_edges: usize,
    /// Quads that use a vertex twice.
    pub degenerate_quads: usize,
}

impl Topology {
    /// Counts for a surface.
    pub fn of(surface: &QuadSurface) -> Self {
        let vertices = surface.positions.len();
        // Per undirected edge: quads that run along it upwards and downwards in vertex order.
        let mut edges: HashMap<[u32; 2], [u32; 2]> = HashMap::new();
        let mut parent: Vec<u32> = (0..vertices as u32).collect();
        fn root(parent: &mut [u32], mut v: u32) -> u32 {
            while parent[v as usize] != v {
                parent[v as usize] = parent[parent[v as usize] as usize];
                v = parent[v as usize];
            }
            v
        }
        let mut degenerate_quads = 0;
        for q in &surface.quads {
            degenerate_quads += usize::from((0..4).any(|i| (i + 1..4).any(|j| q[i] == q[j])));
            for k in 0..4 {
                let (a, b) = (q[k], q[(k + 1) % 4]);
                edges.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
                let (ra, rb) = (root(&mut parent, a), root(&mut parent, b));
                parent[ra as usize] = rb;
            }
        }
        let components = (0..vertices as u32).filter(|&v| root(&mut parent, v) == v).count();
        let boundary_edges = edges.values().filter(|c| c[0] + c[1] == 1).count();
        let nonmanifold_edges = edges.values().filter(|c| c[0] > 1 || c[1] > 1).count();
        let euler = vertices as i64 - edges.len() as i64 + surface.quads.len() as i64;
        Self { euler, components, boundary_edges, nonmanifold_edges, degenerate_quads }
    }

    /// Whether the surface is one closed manifold of genus zero.
    ///
    /// # Errors
    /// The counts, if it is not.
    pub fn check(self) -> Result<(), Self> {
        let ball = Self { euler: 2, components: 1, boundary_edges: 0, nonmanifold_edges: 0, degenerate_quads: 0 };
        if self == ball { Ok(()) } else { Err(self) }
    }
}

/// Neighbours along edges of every vertex, each list ascending.
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
