//! Surfaces that deform while their LEADR maps stay the same (LEADR section 4.2, eq. 12 and Figure 5): a quad, a sphere and a cylinder are
//! stretched, sheared or flattened.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use glam::{Affine3A, Mat3, Mat4, Vec3};

use super::plane::{even, plane};
use super::sphere::{bake_tiles, cube_sphere, tiled};
use super::stage::{Stage, Views};
use leadr_maps::procedural;
use leadr_render::camera::Camera;
use leadr_render::scene::{FrameState, Object, Pose};
use leadr_render::surfaces::displacement::HeightField;
use leadr_render::surfaces::patch_mesh::PatchMesh;
use leadr_render::surfaces::triplanar;

/// A deformation of the stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deformation {
    /// Stretches sideways and compresses vertically by the same factor, up to [`STRETCH`]. Slopes flatten along one direction and steepen
    /// along another.
    Stretch,
    /// Shears the surface by up to [`SHEAR`] of its height.
    Shear,
    /// Lowers the bumps until the surface is smooth.
    HeightScale,
}

/// The duration of one deformation and its reversal, in seconds.
pub const PERIOD: f64 = 6.0;
/// The maximum factor of [`Deformation::Stretch`].
pub const STRETCH: f32 = 1.8;
/// The maximum factor of [`Deformation::Shear`].
pub const SHEAR: f32 = 0.9;

/// Returns the progress of the deformation at `time` seconds, which rises from 0 to 1 and falls back to 0.
pub fn progress(time: f64) -> f32 {
    (0.5 - 0.5 * (TAU * time / PERIOD).cos()) as f32
}

impl Deformation {
    /// Returns the linear map at a `progress` from 0 to 1. The x axis points sideways and z points up.
    #[must_use]
    pub fn map(self, progress: f32) -> Mat3 {
        match self {
            Self::Stretch => stretching(STRETCH.powf(progress)),
            Self::Shear => Mat3::from_cols(Vec3::X, Vec3::Y, Vec3::new(SHEAR * progress, 0.0, 1.0)),
            Self::HeightScale => Mat3::IDENTITY,
        }
    }

    /// Returns the factor on the displacement at `progress`.
    pub fn relief(self, progress: f32) -> f32 {
        if self == Self::HeightScale { (1.0 - progress).max(0.0) } else { 1.0 }
    }

    /// Returns linear albedo with roughness, and reflectance at normal incidence.
    fn material(self) -> ([f32; 4], f32) {
        match self {
            Self::Stretch => ([0.55, 0.32, 0.14, 0.12], 0.6),
            Self::Shear => ([0.42, 0.55, 0.5, 0.8], 0.03),
            Self::HeightScale => ([0.28, 0.36, 0.5, 0.06], 0.7),
        }
    }
}

/// The valid stretch factors.
pub const FACTORS: RangeInclusive<f32> = 0.2..=5.0;

/// Stretches sideways by `factor`, and compresses vertically by the same factor.
fn stretching(factor: f32) -> Mat3 {
    Mat3::from_diagonal(Vec3::new(factor, 1.0, 1.0 / factor))
}

/// Stretches all objects and lamps of a frame along x by `factor`, above 0, and compresses them along z by the same factor. The anchor does
/// not move.
pub fn stretch(state: &mut FrameState, factor: f32) {
    if factor == 1.0 {
        return;
    }
    let (linear, about) = (stretching(factor), state.anchor);
    let map = Affine3A::from_mat3_translation(linear, about - linear * about);
    let normal_map = linear.inverse();
    for pose in &mut state.poses {
        match pose {
            Pose::Rigid(world) => *world = map * *world,
            Pose::Skinned(joints) => joints.iter_mut().for_each(|joint| *joint = Mat4::from(map) * *joint),
            Pose::Vertices(vertices) => {
                vertices.positions.iter_mut().for_each(|p| *p = map.transform_point3(*p));
                for normal in vertices.normals.iter_mut().chain(&mut vertices.directions) {
                    *normal = (normal_map * *normal).normalize_or_zero();
                }
            }
        }
    }
    state.point_lights.iter_mut().for_each(|lamp| lamp.position = map.transform_point3(lamp.position));
}

