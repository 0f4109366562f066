//! Dual marching cubes on a structured grid. The resulting surface consists of quads. Each sheet of the surface in a cell has one vertex.
//!
//! Plain surface nets have one vertex per cell. Such a mesh becomes non-manifold where two sheets are close to each other. One vertex per
//! sheet avoids this problem (Nielson 2004).

use glam::Vec3;

/// The vertices and quads of a surface. Quads are counter-clockwise when seen from the positive side of the field.
#[derive(Clone, Debug, Default)]
pub struct QuadSurface {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// The vertex indices of the quads.
    pub quads: Vec<[u32; 4]>,
}

/// A grid of field samples. The sample `values[i]` is at `points[i]`, and has the index `(x·ny + y)·nz + z`.
#[derive(Clone, Debug)]
pub struct SampledGrid {
    /// The number of samples along each axis.
    pub size: [usize; 3],
    /// The positions of the samples. The grid may be warped.
    pub points: Vec<Vec3>,
    /// The values of the field, negative inside.
    pub values: Vec<f32>,
}

const NONE: u32 = u32::MAX;

/// Returns the twelve edges of a cell as pairs of corners. The bits of a corner are x, y and z.
fn cell_edges() -> Vec<[usize; 2]> {
    let mut edges = Vec::new();
    for a in 0..8_usize {
        for axis in 0..3 {
            if a >> axis & 1 == 0 {
                edges.push([a, a | 1 << axis]);
            }
        }
    }
    edges
}

/// Returns the sheet of each edge for one pattern of signs at the corners, or `None` if the surface does not cross the edge.
fn sheets(inside: usize, edges: &[[usize; 2]]) -> [Option<u8>; 12] {
    let is_inside = |c: usize| inside >> c & 1 == 1;
    let crossed = |e: usize| is_inside(edges[e][0]) != is_inside(edges[e][1]);
    let mut parent: Vec<usize> = (0..12).collect();
    fn root(parent: &[usize], mut e: usize) -> usize {
        while parent[e] != e {
            e = parent[e];
        }
        e
    }
    for axis in 0..3 {
        for side in 0..2 {
            let on_face = |c: usize| c >> axis & 1 == side;
            let on: Vec<usize> =
                (0..12).filter(|&e| crossed(e) && on_face(edges[e][0]) && on_face(edges[e][1])).collect();
            if on.len() == 2 {
                let (a, b) = (root(&parent, on[0]), root(&parent, on[1]));
                parent[a] = b;
            } else if on.len() == 4 {
                // On an ambiguous face, the two inside corners remain separate in both cells that share the face.
                for corner in (0..8).filter(|&c| on_face(c) && is_inside(c)) {
                    let pair: Vec<usize> = on.iter().copied().filter(|&e| edges[e].contains(&corner)).collect();
                    let (a, b) = (root(&parent, pair[0]), root(&parent, pair[1]));
                    parent[a] = b;
                }
            }
        }
    }
    let mut names: Vec<usize> = Vec::new();
    let mut out = [None; 12];
    for (e, sheet) in out.iter_mut().enumerate().filter(|(e, _)| crossed(*e)) {
        let r = root(&parent, e);
        let name = names.iter().position(|&n| n == r).unwrap_or_else(|| {
            names.push(r);
            names.len() - 1
        });
        *sheet = Some(name as u8);
    }
    out
}

