//! Finds vertices of a model that are at the same point of its surface.
//!
//! A file has one vertex per combination of normal, texture coordinates, joints and material. If each vertex moved along its own normal,
//! cracks would open at the seams. Vertices that coincide in every sampled pose therefore form one *weld*, with one position and one
//! displacement direction. The renderer computes one height per weld, and one row of heights per edge between welds.

use std::collections::{HashMap, HashSet};

use glam::{I64Vec3, Vec3};

use super::parts::{Parts, Placement};
use leadr_models::{Model, Pose};
use leadr_render::surfaces::patch_mesh::PosedVertices;

/// The largest distance at rest between vertices of one weld, as a fraction of the model's diagonal.
const TOGETHER: f32 = 2e-6;
/// The largest distance in motion between vertices of one weld. Skinning adds rounding errors, so this distance is larger than the distance
/// at rest.
const TOGETHER_IN_MOTION: f32 = 1e-3;
/// The length of a weld's weighted mean normal below which opposing triangles cancel. A weld with a shorter mean is not displaced, because
/// it belongs to a two-sided surface, or to the seam of a one-sided surface.
const CANCELLED: f32 = 0.1;

/// The welds of a model's vertices.
pub struct Welds {
    /// The index of the weld for each vertex of each object.
    of: Vec<Vec<u32>>,
    /// The sum of the triangle angles at each vertex. The vertex's normal has this weight in the direction of the weld.
    weights: Vec<Vec<f32>>,
    count: usize,
}

impl Welds {
    /// Finds the welds of objects with these triangles. `poses` has the vertices of the objects, first at rest, and then at all other
    /// sampled times.
    pub fn of(poses: &[Vec<PosedVertices>], triangles: &[Vec<[u32; 3]>]) -> Self {
        let all: Vec<Vec<Vec3>> =
            poses.iter().map(|objects| objects.iter().flat_map(|o| o.positions.iter().copied()).collect()).collect();
        let rest = &all[0];
        let corners = rest.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), &p| (a.min(p), b.max(p)));
        let size = corners.0.distance(corners.1).max(f32::MIN_POSITIVE);
        let near = |a: usize, b: usize| {
            let distance = |positions: &Vec<Vec3>| positions[a].distance(positions[b]);
            distance(rest) <= TOGETHER * size && all[1..].iter().all(|p| distance(p) <= TOGETHER_IN_MOTION * size)
        };
        let cell = |p: Vec3| ((p - corners.0) / (4.0 * TOGETHER * size)).as_dvec3().floor().as_i64vec3();
        // The first vertex of each weld, by grid cell.
        let mut cells: HashMap<I64Vec3, Vec<(usize, u32)>> = HashMap::new();
        let (mut numbers, mut count) = (Vec::with_capacity(rest.len()), 0u32);
        for (vertex, &position) in rest.iter().enumerate() {
            let at = cell(position);
            let reach = |k: i64| at + I64Vec3::new(k % 3, k / 3 % 3, k / 9) - I64Vec3::ONE;
            let around = (0..27).map(reach).filter_map(|cell| cells.get(&cell)).flatten();
            let found = around.filter(|(first, _)| near(*first, vertex)).map(|(_, weld)| *weld).min();
            numbers.push(found.unwrap_or_else(|| {
                cells.entry(at).or_default().push((vertex, count));
                count += 1;
                count - 1
            }));
        }
        let mut of = Vec::new();
        let mut left = &numbers[..];
        for object in &poses[0] {
            let (own, others) = left.split_at(object.positions.len());
            of.push(own.to_vec());
            left = others;
        }
        let weights = poses[0].iter().zip(triangles).map(|(object, triangles)| angles(object, triangles)).collect();
        Self { of, weights, count: count as usize }
    }

    /// Maps each vertex of an object to the first vertex of the object in the same weld.
    pub fn firsts(&self, object: usize) -> Vec<u32> {
        let mut first = HashMap::new();
        (0..).zip(&self.of[object]).map(|(vertex, weld)| *first.entry(*weld).or_insert(vertex)).collect()
    }

    /// Whether a triangle of an object has area in any pose.
    pub fn is_spanned(&self, object: usize, triangle: [u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|vertex| self.of[object][vertex as usize]);
        a != b && b != c && c != a
    }

    /// Returns the edges of each object that it shares with other objects. An edge is a pair of the first vertices of its welds.
    pub fn rims(&self, triangles: &[Vec<[u32; 3]>]) -> Vec<Vec<[u32; 2]>> {
        let edges = |object: usize| {
            let of = &self.of[object];
            let welds = |t: &[u32; 3]| t.map(|vertex| of[vertex as usize]);
            let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
            triangles[object].iter().flat_map(move |t| sides(welds(t))).filter(|[a, b]| a != b)
        };
        let mut users: HashMap<[u32; 2], HashSet<usize>> = HashMap::new();
        for object in 0..triangles.len() {
            edges(object).for_each(|edge| {
                users.entry(edge).or_default().insert(object);
            });
        }
        let rims = |object: usize| {
            let first: HashMap<u32, u32> =
                (0..self.of[object].len()).rev().map(|vertex| (self.of[object][vertex], vertex as u32)).collect();
            let shared: HashSet<[u32; 2]> = edges(object).filter(|edge| users[edge].len() > 1).collect();
            let mut rims: Vec<_> = shared.into_iter().map(|edge| edge.map(|weld| first[&weld])).collect();
            rims.sort_unstable();
            rims
        };
        (0..triangles.len()).map(rims).collect()
    }

    /// Gives all vertices of a weld the same position and direction.
    pub fn share(&self, objects: &mut [PosedVertices]) {
        let mut welds = vec![(Vec3::ZERO, 0.0f32, Vec3::ZERO, 0.0f32); self.count];
        for ((object, of), weights) in objects.iter().zip(&self.of).zip(&self.weights) {
            for (vertex, &weld) in of.iter().enumerate() {
                let (position, count, direction, weight) = &mut welds[weld as usize];
                *position += object.positions[vertex];
                *count += 1.0;
                *direction += object.normals[vertex] * weights[vertex];
                *weight += weights[vertex];
            }
        }
        let common = |&(position, count, direction, weight): &(Vec3, f32, Vec3, f32)| {
            let cancelled = direction.length() <= CANCELLED * weight;
            (position / count, if cancelled { Vec3::ZERO } else { direction.normalize_or_zero() })
        };
        let welds: Vec<(Vec3, Vec3)> = welds.iter().map(common).collect();
        for (object, of) in objects.iter_mut().zip(&self.of) {
            (object.positions, object.directions) = of.iter().map(|&weld| welds[weld as usize]).unzip();
        }
    }
}

