//! Tessellates each patch for a frame, selects the visible patches, and splits them into draws.
//!
//! Each tessellation factor belongs to an edge, and depends only on the two ends of the edge, so adjacent patches always agree.
//! Rotating the camera in place changes no factor.

use super::patch_mesh::PatchMesh;
use super::topology::Topology;
use crate::constants::GUARD_BAND;
use glam::{Mat4, Vec3, Vec4};
use rayon::prelude::*;

pub use crate::constants::MAX_FACTOR;

/// The position of the viewer, and the scale from world lengths to pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// The position of the viewer.
    pub eye: Vec3,
    /// The size in pixels of a unit length at unit distance, which is `height / (2 tan(fov_y / 2))`.
    pub focal_pixels: f32,
    /// The distance of the near plane.
    pub near: f32,
}

impl Lens {
    /// Returns the number of pixels that `length` covers around `centre`, perpendicular to the line of sight.
    pub(crate) fn pixels(&self, centre: Vec3, length: f32) -> f32 {
        let distance = (centre.distance(self.eye) - 0.5 * length).max(self.near);
        length * self.focal_pixels / distance
    }
}

/// The position of a viewer, which may be at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Viewer {
    /// The viewer is at this point.
    At(Vec3),
    /// The viewer is at infinity in this unit direction, like a sun.
    Toward(Vec3),
}

impl Viewer {
    /// Returns the unit direction from a point to the viewer.
    pub(super) fn toward(self, point: Vec3) -> Vec3 {
        match self {
            Self::At(eye) => (eye - point).normalize_or_zero(),
            Self::Toward(direction) => direction,
        }
    }
}

/// The tessellation settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TessellationSettings {
    /// The area of a triangle in pixels on the screen. The default of 4 spaces vertices about 2.8 pixels apart.
    pub pixels_per_triangle: f32,
    /// The upper bound on the tessellation factors, from 1 to 63.
    pub max_factor: f32,
    /// Whether every texel of the height map gets a vertex (within `max_factor` and `vertices_per_pixel`), even if several texels
    /// share a pixel. Reference images and edge samples need it. Patches without relief are tessellated as usual.
    pub to_texels: bool,
    /// The maximum number of vertices along one side of a pixel that `to_texels` may use. The default of 16 exceeds the resolution
    /// of any number of samples.
    pub vertices_per_pixel: f32,
    /// Whether invisible patches are culled.
    pub cull: bool,
    /// The maximum number of tessellated vertices per draw. Some software drivers silently produce wrong results above 65,536.
    pub max_vertices_per_draw: u32,
}

impl Default for TessellationSettings {
    fn default() -> Self {
        Self {
            pixels_per_triangle: 4.0,
            max_factor: MAX_FACTOR,
            to_texels: false,
            vertices_per_pixel: 16.0,
            cull: true,
            max_vertices_per_draw: u32::MAX,
        }
    }
}

impl TessellationSettings {
    /// Whether patches whose edges are `pixels` pixels long can reach the requested vertex spacing.
    pub fn is_sufficient_for(&self, pixels: f32) -> bool {
        !self.to_texels && pixels <= self.spacing() * self.max_factor.clamp(1.0, MAX_FACTOR)
    }

    /// Returns the distance between vertices in pixels. Two triangles of area `A` fill a square cell with the side `√2A`.
    fn spacing(&self) -> f32 {
        (2.0 * self.pixels_per_triangle).sqrt()
    }

    /// Whether two settings give the same tessellation factors.
    pub fn divides_as(&self, other: &Self) -> bool {
        let Self { cull, max_vertices_per_draw, .. } = *other;
        Self { cull, max_vertices_per_draw, ..*self } == *other
    }
}

/// A mesh in the pose of a frame.
#[derive(Clone, Copy, Debug)]
pub struct PosedMesh<'a> {
    /// The mesh.
    pub mesh: &'a PatchMesh,
    /// The edges of the mesh.
    pub topology: &'a Topology,
    /// The positions of the vertices in world space.
    pub positions: &'a [Vec3],
    /// The unit normals of the vertices, in world space.
    pub normals: &'a [Vec3],
    /// The number of height map texels along each edge. The list is empty without displacement.
    pub edge_texels: &'a [f32],
    /// The height range along each edge before scaling. The list is empty without displacement.
    pub edge_relief: &'a [f32],
    /// The height range of each patch before scaling. The list is empty without displacement.
    pub height_range: &'a [[f32; 2]],
    /// The factor from heights of the map to displacements.
    pub height_scale: f32,
}