/// Extracts the surface on which the field is zero. Each vertex is the mean of the edge crossings of its sheet.
pub fn extract(grid: &SampledGrid) -> QuadSurface {
    let [nx, ny, nz] = grid.size;
    let edges = cell_edges();
    let table: Vec<[Option<u8>; 12]> = (0..256).map(|inside| sheets(inside, &edges)).collect();
    let index = |x: usize, y: usize, z: usize| (x * ny + y) * nz + z;
    let corner = |c: usize| [c & 1, c >> 1 & 1, c >> 2 & 1];
    let mut surface = QuadSurface::default();
    // The first vertex and the sign pattern of each cell.
    let mut first = vec![NONE; nx * ny * nz];
    let mut pattern = vec![0_u8; nx * ny * nz];
    for x in 0..nx - 1 {
        for y in 0..ny - 1 {
            for z in 0..nz - 1 {
                let at = |c: usize| {
                    let [dx, dy, dz] = corner(c);
                    index(x + dx, y + dy, z + dz)
                };
                let inside = (0..8).fold(0, |bits, c| bits | usize::from(grid.values[at(c)] < 0.0) << c);
                if inside == 0 || inside == 255 {
                    continue;
                }
                let mut sums: Vec<(Vec3, f32)> = Vec::new();
                for (e, sheet) in table[inside].iter().enumerate() {
                    let Some(sheet) = *sheet else { continue };
                    let (i, j) = (at(edges[e][0]), at(edges[e][1]));
                    let t = grid.values[i] / (grid.values[i] - grid.values[j]);
                    sums.resize(sums.len().max(usize::from(sheet) + 1), (Vec3::ZERO, 0.0));
                    let sum = &mut sums[usize::from(sheet)];
                    *sum = (sum.0 + grid.points[i].lerp(grid.points[j], t), sum.1 + 1.0);
                }
                first[index(x, y, z)] = surface.positions.len() as u32;
                pattern[index(x, y, z)] = inside as u8;
                surface.positions.extend(sums.iter().map(|(sum, count)| *sum / *count));
            }
        }
    }
    // Each grid edge that the surface crosses gives a quad of the four cells around the edge.
    for x in 1..nx - 1 {
        for y in 1..ny - 1 {
            for z in 1..nz - 1 {
                for axis in 0..3 {
                    let low = index(x, y, z);
                    let step = [ny * nz, nz, 1];
                    let inside = grid.values[low] < 0.0;
                    if inside == (grid.values[low + step[axis]] < 0.0) {
                        continue;
                    }
                    let (o0, o1) = ((axis + 1) % 3, (axis + 2) % 3);
                    let vertex = |back0: usize, back1: usize| {
                        let cell = low - back0 * step[o0] - back1 * step[o1];
                        let a = back0 << o0 | back1 << o1;
                        let e = edges.iter().position(|&edge| edge == [a, a | 1 << axis]).expect("an edge of the cell");
                        let sheet = table[usize::from(pattern[cell])][e].expect("a crossed edge");
                        first[cell] + u32::from(sheet)
                    };
                    let mut quad = [vertex(1, 1), vertex(0, 1), vertex(0, 0), vertex(1, 0)];
                    if !inside {
                        quad.reverse();
                    }
                    surface.quads.push(quad);
                }
            }
        }
    }
    surface
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::trex::relax::neighbors;
    use leadr_render::surfaces::topology::Topology;

    /// Returns three values: vertices − edges + faces, the number of connected pieces, and the number of edges that two quads do not share
    /// in opposite directions.
    pub fn shape(surface: &QuadSurface) -> (i64, usize, usize) {
        let topology = Topology::new(&surface.quads);
        let euler = surface.positions.len() as i64 - topology.edges.len() as i64 + surface.quads.len() as i64;
        let ring = neighbors(surface);
        let (mut pieces, mut seen) = (0, vec![false; ring.len()]);
        for start in 0..ring.len() {
            pieces += usize::from(!seen[start]);
            let mut left = vec![start];
            while let Some(v) = left.pop() {
                if !std::mem::replace(&mut seen[v], true) {
                    left.extend(ring[v].iter().map(|&w| w as usize));
                }
            }
        }
        (euler, pieces, topology.irregular_edges())
    }

    /// The value of [`shape`] for one closed surface of genus zero.
    pub const BALL: (i64, usize, usize) = (2, 1, 0);

    fn sampled(n: usize, field: impl Fn(Vec3) -> f32) -> SampledGrid {
        let mut points = Vec::new();
        for x in 0..n {
            for y in 0..n {
                for z in 0..n {
                    points.push((Vec3::new(x as f32, y as f32, z as f32) + 0.5) / n as f32 * 2.0 - 1.0);
                }
            }
        }
        let values = points.iter().map(|&p| field(p)).collect();
        SampledGrid { size: [n; 3], points, values }
    }

    #[test]
    fn sphere_is_closed_and_faces_outwards() {
        let surface = extract(&sampled(16, |p| p.length() - 0.7));
        assert_eq!(shape(&surface), BALL);
        for q in &surface.quads {
            let p = q.map(|i| surface.positions[i as usize]);
            assert!((p[2] - p[0]).cross(p[3] - p[1]).dot(p[0]) > 0.0);
        }
    }

    #[test]
    fn fabricated_ring_and_spheres_are_detected() {
        let ring = extract(&sampled(24, |p| glam::Vec2::new(p.truncate().length() - 0.6, p.z).length() - 0.2));
        assert_eq!(shape(&ring), (0, 1, 0));
        let balls = |p: Vec3| (p - Vec3::X * 0.5).length().min((p + Vec3::X * 0.5).length()) - 0.3;
        assert_eq!(shape(&extract(&sampled(24, balls))), (4, 2, 0));
    }
}
