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
    /// The wave tiles, which have equal resolution. The longest waves come first.
    pub cascades: Vec<Cascade>,
    /// The standard deviation of the wave height, in metres.
    pub height: f32,
    /// The slope covariance `xx, yy, xy` of the waves that no cascade contains.
    pub tail: Vec3,
    /// The factor for the horizontal displacement by waves, which is 1 for water and 0 for none.
    pub choppiness: f32,
    /// The height of the water at rest, in metres.
    pub level: f32,
    /// The linear diffuse albedo of the light that the water scatters back.
    pub color: Vec3,
    /// The linear diffuse albedo of foam.
    pub foam: Vec3,
    /// The horizontal stretch (`OceanFields::joint`) below which foam appears. The sea at rest has a stretch of 1. A threshold of 0
    /// disables foam.
    pub foam_threshold: f32,
    /// The beach, or `None` for the open sea.
    pub shore: Option<Shore>,
}