/// The tessellation of a mesh for a lens, independent of the orientation of the camera. The camera shares it with the suns.
#[derive(Clone, Debug, Default)]
pub struct Division {
    /// The tessellation factor of each edge.
    pub edge_factors: Vec<f32>,
    /// The level of the boundary heights at each vertex, where 0 is the finest level.
    pub vertex_lods: Vec<f32>,
    /// The offset of each vertex along its normal. The offsets centre the flat triangles on the smooth surface, so that they do not
    /// lie inside it.
    pub vertex_lifts: Vec<f32>,
    /// Whether every edge has at least as many segments as texels, because of `to_texels`.
    pub every_texel: bool,
}

/// The patches of a tessellated mesh that a view draws.
#[derive(Clone, Debug, Default)]
pub struct DrawList {
    /// The indices of the patches to draw.
    pub visible: Vec<u32>,
    /// The draws, as ranges of `visible`.
    pub draws: Draws,
    /// An upper bound on the number of triangles that are drawn.
    pub triangles: u64,
}

/// Draw calls, each a `(first, count)` range of the visible patches. Draw calls that need no clipping come first.
#[derive(Clone, Debug, Default)]
pub struct Draws {
    /// The draws of patches that only have vertices at their corners.
    pub undivided: Vec<(u32, u32)>,
    /// The draws of all other patches.
    pub divided: Vec<(u32, u32)>,
}

impl Draws {
    /// Iterates over all draws.
    pub fn all(&self) -> impl Iterator<Item = (u32, u32)> {
        self.undivided.iter().chain(&self.divided).copied()
    }
}

impl Division {
    /// Computes the factors of all edges, and the vertex data that depends on the factors.
    pub fn new(posed: PosedMesh<'_>, lens: Lens, settings: &TessellationSettings) -> Self {
        let PosedMesh { topology, positions, normals, .. } = posed;
        let spacing = settings.spacing();
        let max_factor = settings.max_factor.clamp(1.0, MAX_FACTOR);
        let edge_factors: Vec<f32> = topology
            .edges
            .par_iter()
            .with_min_len(LEAST_TASK)
            .enumerate()
            .map(|(edge, &[a, b])| {
                let (a, b) = (a as usize, b as usize);
                let relief = posed.edge_relief.get(edge).copied().unwrap_or(0.0) * posed.height_scale.abs();
                if posed.mesh.triangles && relief == 0.0 {
                    return 1.0;
                }
                // The base surface of a triangle is flat, so differences between its vertex normals do not count as curvature.
                let normals = if posed.mesh.triangles { [Vec3::Z; 2] } else { [normals[a], normals[b]] };
                let pixels = edge_pixels(&lens, [positions[a], positions[b]], normals, relief);
                // An edge without displacement has no texels to resolve.
                let dense = settings.to_texels && relief > 0.0;
                let texels = if dense { posed.edge_texels.get(edge).copied().unwrap_or(1.0) } else { 1.0 };
                let length = lens.pixels((positions[a] + positions[b]) * 0.5, positions[a].distance(positions[b]));
                (pixels / spacing).max(texels.min(settings.vertices_per_pixel * length)).clamp(1.0, max_factor)
            })
            .collect();
        let every_texel = settings.to_texels
            && !posed.edge_texels.is_empty()
            && edge_factors.iter().zip(posed.edge_texels).all(|(factor, texels)| *factor + 1e-2 >= *texels);
        Self { every_texel, ..Self::of_factors(posed, edge_factors) }
    }

    /// Returns a coarser tessellation, with vertices at least `spacing` metres apart along the smooth surface. Returns `None` if
    /// the vertices are nowhere closer than `spacing`.
    pub fn with_min_spacing(&self, spacing: f32, posed: PosedMesh<'_>) -> Option<Self> {
        let PosedMesh { topology, positions, .. } = posed;
        let coarser = |(&[a, b], &factor): (&[u32; 2], &f32)| {
            factor.min((positions[a as usize].distance(positions[b as usize]) / spacing).max(1.0))
        };
        let factors: Vec<f32> =
            topology.edges.par_iter().with_min_len(LEAST_TASK).zip(&self.edge_factors).map(coarser).collect();
        (factors != self.edge_factors).then(|| Self::of_factors(posed, factors))
    }