/// Half the side of the quad, the radius of the sphere and half the height of the cylinder, in metres.
const HALF: f32 = 1.0;
/// Height on which the undeformed and the deformed objects stand, metres.
pub const FLOOR: f32 = -HALF;
/// Width of one repeat of the map on the surface, metres.
const REPEAT: f32 = 2.0;
const TEXELS: u32 = 512;

/// Returns Gaussian bumps that are about 9 cm wide and whose slopes have a standard deviation of 0.45.
fn bumps() -> HeightField {
    let mut map = procedural::gaussian(TEXELS, TEXELS, 11, 0.45, 1.0 / 64.0);
    map.texels.iter_mut().for_each(|h| *h *= REPEAT);
    HeightField::repeating(map)
}

/// Returns a cylinder of radius 0.7 around the z axis, with rounded rims.
fn cylinder(n: u32, color: [f32; 4]) -> PatchMesh {
    const RADIUS: f32 = 0.7;
    const EXPONENT: f32 = 9.0;
    let mut mesh = cube_sphere(n, color);
    for (p, normal) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
        // The edges of the cube are moved to the rims of the cylinder: |r / R|ᵉ + |z / H|ᵉ = 1.
        let side = Vec3::new(p.x, p.y, 0.0);
        let (r, z) = (side.length(), p.z * HALF / RADIUS);
        let (a, b) = (r / RADIUS, z.abs() / HALF);
        let scale = (a.powf(EXPONENT) + b.powf(EXPONENT)).powf(-1.0 / EXPONENT);
        *p = (side + Vec3::Z * z) * scale;
        let out = side.normalize_or_zero() * ((a * scale).powf(EXPONENT - 1.0) / RADIUS);
        *normal = (out + Vec3::Z * (z.signum() * (b * scale).powf(EXPONENT - 1.0) / HALF)).normalize();
    }
    mesh
}

