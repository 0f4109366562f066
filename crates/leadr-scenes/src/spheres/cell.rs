//! A sphere as a cell of the supplement's tables, and the three lightings of the tables.

use glam::{Affine3A, Vec3};

use super::surface::Surface;
use crate::stage::{Lights, Stage, Views};
use crate::studio::studio;
use leadr_maps::RgbImage;
use leadr_render::camera::Camera;
use leadr_render::scene::{Object, Pose, Sun};

/// Facet material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Facets {
    /// White facets without specular reflection.
    Diffuse,
    /// Perfect mirrors with reflectance 1 at every angle.
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

/// Minimum roughness of an eight-bit vertex colour, nearly a mirror with a 0.2° wide lobe.
pub const MIRROR_ROUGHNESS: f32 = 1.0 / 255.0;

/// Distance of a table's camera from the centre of the unit sphere, metres.
pub const DISTANCE: f32 = 12.0;

/// Fraction of the picture height that the smooth sphere fills in a table.
pub const FILL: f32 = 0.8;

/// Seconds per rotation of the sphere about its poles.
pub const ROTATION_PERIOD: f64 = 20.0;

impl Surface {
    /// Builds an object from the surface, with standard deviation `steep` of the steeper slope.
    pub fn object(&self, name: &str, steep: f32, facets: Facets) -> Object {
        let mut mesh = self.mesh.clone();
        mesh.colors = vec![[1.0, 1.0, 1.0, MIRROR_ROUGHNESS]; mesh.positions.len()];
        Object::new(name, mesh).with_heights(self.heights.clone(), steep).with_specular_f0(facets.specular_f0())
    }

    /// Builds the stage of one cell. A frame's `height_scale` multiplies `steep`, so one upload serves all rows with the same slope ratio.
    /// The sphere rotates about its poles in [`ROTATION_PERIOD`] seconds with constant statistics, so other times give independent
    /// pictures.
    pub fn stage(&self, steep: f32, facets: Facets) -> Stage {
        let object = self.object("sphere", steep, facets);
        let rotation = |time: f64| {
            vec![Pose::Rigid(Affine3A::from_rotation_z((time / ROTATION_PERIOD * std::f64::consts::TAU) as f32))]
        };
        Stage::moving(vec![object], views(), rotation, |_| Vec3::ZERO)
    }
}

/// Returns the table's view (`mid`), single bumps (`near`), and a sphere of a few pixels (`far`).
pub fn views() -> Views {
    // The outline of a unit sphere at distance d lies at the angle asin(1 / d).
    let tangent = 1.0 / (DISTANCE * DISTANCE - 1.0).sqrt();
    let fov = 2.0 * (tangent / FILL).atan().to_degrees();
    let mid = Camera::looking_at(-Vec3::Y * DISTANCE, Vec3::ZERO, fov);
    Views { near: mid.at_distance(2.0), mid, far: mid.at_distance(10.0 * DISTANCE) }
}

/// Lighting of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lighting {
    /// One directional light from the camera, without environment (tables 4 and 5). Its irradiance is π, so a white diffuse plane facing it
    /// has radiance 1.
    Front,
    /// The studio as irradiance on diffuse facets (tables 6 and 7).
    Irradiance,
    /// The studio reflected by mirror facets (tables 8 to 10).
    Environment,
}

impl Lighting {
    /// Returns the facets of the tables with this lighting.
    #[must_use]
    pub fn facets(self) -> Facets {
        if self == Self::Environment { Facets::Mirror } else { Facets::Diffuse }
    }

    /// Returns the lights besides the environment, for the cameras of [`views`].
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