    fn of_factors(posed: PosedMesh<'_>, edge_factors: Vec<f32>) -> Self {
        let PosedMesh { mesh, topology, positions, normals, .. } = posed;
        let mut vertices = vec![(0.0f32, 0.0f32, 0u32); positions.len()];
        for (&[a, b], &factor) in topology.edges.iter().zip(&edge_factors) {
            let (level, (a, b)) = ((64.0 / factor).log2(), (a as usize, b as usize));
            let gap =
                if mesh.triangles { 0.0 } else { mean_gap(positions[b] - positions[a], [normals[a], normals[b]]) };
            let lift = gap / (factor * factor);
            for vertex in [a, b] {
                let (levels, lifts, count) = &mut vertices[vertex];
                *levels += level;
                *lifts += lift;
                *count += 1;
            }
        }
        let mean = |(sum, count): (f32, u32)| sum / count.max(1) as f32;
        let welds = || (0..positions.len() as u32).map(|vertex| vertices[mesh.weld_of(vertex) as usize]);
        Self {
            vertex_lods: welds().map(|v| mean((v.0, v.2))).collect(),
            vertex_lifts: welds().map(|v| mean((v.1, v.2))).collect(),
            every_texel: false,
            edge_factors,
        }
    }
}

impl DrawList {
    /// Culls the patches of a mesh with the given edge factors, and splits the visible patches into draws.
    pub fn new(
        posed: PosedMesh<'_>,
        edge_factors: &[f32],
        clip_from_world: Mat4,
        viewer: Viewer,
        settings: &TessellationSettings,
    ) -> Self {
        let PosedMesh { mesh, topology, positions, normals, .. } = posed;
        let (view, band) = (frustum_planes(clip_from_world, 1.0), frustum_planes(clip_from_world, GUARD_BAND));
        // Patches that need clipping come last, in separate draws. If any triangle of a draw is clipped, software drivers process
        // all triangles of the draw about twenty times more slowly.
        let group_of = |(index, patch): (usize, &[u32; 4])| {
            let corners = patch.map(|v| (positions[v as usize], normals[v as usize]));
            let range = posed.height_range.get(index).map_or([0.0; 2], |r| r.map(|h| h * posed.height_scale));
            let away = || !mesh.triangles && faces_away(viewer, &corners, range);
            let reach = reach(&corners, range);
            let inside = classify_in_view(&view, &corners, reach);
            if settings.cull && (inside == Inside::Outside || away()) {
                return None;
            }
            let divided = topology.patch_edges[index].iter().any(|edge| edge_factors[(edge >> 1) as usize] > 1.0);
            let crossing = inside != Inside::Wholly && classify_in_view(&band, &corners, reach) != Inside::Wholly;
            Some(2 * usize::from(divided) + usize::from(crossing))
        };
        let group_of_patches: Vec<Option<usize>> =
            mesh.patches.par_iter().with_min_len(LEAST_TASK).enumerate().map(group_of).collect();
        let mut groups = [const { Vec::new() }; 4];
        for (patch, group) in (0..).zip(group_of_patches) {
            if let Some(group) = group {
                groups[group].push(patch);
            }
        }
        let mut list = Self::default();
        let mut draws = |group: &[u32]| list.draws_of(group, topology, edge_factors, settings.max_vertices_per_draw);
        let [undivided, undivided_crossing, divided, divided_crossing] = groups.map(|group| draws(&group));
        list.draws = Draws {
            undivided: [undivided, undivided_crossing].concat(),
            divided: [divided, divided_crossing].concat(),
        };
        list
    }

