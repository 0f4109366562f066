//! A sphere as one cell of the supplement's tables, and the three kinds of lighting of these tables.

use glam::{Affine3A, Vec3};

use super::surface::Surface;
use crate::stage::{Lights, Stage, Views};
use crate::studio::studio;
use leadr_maps::RgbImage;
use leadr_render::camera::Camera;
use leadr_render::scene::{Object, Pose, Sun};

/// The material of the facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Facets {
    /// White facets without specular reflection.
    Diffuse,
    /// Perfect mirrors whose reflectance is 1 at every angle.
    Mirror,
}

impl Facets {
    /// Returns the value for [`Object::specular_f0`].
    pub fn specular_f0(self) -> f32 {
        match self {
            Self::Diffuse => 0.0,
            Self::Mirror => 1.0,
        }
    }
}

/// The smallest roughness that an eight-bit vertex colour can store. The surface is nearly a mirror, with a lobe 0.2° wide.
pub const MIRROR_ROUGHNESS: f32 = 1.0 / 255.0;

/// The distance of a table's camera from the centre of the unit sphere, in metres.
pub const DISTANCE: f32 = 12.0;

/// The fraction of the picture height that the smooth sphere fills in a table.
pub const FILL: f32 = 0.8;

/// The duration of one rotation of the sphere about its poles, in seconds.
pub const ROTATION_PERIOD: f64 = 20.0;

impl Surface {
    /// Builds an object from the surface. `steep` is the standard deviation of the steeper slope.
    pub fn object(&self, name: &str, steep: f32, facets: Facets) -> Object {
        let mut mesh = self.mesh.clone();
        mesh.colors = vec![[1.0, 1.0, 1.0, MIRROR_ROUGHNESS]; mesh.positions.len()];
        Object::new(name, mesh).with_heights(self.heights.clone(), steep).with_specular_f0(facets.specular_f0())
    }

    /// Builds the stage of one cell. The `height_scale` of a frame multiplies `steep`, so one upload is enough for all rows with the same
    /// slope ratio. The sphere rotates about its poles in [`ROTATION_PERIOD`] seconds. The statistics of the sphere are constant, so
    /// pictures at other times are independent.
    pub fn stage(&self, steep: f32, facets: Facets) -> Stage {
        let object = self.object("sphere", steep, facets);
        let rotation = |time: f64| {
            vec![Pose::Rigid(Affine3A::from_rotation_z((time / ROTATION_PERIOD * std::f64::consts::TAU) as f32))]
        };
        Stage::moving(vec![object], views(), rotation, |_| Vec3::ZERO)
    }
}

/// Returns three views: the view of the table (`mid`), a view of single bumps (`near`), and a view of a sphere of a few pixels (`far`).
pub fn views() -> Views {
    // The outline of a unit sphere at distance d lies at the angle asin(1 / d).
    let tangent = 1.0 / (DISTANCE * DISTANCE - 1.0).sqrt();
    let fov = 2.0 * (tangent / FILL).atan().to_degrees();
    let mid = Camera::looking_at(-Vec3::Y * DISTANCE, Vec3::ZERO, fov);
    Views { near: mid.at_distance(2.0), mid, far: mid.at_distance(10.0 * DISTANCE) }
}

/// The lighting of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lighting {
    /// A single directional light from the camera, without an environment (tables 4 and 5). The irradiance of the light is π, so a white
    /// diffuse plane facing it has radiance 1.
    Front,
    /// The studio, as irradiance on diffuse facets (tables 6 and 7).
    Irradiance,
    /// The studio, reflected by mirror facets (tables 8 to 10).
    Environment,
}

impl Lighting {
    /// Returns the facets of the tables that use this lighting.
    #[must_use]
    pub fn facets(self) -> Facets {
        if self == Self::Environment { Facets::Mirror } else { Facets::Diffuse }
    }

    /// Returns the lights in addition to the environment, for the cameras of [`views`].
    #[must_use]
    pub fn lights(self) -> Lights {
        let front = Sun { direction: -Vec3::Y, irradiance: Vec3::splat(std::f32::consts::PI) };
        Lights { sun: (self == Self::Front).then_some(front), ..Default::default() }
    }

    /// Returns the environment panorama for `Environment::from_equirect`.
    #[must_use]
    pub fn panorama(self) -> RgbImage {
        match self {
            Self::Front => RgbImage { width: 2, height: 1, texels: vec![[0.0; 3]; 2] },
            Self::Irradiance | Self::Environment => studio(),
        }
    }
}
