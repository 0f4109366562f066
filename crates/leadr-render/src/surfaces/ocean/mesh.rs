//! The mesh of the sea, with rings of tessellated patches around the viewer, from the feet to beyond the horizon.

use std::f32::consts::TAU;

use glam::{Mat4, Vec2, Vec3};

use crate::surfaces::patch_mesh::PatchMesh;
use crate::surfaces::tessellation::{DrawList, Lens, MAX_FACTOR, PosedMesh, TessellationSettings, Viewer};
use crate::surfaces::topology::Topology;

/// The radius of the Earth in metres, enlarged to include standard atmospheric refraction.
pub const EARTH: f32 = 6.371e6 * 7.0 / 6.0;
/// The number of patches in a ring.
pub const SPOKES: u32 = 48;
/// The number of rings.
pub const RINGS: u32 = 96;
/// The height of the highest crests above the rest level, in standard deviations, which determines the outer radius of the rings.
const CREST: f32 = 4.0;
/// The largest displacement by waves, in standard deviations of the height. Culling uses this value.
const REACH: f32 = 6.0;
/// The wave slope that is assumed for patches seen from the side.
const WAVE_SLOPE: f32 = 0.1;
/// The wave height in pixels (two standard deviations) up to which only the slope moments represent the waves. From [`FULL_RELIEF`]
/// on, the geometry shows the waves in full.
const LEAST_RELIEF: f32 = 0.25;
const FULL_RELIEF: f32 = 1.0;
/// The largest deviation of straight triangle edges from the curved water surface, in pixels.
const CURVE_ERROR: f32 = 0.05;

/// The view from which the sea is drawn.
#[derive(Clone, Copy, Debug)]
pub struct SeaView {
    /// The transform from world to clip space.
    pub clip_from_world: Mat4,
    /// The scale from lengths to pixels.
    pub lens: Lens,
    /// The height of the water at rest, in metres.
    pub level: f32,
    /// The standard deviation of the height of the waves, in metres.
    pub deviation: f32,
}

/// The patches and how they are connected, independent of the view.
#[derive(Clone, Debug)]
pub struct Rings {
    /// The mesh, whose positions hold a direction in xy and the ring number in z (0 is the centre).
    pub mesh: PatchMesh,
    /// The edges of the mesh.
    pub topology: Topology,
}

/// The rings around one viewpoint.
#[derive(Clone, Debug, Default)]
pub struct RingLayout {
    /// The world positions of the mesh vertices at the rest level of the water, in metres.
    pub positions: Vec<Vec3>,
    /// The largest distance between tessellated vertices along the edges at each mesh vertex, in metres.
    pub spacing: Vec<f32>,
    /// The tessellation factor of each edge.
    pub factors: Vec<f32>,
    /// The visible patches and their draws.
    pub list: DrawList,
}

impl Default for Rings {
    fn default() -> Self {
        let mut mesh = PatchMesh::default();
        for ring in 0..=RINGS {
            for spoke in 0..SPOKES {
                let (sin, cos) = (TAU * spoke as f32 / SPOKES as f32).sin_cos();
                mesh.positions.push(Vec3::new(cos, sin, ring as f32));
                mesh.normals.push(Vec3::Z);
            }
        }
        for ring in 0..RINGS {
            for spoke in 0..SPOKES {
                let next = (spoke + 1) % SPOKES;
                let at = |ring: u32, spoke: u32| ring * SPOKES + spoke;
                mesh.patches.push([at(ring, spoke), at(ring + 1, spoke), at(ring + 1, next), at(ring, next)]);
            }
        }
        let topology = Topology::new(&mesh.patches);
        Self { mesh, topology }
    }
}