    /// Appends `patches` to the visible patches, and returns draws for them. Each draw is within the vertex limit.
    fn draws_of(
        &mut self,
        patches: &[u32],
        topology: &Topology,
        edge_factors: &[f32],
        max_vertices: u32,
    ) -> Vec<(u32, u32)> {
        let mut draws = Vec::new();
        let (mut first, mut vertices) = (self.visible.len() as u32, 0u32);
        for &patch in patches {
            let edges = &topology.patch_edges[patch as usize];
            let factor = edges.iter().map(|&e| edge_factors[(e >> 1) as usize]).fold(1.0, f32::max);
            let segments = odd_ceil(factor);
            let patch_vertices = (segments + 1) * (segments + 1);
            let next = self.visible.len() as u32;
            if next > first && vertices.saturating_add(patch_vertices) >= max_vertices {
                draws.push((first, next - first));
                (first, vertices) = (next, 0);
            }
            vertices = vertices.saturating_add(patch_vertices);
            self.visible.push(patch);
            self.triangles += u64::from(2 * segments * segments);
        }
        let count = self.visible.len() as u32 - first;
        if count > 0 {
            draws.push((first, count));
        }
        draws
    }
}

/// The minimum number of edges or patches for each parallel task.
const LEAST_TASK: usize = 512;
/// The slope of bumps that is assumed to stay visible when an edge is seen end-on.
const BUMP_SLOPE: f32 = 0.3;
/// The height of the relief in pixels from which the side view of bumps counts fully. Bumps lower than a pixel occlude nothing.
const HIDING_RELIEF: f32 = 6.0;
/// The height of the relief in pixels from which an edge gets the full tessellation for its screen length.
const FULL_RELIEF: f32 = 2.0;

/// Returns the screen length that determines the tessellation factor of an edge. The length is foreshortened, but is never below
/// the side view of the bumps on the edge. The length decreases if bumps and curvature are small in pixels.
fn edge_pixels(lens: &Lens, positions: [Vec3; 2], normals: [Vec3; 2], relief: f32) -> f32 {
    let centre = (positions[0] + positions[1]) * 0.5;
    let along = positions[1] - positions[0];
    let length = along.length();
    let sine = along.cross(Viewer::At(lens.eye).toward(centre)).length() / length.max(1e-20);
    let bulge = length * normals[0].distance(normals[1]) * 0.25;
    let scale = lens.pixels(centre, length) / length.max(1e-20);
    let prominent = |full: f32| ((relief + bulge) * scale / full).min(1.0);
    length * scale * sine.hypot(BUMP_SLOPE * prominent(HIDING_RELIEF)) * prominent(FULL_RELIEF).sqrt()
}

/// Returns the mean distance from two flat triangles to the smooth surface above them. The curvature of the edge is assumed in both
/// directions. The distance is negative for a concave surface. Dividing an edge into `n` segments scales the distance by `1 / n²`.
///
/// Triangles between points of a convex surface lie inside the surface. The surface is then drawn too small, and specular
/// highlights move toward its centre, by a twelfth of a pixel on a distant sphere of 384 patches. Moving vertices outwards by the
/// mean gap costs nothing and removes the shift. A patch with sides `h` and curvatures `k` is on average `Σ k h² / 12` above its
/// triangles. The gap is two thirds of the sum of the sagittas `k h² / 8` of its sides. The mean over the edges of a vertex halves
/// that sum.
fn mean_gap(along: Vec3, normals: [Vec3; 2]) -> f32 {
    let sagitta = along.dot(normals[1] - normals[0]) / 8.0;
    4.0 / 3.0 * sagitta
}

/// Returns the number of segments that fractional odd spacing gives for a factor.
fn odd_ceil(factor: f32) -> u32 {
    let n = factor.ceil() as u32;
    n | 1
}

/// Returns the side planes and the near plane of the frustum, with normals that point inwards. The side planes are `band` times as
/// far out as the border of the image. Depth is reversed, so the near plane is `z ≤ w`, and the far plane is at infinity.
fn frustum_planes(clip_from_world: Mat4, band: f32) -> [Vec4; 5] {
    let rows = clip_from_world.transpose();
    let (x, y, z, w) = (rows.x_axis, rows.y_axis, rows.z_axis, rows.w_axis);
    let (x, y) = (x / band, y / band);
    [w + x, w - x, w + y, w - y, w - z].map(|plane| plane / plane.truncate().length().max(1e-20))
}

type Corners = [(Vec3, Vec3); 4];

/// The position of a patch relative to a frustum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Inside {
    Wholly,
    Partly,
    Outside,
}

