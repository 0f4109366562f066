//! The sea as a surface, with its waves, its mesh around the viewer, and its beach.

pub mod mesh;
pub mod shore;
pub mod waves;

use glam::Vec3;

use self::shore::Shore;
use self::waves::Cascade;

/// The waves and the water of a sea.
#[derive(Clone, Debug)]
pub struct Ocean {
    /// Wave tiles of equal resolution, longest waves first.
    pub cascades: Vec<Cascade>,
    /// Standard deviation of the wave height, in metres.
    pub height: f32,
    /// Slope covariance `xx, yy, xy` of the waves that are in no cascade.
    pub tail: Vec3,
    /// Factor on the horizontal displacement of waves: 1 for water, 0 for none.
    pub choppiness: f32,
    /// Height of the water at rest, in metres.
    pub level: f32,
    /// Linear diffuse albedo of the light that the water scatters back.
    pub color: Vec3,
    /// Linear diffuse albedo of foam.
    pub foam: Vec3,
    /// Horizontal stretch (`OceanFields::joint`) below which foam appears. The sea at rest has a stretch of 1, and a threshold of 0
    /// disables foam.
    pub foam_threshold: f32,
    /// A beach; `None` for the open sea.
    pub shore: Option<Shore>,
}
