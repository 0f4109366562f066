//! The sea as a surface: its waves, its mesh around the viewer, and its beach.

pub mod mesh;
pub mod shore;
pub mod waves;

use glam::Vec3;

use self::shore::Shore;
use self::waves::Cascade;

/// A sea: waves and water.
#[derive(Clone, Debug)]
pub struct Ocean {
    /// Wave tiles of equal resolution, longest waves first.
    pub cascades: Vec<Cascade>,
    /// Standard deviation of the height, metres.
    pub height: f32,
    /// Slope covariance `xx, yy, xy` of the waves that are in no cascade.
    pub tail: Vec3,
    /// Scale of the waves' horizontal displacement: 1 for water, 0 for none.
    pub choppiness: f32,
    /// Height of the water at rest, metres.
    pub level: f32,
    /// Diffuse albedo of the light scattered back by the water, linear.
    pub color: Vec3,
    /// Diffuse albedo of foam, linear.
    pub foam: Vec3,
    /// Foam threshold for the horizontal stretch (`OceanFields::joint`): foam appears below it. The sea at rest has a stretch of 1.
    /// 0 disables foam.
    pub foam_threshold: f32,
    /// A beach; `None` for the open sea.
    pub shore: Option<Shore>,
}