/// Returns an upper bound on the distance between a patch and the chords between its corners. The bound adds the offset of the
/// control points, once for each parameter, and the height of the bumps. For flat triangles, the bound is loose.
fn reach(corners: &Corners, range: [f32; 2]) -> f32 {
    let bulge = (0..4).map(|i| {
        let ((a, normal_a), (b, normal_b)) = (corners[i], corners[(i + 1) & 3]);
        let third = (b - a) / 3.0;
        third.dot(normal_a).abs().max(third.dot(normal_b).abs())
    });
    2.0 * bulge.fold(0.0, f32::max) + range[0].abs().max(range[1].abs())
}

fn classify_in_view(planes: &[Vec4; 5], corners: &Corners, reach: f32) -> Inside {
    let mut found = Inside::Wholly;
    for plane in planes {
        let distances = corners.map(|(position, _)| plane.dot(position.extend(1.0)));
        if distances.iter().all(|&d| d < -reach) {
            return Inside::Outside;
        }
        if distances.iter().any(|&d| d < reach) {
            found = Inside::Partly;
        }
    }
    found
}

/// Whether a patch is so far beyond the horizon that even its highest bump is hidden.
fn faces_away(viewer: Viewer, corners: &Corners, range: [f32; 2]) -> bool {
    let edge = corners[0].0.distance(corners[2].0).max(corners[1].0.distance(corners[3].0)).max(1e-12);
    let spread = (0..4).map(|i| corners[i].1.distance(corners[(i + 1) & 3].1)).fold(0.25f32, f32::max);
    // On a sphere of radius R, a bump of height h is visible up to the angle acos(R / (R + h)) beyond the horizon.
    let radius = edge / spread;
    let cosine = radius / (radius + (range[1] - range[0]).max(0.0));
    let margin = (1.0 - cosine * cosine).sqrt() + 0.1 + 0.5 * spread;
    corners.iter().all(|&(position, normal)| normal.dot(viewer.toward(position)) < -margin)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(n: u32) -> PatchMesh {
        let mut mesh = PatchMesh::default();
        for j in 0..=n {
            for i in 0..=n {
                mesh.positions.push(Vec3::new(i as f32 - n as f32 / 2.0, j as f32 - n as f32 / 2.0, 0.0));
                mesh.normals.push(Vec3::Z);
            }
        }
        for j in 0..n {
            for i in 0..n {
                let v = j * (n + 1) + i;
                mesh.patches.push([v, v + 1, v + n + 2, v + n + 1]);
            }
        }
        mesh
    }

    /// Returns a mesh in its rest pose, without relief.
    fn at_rest<'a>(mesh: &'a PatchMesh, topology: &'a Topology) -> PosedMesh<'a> {
        PosedMesh {
            mesh,
            topology,
            positions: &mesh.positions,
            normals: &mesh.normals,
            edge_texels: &[],
            edge_relief: &[],
            height_range: &[],
            height_scale: 1.0,
        }
    }

    fn list(mesh: &PatchMesh, eye: Vec3, target: Vec3, settings: &TessellationSettings) -> (Division, DrawList) {
        let topology = Topology::new(&mesh.patches);
        let clip = glam::camera::rh::proj::vulkan::perspective_infinite_reverse(0.8, 1.0, 0.01)
            * glam::camera::rh::view::look_at_mat4(eye, target, Vec3::Y);
        let relief = vec![1.0; topology.edges.len()];
        let posed = PosedMesh { edge_texels: &[40.0], edge_relief: &relief, ..at_rest(mesh, &topology) };
        let division = Division::new(posed, Lens { eye, focal_pixels: 1000.0, near: 0.01 }, settings);
        let list = DrawList::new(posed, &division.edge_factors, clip, Viewer::At(eye), settings);
        (division, list)
    }

    #[test]
    fn spacing_follows_the_target() {
        let mesh = grid(1);
        let (list, _) = list(&mesh, Vec3::Z * 100.0, Vec3::ZERO, &TessellationSettings::default());
        // At distance 100, one unit is 10 pixels, and 4 pixels per triangle space vertices sqrt(8) pixels apart. In a view from
        // above, bumps of 10 pixels increase the screen length by sqrt(1 + 0.09).
        for factor in &list.edge_factors {
            assert!((factor - 10.0 * 1.09f32.sqrt() / 8f32.sqrt()).abs() < 0.06, "{factor}");
        }
    }

    #[test]
    fn flat_edges_are_not_divided_and_edges_seen_end_on_less() {
        let lens = Lens { eye: Vec3::X * 100.0, focal_pixels: 1000.0, near: 0.01 };
        let edge = |direction: Vec3, relief: f32| edge_pixels(&lens, [-direction, direction], [Vec3::Z; 2], relief);
        assert_eq!(edge(Vec3::Y, 0.0), 0.0);
        assert!(edge(Vec3::X, 1.0) < 0.35 * edge(Vec3::Y, 1.0));
        assert!(edge(Vec3::Y, 0.05) < edge(Vec3::Y, 0.1));
    }

    #[test]
    fn triangles_of_a_lifted_sphere_lie_about_it() {
        // The mesh is a section of a sphere. Each patch spans a tenth of a radian.
        let mut mesh = grid(16);
        mesh.normals = mesh.positions.iter().map(|p| (p.truncate() * 0.1).extend(1.0).normalize()).collect();
        let topology = Topology::new(&mesh.patches);
        let mut lifts = |radius: f32, distance: f32| {
            mesh.positions = mesh.normals.iter().map(|n| *n * radius).collect();
            let posed = PosedMesh { height_scale: 0.0, ..at_rest(&mesh, &topology) };
            let lens = Lens { eye: Vec3::Z * distance, focal_pixels: 1000.0, near: 0.01 };
            let list = Division::new(posed, lens, &TessellationSettings::default());
            assert_eq!(list.edge_factors.iter().all(|f| *f == 1.0), distance > 10.0);
            list.vertex_lifts
        };
        // All distant edges have a single segment. The mean radius is taken over the centres of small sub-triangles.
        let (far, near, hollow) = (lifts(1.0, 50.0), lifts(1.0, 2.0), lifts(-1.0, 50.0));
        let mean_radius = |lift: &dyn Fn(usize) -> f32| {
            let (mut sum, mut area) = (0.0, 0.0);
            for patch in &mesh.patches {
                let corner = patch.map(|v| mesh.normals[v as usize] * (1.0 + lift(v as usize)));
                for [a, b, c] in [[0, 1, 2], [0, 2, 3]].map(|triangle: [usize; 3]| triangle.map(|i| corner[i])) {
                    let size = f64::from((b - a).cross(c - a).length());
                    for (i, j) in (0..16).flat_map(|i| (0..16 - i).map(move |j| (i, j))) {
                        let (s, t) = ((i as f32 + 1.0 / 3.0) / 16.0, (j as f32 + 1.0 / 3.0) / 16.0);
                        sum += size * f64::from((a + (b - a) * s + (c - a) * t).length());
                        area += size;
                    }
                }
            }
            sum / area - 1.0
        };
        let (flat, lifted) = (mean_radius(&|_| 0.0), mean_radius(&|v| far[v]));
        assert!(flat < -1e-3 && lifted.abs() < 0.1 * -flat, "{flat} {lifted}");
        assert!(near.iter().zip(&far).all(|(near, far)| (0.0..*far).contains(near)));
        assert!(hollow.iter().zip(&far).all(|(hollow, far)| (hollow + far).abs() < 1e-6));
    }

    #[test]
    fn every_texel_can_have_its_vertex() {
        let settings = TessellationSettings { to_texels: true, ..Default::default() };
        let (list, _) = list(&grid(1), Vec3::Z * 100.0, Vec3::ZERO, &settings);
        assert_eq!(list.edge_factors[0], 40.0);
    }

    #[test]
    fn flat_surfaces_have_no_vertices_for_their_texels() {
        let mesh = grid(1);
        let topology = Topology::new(&mesh.patches);
        let factor = |height_scale| {
            let posed = PosedMesh {
                edge_texels: &[40.0; 4],
                edge_relief: &[1.0; 4],
                height_scale,
                ..at_rest(&mesh, &topology)
            };
            let lens = Lens { eye: Vec3::Z * 100.0, focal_pixels: 1000.0, near: 0.01 };
            let settings = TessellationSettings { to_texels: true, ..Default::default() };
            Division::new(posed, lens, &settings).edge_factors[0]
        };
        assert_eq!((factor(1.0), factor(-1.0), factor(0.0)), (40.0, 40.0, 1.0));
    }

    #[test]
    fn pixels_bound_the_vertices_of_texels() {
        // At 99.5, its nearest possible distance, one unit covers 10.05 pixels.
        let few = |vertices_per_pixel| {
            let settings = TessellationSettings { to_texels: true, vertices_per_pixel, ..Default::default() };
            list(&grid(1), Vec3::Z * 100.0, Vec3::ZERO, &settings).0.edge_factors[0]
        };
        assert!((few(2.0) - 20.1).abs() < 0.2, "{}", few(2.0));
        assert_eq!(few(f32::INFINITY), 40.0);
    }

    #[test]
    fn coarser_division_keeps_its_distance() {
        let mesh = grid(2);
        let topology = Topology::new(&mesh.patches);
        let posed = PosedMesh { edge_relief: &vec![1.0; topology.edges.len()], ..at_rest(&mesh, &topology) };
        let lens = Lens { eye: Vec3::new(0.8, 0.0, 2.0), focal_pixels: 100.0, near: 0.01 };
        let finer = Division::new(posed, lens, &TessellationSettings::default());
        let (least, most) = finer.edge_factors.iter().fold((f32::MAX, 0.0f32), |(a, b), &f| (a.min(f), b.max(f)));
        assert!(least > 2.0 && most > 1.2 * least, "{least} {most}");
        // Edges are one unit long.
        let middle = 0.5 * (least + most);
        let coarser = finer.with_min_spacing(1.0 / middle, posed).unwrap();
        for (i, (coarse, fine)) in coarser.edge_factors.iter().zip(&finer.edge_factors).enumerate() {
            assert_eq!(*coarse, fine.min(middle), "{i}");
        }
        assert!(coarser.vertex_lods.iter().zip(&finer.vertex_lods).all(|(coarse, fine)| coarse >= fine));
        assert!(finer.with_min_spacing(0.99 / most, posed).is_none());
        assert!(finer.with_min_spacing(10.0, posed).unwrap().edge_factors.iter().all(|factor| *factor == 1.0));
    }

    #[test]
    fn patches_that_face_away_from_a_sun_are_dropped() {
        let mesh = grid(4);
        let topology = Topology::new(&mesh.patches);
        let posed = at_rest(&mesh, &topology);
        let factors = vec![1.0; topology.edges.len()];
        let seen = |sun: Vec3| {
            let viewer = Viewer::Toward(sun.normalize());
            DrawList::new(posed, &factors, Mat4::from_scale(Vec3::splat(0.1)), viewer, &Default::default())
                .visible
                .len()
        };
        assert_eq!(seen(Vec3::new(1.0, 0.0, 0.5)), 16);
        assert_eq!(seen(Vec3::new(1.0, 0.0, -0.9)), 0);
    }

    #[test]
    fn hidden_patches_are_dropped() {
        let mesh = grid(8);
        let settings = TessellationSettings::default();
        assert_eq!(list(&mesh, Vec3::Z * 30.0, Vec3::ZERO, &settings).1.visible.len(), 64);
        assert_eq!(list(&mesh, Vec3::Z * 30.0, Vec3::Z * 60.0, &settings).1.visible.len(), 0, "behind the camera");
        assert_eq!(list(&mesh, Vec3::Z * -30.0, Vec3::ZERO, &settings).1.visible.len(), 0, "from below");
        let near = list(&mesh, Vec3::Z * 1.5, Vec3::ZERO, &settings).1.visible.len();
        assert!((4..64).contains(&near), "{near}");
        let all = TessellationSettings { cull: false, ..settings };
        assert_eq!(list(&mesh, Vec3::Z * -30.0, Vec3::ZERO, &all).1.visible.len(), 64);
    }

    #[test]
    fn draws_stay_under_the_vertex_limit_and_cover_everything() {
        let mesh = grid(16);
        let settings = TessellationSettings { max_vertices_per_draw: 65_536, ..Default::default() };
        let (_, list) = list(&mesh, Vec3::Z * 12.0, Vec3::ZERO, &settings);
        assert!(list.draws.all().count() > 1);
        let mut next = 0;
        for (first, count) in list.draws.all() {
            assert_eq!(first, next);
            assert!(count > 0);
            next += count;
        }
        assert_eq!(next as usize, list.visible.len());
    }
}