impl Rings {
    /// Places the rings around a viewer, with uniform spacing in the logarithm of the distance, and selects the patches to draw.
    /// Positions and tessellation factors depend smoothly on the position of the viewer, so nothing pops. Rotating the camera only
    /// changes which patches are culled.
    pub fn layout(&self, view: &SeaView, settings: &TessellationSettings) -> RingLayout {
        let SeaView { lens, level, deviation, .. } = *view;
        let height = (lens.eye.z - level).abs().max(0.5);
        let (first, last) = (0.2 * height, farthest(height, deviation));
        let radius = |ring: f32| {
            if ring <= 0.0 { 0.0 } else { first * (last / first).powf((ring - 1.0) / (RINGS as f32 - 1.0)) }
        };
        let positions: Vec<Vec3> = self
            .mesh
            .positions
            .iter()
            .map(|p| {
                let away = Vec2::new(p.x, p.y) * radius(p.z);
                (lens.eye.truncate() + away).extend(level - away.length_squared() / (2.0 * EARTH))
            })
            .collect();
        let factors = self.topology.edges.iter().map(|edge| {
            let ends = edge.map(|v| positions[v as usize]);
            edge_factor(&lens, ends, deviation, settings)
        });
        let factors: Vec<f32> = factors.collect();
        let mut spacing = vec![0.0f32; positions.len()];
        for (&[a, b], &factor) in self.topology.edges.iter().zip(&factors) {
            let apart = positions[a as usize].distance(positions[b as usize]) / factor;
            for vertex in [a, b] {
                spacing[vertex as usize] = spacing[vertex as usize].max(apart);
            }
        }
        let reach = REACH * deviation;
        let posed = PosedMesh {
            mesh: &self.mesh,
            topology: &self.topology,
            positions: &positions,
            normals: &self.mesh.normals,
            edge_texels: &[],
            edge_relief: &[],
            height_range: &vec![[-reach, reach]; self.mesh.patches.len()],
            height_scale: 1.0,
        };
        let list = DrawList::new(posed, &factors, view.clip_from_world, Viewer::At(lens.eye), settings);
        RingLayout { positions, spacing, factors, list }
    }
}

/// Returns the outer radius of the rings in metres, which is the distance of the farthest crest that is visible from `height`
/// beyond the horizon.
fn farthest(height: f32, deviation: f32) -> f32 {
    (2.0 * EARTH * height).sqrt() + (2.0 * EARTH * CREST * deviation).sqrt()
}