/// The surface data of all objects of a model.
pub struct Surface {
    /// The welds, if any material is displaced.
    pub welds: Option<Welds>,
    /// The edges of each object at which another object continues the surface.
    pub rims: Vec<Vec<[u32; 2]>>,
    /// The transform from the model to the world.
    pub placement: Placement,
    /// The diagonal of the model in metres.
    pub size: f32,
}

impl Surface {
    /// Returns the vertices of all instances of all objects in a pose.
    pub fn posed(&self, model: &Model, parts: &Parts, pose: &Pose) -> Vec<PosedVertices> {
        let mut posed = parts.all_posed(model, pose, &self.placement);
        if let Some(welds) = &self.welds {
            welds.share(&mut posed);
        }
        posed
    }
}

/// Returns the sum of the triangle angles at each vertex.
fn angles(vertices: &PosedVertices, triangles: &[[u32; 3]]) -> Vec<f32> {
    let mut sums = vec![0.0; vertices.positions.len()];
    for triangle in triangles {
        let at = triangle.map(|vertex| vertices.positions[vertex as usize]);
        for corner in 0..3 {
            let [to_next, to_last] = [1, 2].map(|k| (at[(corner + k) % 3] - at[corner]).normalize_or_zero());
            sums[triangle[corner] as usize] += to_next.dot(to_last).clamp(-1.0, 1.0).acos();
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns two triangles of two objects that share an edge, but no vertices.
    fn roof() -> (Vec<PosedVertices>, Vec<Vec<[u32; 3]>>) {
        let (left, right) = (Vec3::new(-1.0, 0.0, 1.0).normalize(), Vec3::new(1.0, 0.0, 1.0).normalize());
        let ridge = [Vec3::Z, Vec3::new(0.0, 1.0, 1.0)];
        let first = PosedVertices::new(vec![-Vec3::X, ridge[0], ridge[1]], vec![left; 3]);
        let second = PosedVertices::new(vec![ridge[1], ridge[0], Vec3::X], vec![right; 3]);
        (vec![first, second], vec![vec![[0, 1, 2]], vec![[0, 1, 2]]])
    }

    #[test]
    fn seam_vertices_weld_and_move_together() {
        let (mut objects, triangles) = roof();
        let welds = Welds::of(&[objects.clone()], &triangles);
        assert_eq!(welds.count, 4);
        assert_eq!(welds.rims(&triangles), [vec![[1, 2]], vec![[1, 0]]]);
        welds.share(&mut objects);
        let [a, b] = [&objects[0].directions, &objects[1].directions];
        assert_eq!((a[1], a[2]), (b[1], b[0]));
        assert!((a[1].length() - 1.0).abs() < 1e-6 && a[1].z > 0.9, "{}", a[1]);
        assert!((a[0] - Vec3::new(-1.0, 0.0, 1.0).normalize()).length() < 1e-6);
        // Each vertex keeps its original normal.
        assert!(objects[0].normals[1].x < -0.5 && objects[1].normals[1].x > 0.5);
    }

    #[test]
    fn vertices_that_separate_are_not_welded() {
        let (objects, triangles) = roof();
        let mut open = objects.clone();
        open[1].positions[1].x += 0.2;
        let welds = Welds::of(&[objects, open], &triangles);
        assert_eq!(welds.count, 5);
        assert!(welds.rims(&triangles).iter().all(Vec::is_empty));
    }

    #[test]
    fn opposite_normals_leave_a_weld_undisplaced() {
        let (mut objects, triangles) = roof();
        objects[0].normals = vec![Vec3::Y; 3];
        objects[1].normals = vec![-Vec3::Y; 3];
        let welds = Welds::of(&[objects.clone()], &triangles);
        welds.share(&mut objects);
        assert_eq!(objects[0].directions[1], Vec3::ZERO);
        assert_eq!(objects[0].directions[0], Vec3::Y);
    }

    #[test]
    fn firsts_give_the_first_vertex_of_each_weld() {
        let vertices = PosedVertices::new(vec![Vec3::X, Vec3::Y, Vec3::Z, Vec3::X, Vec3::Z, Vec3::Y], vec![Vec3::X; 6]);
        let triangles = vec![vec![[0, 1, 2], [3, 4, 5], [0, 3, 4]]];
        let welds = Welds::of(&[vec![vertices]], &triangles);
        assert_eq!(welds.firsts(0), [0, 1, 2, 0, 2, 1]);
        assert!(welds.is_spanned(0, [3, 4, 5]) && !welds.is_spanned(0, [0, 3, 4]));
    }
}
