//! A panorama as an image and its suns: light that comes from a few small places is worth more as directional lights, which
//! throw shadows and which a few probes or nine harmonics cannot miss.

use glam::Vec3;

/// A directional light taken out of a panorama.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentLight {
    /// Unit direction towards its middle, world.
    pub direction: Vec3,
    /// Irradiance on a plane facing it, linear rgb.
    pub irradiance: Vec3,
    /// Variance of the directions that its light comes from, radians², along each of two axes across `direction`.
    pub variance: f32,
}

impl EnvironmentLight {
    /// Angular radius in degrees of an even disk with the same variance.
    #[must_use]
    pub fn radius_degrees(&self) -> f32 {
        (2.0 * self.variance.max(0.0).sqrt()).to_degrees()
    }
}