/// Returns the tessellation factor of an edge. The factor follows the screen length of the edge if the waves are large enough in
/// pixels, and always resolves the curvature of the Earth.
fn edge_factor(lens: &Lens, [a, b]: [Vec3; 2], deviation: f32, settings: &TessellationSettings) -> f32 {
    let (centre, along) = ((a + b) * 0.5, b - a);
    let length = along.length();
    let scale = lens.pixels(centre, length) / length.max(1e-20);
    let sine = along.cross(Viewer::At(lens.eye).toward(centre)).length() / length.max(1e-20);
    let relief = 2.0 * deviation * scale;
    // Reference images tessellate all waves as densely as the settings allow.
    let (shown, slope) = match settings.to_texels {
        true => (1.0, 1.0),
        false => (((relief - LEAST_RELIEF) / (FULL_RELIEF - LEAST_RELIEF)).clamp(0.0, 1.0), WAVE_SLOPE),
    };
    // Two triangles of area A fill a square cell with the side sqrt(2A).
    let side = (2.0 * settings.pixels_per_triangle).sqrt();
    let waves = length * scale * sine.hypot(slope) * shown / side;
    let bulge = length * length * scale / (8.0 * EARTH);
    waves.max((bulge / CURVE_ERROR).sqrt()).clamp(1.0, settings.max_factor.clamp(1.0, MAX_FACTOR))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;

    #[test]
    fn rings_face_up_and_meet() {
        let Rings { mesh, topology } = Rings::default();
        assert_eq!(mesh.patches.len(), (RINGS * SPOKES) as usize);
        for patch in mesh.patches.iter().skip(SPOKES as usize) {
            let p = patch.map(|v| {
                let p = mesh.positions[v as usize];
                Vec2::new(p.x, p.y) * p.z
            });
            assert!((p[2] - p[0]).perp_dot(p[3] - p[1]) > 0.0);
        }
        // The open edges are at the outermost ring and at the innermost ring, which is a single point.
        assert_eq!(topology.irregular_edges(), 2 * SPOKES as usize);
    }

    const SIZE: (u32, u32) = (1280, 720);
    const DEVIATION: f32 = 0.45;

    /// Lays out the rings for a camera at `height` metres. The camera looks below the horizon by an angle whose tangent is `down`.
    fn laid(height: f32, down: f32, settings: &TessellationSettings) -> (RingLayout, Camera) {
        let eye = Vec3::new(300.0, -70.0, height);
        let camera = Camera::looking_at(eye, eye + Vec3::new(1.0, 0.2, -down).normalize() * height, 45.0);
        let (clip_from_world, lens) = (camera.clip_from_world(SIZE, Vec2::ZERO), camera.lens(SIZE.1));
        let view = SeaView { clip_from_world, lens, level: 0.0, deviation: DEVIATION };
        (Rings::default().layout(&view, settings), camera)
    }

    /// Returns the number of pixels that water covers.
    fn covered(camera: &Camera) -> f64 {
        let [x, y, z] = camera.rays(SIZE, Vec2::ZERO);
        let dip = -(2.0 * camera.position.z / EARTH).sqrt();
        let ndc = |i: u32, n: u32| (i as f32 + 0.5) / n as f32 * 2.0 - 1.0;
        let below = |i: u32, j: u32| {
            let ray = z + x * ndc(i, SIZE.0) + y * ndc(j, SIZE.1);
            ray.z < dip * ray.truncate().length()
        };
        (0..SIZE.1).flat_map(|j| (0..SIZE.0).map(move |i| (i, j))).filter(|&(i, j)| below(i, j)).count() as f64
    }

    #[test]
    fn triangles_are_spent_where_waves_show() {
        let rings = Rings::default();
        let odd = |factor: f32| u64::from(factor.ceil() as u32 | 1);
        for (height, down, most, most_patches) in
            [(2.5, 0.1, 2.5, 2000), (100.0, 0.25, 0.5, 900), (1000.0, 0.35, 0.04, 900), (5000.0, 0.35, 0.01, 900)]
        {
            let (laid, camera) = laid(height, down, &TessellationSettings::default());
            // The bins count the triangles up to 300 m, up to 3 km, up to 30 km, and beyond.
            let mut bins = [0u64; 4];
            for &patch in &laid.list.visible {
                let corner = laid.positions[rings.mesh.patches[patch as usize][0] as usize];
                let sides = rings.topology.patch_edges[patch as usize];
                let [a, b, c, d] = sides.map(|e| laid.factors[(e >> 1) as usize]);
                let bin = (corner.distance(camera.position) / 300.0).log10().ceil().clamp(0.0, 3.0) as usize;
                bins[bin] += 2 * odd(a.max(c)) * odd(b.max(d));
            }
            let share = bins.iter().sum::<u64>() as f64 / covered(&camera);
            let patches = laid.list.visible.len();
            println!("{height} m: {patches} patches, {share:.4} triangles per pixel of water; by distance {bins:?}");
            assert!(
                patches <= most_patches && share < most,
                "{height} m: {patches} patches, {share} triangles per pixel"
            );
        }
    }

    #[test]
    fn the_mesh_follows_the_viewer_smoothly_and_does_not_rotate() {
        let at = |eye: Vec3, forward: Vec3| {
            let camera = Camera::looking_at(eye, eye + forward, 45.0);
            let (clip_from_world, lens) = (camera.clip_from_world(SIZE, Vec2::ZERO), camera.lens(SIZE.1));
            Rings::default().layout(
                &SeaView { clip_from_world, lens, level: 0.0, deviation: DEVIATION },
                &TessellationSettings::default(),
            )
        };
        for height in [2.5f32, 30.0, 400.0] {
            let eye = Vec3::new(3.0, 4.0, height);
            let (a, rotated) = (at(eye, Vec3::X), at(eye, Vec3::new(-0.3, 0.8, -0.4)));
            assert_eq!((&a.positions, &a.factors), (&rotated.positions, &rotated.factors));
            for step in [Vec3::X, Vec3::Z] {
                let b = at(eye + step * (1e-3 * height), Vec3::X);
                let change = |(a, b): (&f32, &f32)| (a / b - 1.0).abs();
                let worst = a.factors.iter().zip(&b.factors).map(change).fold(0.0, f32::max);
                let spacing = a.spacing.iter().zip(&b.spacing).map(change).fold(0.0, f32::max);
                println!("{height} m, a thousandth along {step}: factors {worst:.5}, spacing {spacing:.5}");
                assert!(worst < 0.02 && spacing < 0.02, "{height} m: {worst} {spacing}");
            }
        }
    }
}
