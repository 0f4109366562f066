//! What a scene hands to the renderer: objects made once, and the state of one frame.

use super::camera::Camera;
use super::light::exposure;
use super::light::sky::Sky;
use super::surfaces::displacement::HeightField;
use super::surfaces::patch_mesh::{PatchMesh, PosedVertices};
use super::surfaces::skinning;
use glam::{Affine3A, Mat4, Vec3};

/// An sRGB colour map with roughness.
#[derive(Clone, Debug)]
pub struct ColorMap {
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// sRGB-encoded albedo in rgb, Beckmann roughness `α` (linear) in a.
    pub texels: Vec<[u8; 4]>,
}

/// One displaced (or smooth) surface.
#[derive(Clone, Debug)]
pub struct Object {
    /// For messages and debug names.
    pub name: String,
    /// Its patches.
    pub mesh: PatchMesh,
    /// Heights along the patch normals; none for a smooth surface.
    pub heights: Option<HeightField>,
    /// Height scale `η` at load; a frame may override it.
    pub height_scale: f32,
    /// Albedo and roughness; without it the vertex colours are used.
    pub color_map: Option<ColorMap>,
    /// Reflectance at normal incidence; below 0.02 it fades at all angles, and with 0 nothing is reflected.
    pub specular_f0: f32,
    /// Whether it throws a shadow.
    pub casts_shadow: bool,
}

/// Where an object is in one frame.
#[derive(Clone, Debug)]
pub enum Pose {
    /// Rigid: world from rest.
    Rigid(Affine3A),
    /// Linear blend skinning: world from rest, one matrix per joint.
    Skinned(Vec<Mat4>),
}

/// A directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit direction toward the sun.
    pub direction: Vec3,
    /// Irradiance on a plane facing it, linear rgb.
    pub irradiance: Vec3,
}

impl Sun {
    /// The sun of a sky, through its air.
    #[must_use]
    pub fn of(sky: &Sky) -> Self {
        let direction = sky.sun_direction.normalize_or(Vec3::Z);
        Self { direction, irradiance: Vec3::from_array(sky.sun_irradiance()) }
    }
}

/// A point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// World position.
    pub position: Vec3,
    /// Radiant intensity, linear rgb: irradiance at distance 1.
    pub intensity: Vec3,
}

/// Number of point lights a frame may have.
pub const MAX_POINT_LIGHTS: usize = 4;

/// The state of one frame.
#[derive(Clone, Debug)]
pub struct FrameState {
    /// Moment of the waves, seconds.
    pub time: f64,
    /// The viewer.
    pub camera: Camera,
    /// One pose per object of the scene.
    pub poses: Vec<Pose>,
    /// The sky, when the environment is one; the cube follows it.
    pub sky: Option<Sky>,
    /// Directional light, if any.
    pub sun: Option<Sun>,
    /// Point lights, at most [`MAX_POINT_LIGHTS`].
    pub point_lights: Vec<PointLight>,
    /// Multiplies the height scale of every object.
    pub height_scale: f32,
}

impl FrameState {
    /// Factor on the radiance of a picture that is looked at: what the sky's sun asks for, 1 under another light.
    #[must_use]
    pub fn exposure(&self) -> f32 {
        self.sky.as_ref().map_or(1.0, exposure::exposure)
    }
}

impl Pose {
    /// Poses a mesh. Joints beyond the pose's own are ignored.
    #[must_use]
    pub fn apply(&self, mesh: &PatchMesh) -> PosedVertices {
        match self {
            Self::Rigid(world) => {
                let normal_matrix = world.matrix3.inverse().transpose();
                PosedVertices {
                    positions: mesh.positions.iter().map(|&p| world.transform_point3(p)).collect(),
                    normals: mesh.normals.iter().map(|&n| (normal_matrix * n).normalize_or(Vec3::Z)).collect(),
                }
            }
            Self::Skinned(joints) => skinning::skin(mesh, joints),
        }
    }
}
