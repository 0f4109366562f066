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
    /// Tiles of waves, longest first; equal resolutions.
    pub cascades: Vec<Cascade>,
    /// Standard deviation of the height, metres.
    pub height: f32,
    /// Slope covariance `xx, yy, xy` of the waves that no cascade carries.
    pub tail: Vec3,
    /// Horizontal movement of the waves: 1 is water's, 0 none.
    pub choppiness: f32,
    /// Height of the water at rest, metres.
    pub level: f32,
    /// Diffuse albedo of what comes up out of the water, linear.
    pub color: Vec3,
    /// Diffuse albedo of foam, linear.
    pub foam: Vec3,
    /// The sea foams where its horizontal stretch (`OceanFields::joint`) is below this: 1 is the sea at rest, 0 for no foam.
    pub foam_threshold: f32,
    /// A beach that the waves run up; none for the open sea.
    pub shore: Option<Shore>,
}
