//! The sea as a surface: its waves, its mesh around the viewer, and its beach.

pub mod mesh;
pub mod shore;
pub mod waves;

use glam::Vec3;

use self::shore::Shore;
use self::waves::Cascade;

/// A sea: its waves and its water.
#[derive(Clone, Debug)]
pub struct Ocean {
    /// Tiles of waves, the longest waves first; all have the same resolution.
    pub cascades: Vec<Cascade>,
    /// Standard deviation of the height, metres.
    pub height: f32,
    /// Slope covariance `xx, yy, xy` of the waves that are in no cascade.
    pub tail: Vec3,
    /// Scale of the waves' horizontal movement: 1 as in water, 0 without.
    pub choppiness: f32,
    /// Height of the water at rest, metres.
    pub level: f32,
    /// Diffuse albedo of the light that comes back out of the water, linear.
    pub color: Vec3,
    /// Diffuse albedo of foam, linear.
    pub foam: Vec3,
    /// The sea foams where its horizontal stretch (`OceanFields::joint`) is below this threshold; the sea at rest has 1,
    /// and a threshold of 0 means no foam.
    pub foam_threshold: f32,
    /// A beach that the waves run up; `None` for the open sea.
    pub shore: Option<Shore>,
}