/// Builds the stage with quad, sphere and cylinder from left to right.
pub fn stage(deformation: Deformation) -> Stage {
    let (color, specular_f0) = deformation.material();
    let map = bumps();
    let object = |name: &str, mesh: PatchMesh, heights: HeightField| {
        Object::new(name, mesh).with_heights(heights, 1.0).with_specular_f0(specular_f0)
    };
    let closed = |name: &str, mut mesh: PatchMesh| {
        let (layout, texels) =
            bake_tiles(&mut mesh, 64, |p, n| triplanar::blend(p, n, REPEAT, 0.0, |texcoord| map.bicubic(texcoord)));
        object(name, mesh, tiled(layout, texels))
    };
    let quad = object("quad", plane(HALF, 8, REPEAT, color, even), map.clone());
    let objects = vec![quad, closed("sphere", cube_sphere(6, color)), closed("cylinder", cylinder(10, color))];

    let motion = move |time: f64| {
        let map = deformation.map(progress(time));
        // Stretched objects stay on the floor and do not touch their neighbours.
        let room = 1.25 * (map * Vec3::X).length().max(1.0) * HALF + 0.1 + 0.5 * (map * Vec3::Z).x.abs();
        let upright = Mat3::from_rotation_x(80f32.to_radians());
        let pose_at = |x: f32, linear: Mat3| {
            let stand = Vec3::new(x * room * 2.0, 0.0, FLOOR - FLOOR * (map * Vec3::Z).z);
            Pose::Rigid(Affine3A::from_mat3_translation(map * linear, stand))
        };
        vec![pose_at(-1.0, upright), pose_at(0.0, Mat3::IDENTITY), pose_at(1.0, Mat3::IDENTITY)]
    };
    let from = |distance: f32, up: f32| {
        Camera::looking_at(Vec3::new(0.05, -1.0, up).normalize() * distance, Vec3::new(0.0, 0.0, -0.05), 26.0)
    };
    let views = Views { near: from(5.0, 0.24), mid: from(12.5, 0.18), far: from(48.0, 0.13) };
    Stage::moving(objects, views, motion, |_| Vec3::ZERO).with_relief(move |time| deformation.relief(progress(time)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_render::scene::PointLight;
    use leadr_render::surfaces::patch_mesh::PosedVertices;
    use leadr_render::surfaces::topology::Topology;

    /// Vertices and normals move consistently in every pose. Two stretches by the square root of a factor equal one stretch by the factor.
    #[test]
    fn frames_stretch_about_their_anchor() {
        let mesh = cube_sphere(2, [1.0; 4]);
        let rotated = Affine3A::from_rotation_y(0.4) * Affine3A::from_translation(Vec3::new(2.0, 0.0, 1.0));
        let posed = Pose::Rigid(rotated).apply(&mesh);
        let camera = Camera::looking_at(Vec3::X, Vec3::ZERO, 30.0);
        let mut state = FrameState::new(camera, vec![Pose::Rigid(rotated), Pose::Vertices(posed.clone())]);
        state.anchor = Vec3::new(5.0, 1.0, 0.5);
        state.point_lights = vec![PointLight::new(Vec3::new(6.0, 2.0, 2.5), Vec3::ONE)];
        let mut twice = state.clone();
        stretch(&mut state, 4.0);
        stretch(&mut twice, 2.0);
        stretch(&mut twice, 2.0);
        assert!(state.point_lights[0].position.distance(Vec3::new(9.0, 2.0, 1.0)) < 1e-5);
        let [rigid, vertices] = [0, 1].map(|i| state.poses[i].apply(&mesh));
        let near = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).all(|(a, b)| a.distance(*b) < 1e-4);
        let like =
            |a: &PosedVertices, b: &PosedVertices| near(&a.positions, &b.positions) && near(&a.normals, &b.normals);
        assert!(like(&rigid, &vertices));
        assert!(like(&rigid, &twice.poses[0].apply(&mesh)) && like(&rigid, &twice.poses[1].apply(&mesh)));
        let want = |p: Vec3| Vec3::new(5.0 + 4.0 * (p.x - 5.0), p.y, 0.5 + 0.25 * (p.z - 0.5));
        let wanted: Vec<Vec3> = posed.positions.iter().map(|&p| want(p)).collect();
        assert!(near(&rigid.positions, &wanted));
        let mut same = state.clone();
        stretch(&mut same, 1.0);
        assert_eq!(same, state);
    }

    #[test]
    fn the_cylinder_is_closed_and_its_normals_are_those_of_its_surface() {
        let mesh = cylinder(10, [0.5; 4]);
        assert_eq!(Topology::new(&mesh.patches).irregular_edges(), 0);
        for patch in &mesh.patches {
            let p = patch.map(|v| mesh.positions[v as usize]);
            let flat = (p[2] - p[0]).cross(p[3] - p[1]).normalize();
            let normal: Vec3 = patch.iter().map(|&v| mesh.normals[v as usize]).sum();
            assert!(flat.dot(normal.normalize()) > 0.8, "{p:?}");
        }
    }

    #[test]
    fn deformations_begin_and_end_at_rest_and_keep_the_volume() {
        for deformation in [Deformation::Stretch, Deformation::Shear, Deformation::HeightScale] {
            for time in [0.0, PERIOD] {
                assert!(deformation.map(progress(time)).abs_diff_eq(Mat3::IDENTITY, 1e-6));
                assert!((deformation.relief(progress(time)) - 1.0).abs() < 1e-6);
            }
            assert!((deformation.map(1.0).determinant() - 1.0).abs() < 1e-6);
        }
        assert_eq!(Deformation::HeightScale.relief(progress(PERIOD / 2.0)), 0.0);
    }
}
