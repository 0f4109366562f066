//! The panel's input, [`Facts`], and its output, [`Request`]s.

use std::path::PathBuf;

use crate::app::demo::window::show::OfSurfaces;
use crate::app::demo::window::viewer::Action;
use leadr_scenes::registry::Choice;

/// Number of frames in the graph of frame times.
pub const HISTORY: usize = 120;

/// Values that the panel displays but cannot change.
pub struct Facts<'a> {
    /// Names of the scenes that can be opened; empty if there is only one.
    pub scenes: &'a [String],
    /// Name of the current scene.
    pub scene: &'a str,
    /// Names of the animations of a model; empty if there are none.
    pub animations: &'a [String],
    /// Index of the current animation.
    pub animation: usize,
    /// Names of the environments.
    pub environments: &'a [String],
    /// Index of the current environment.
    pub environment: usize,
    /// Azimuth and elevation of the sun in degrees, if the sky has a sun.
    pub sun: Option<[f32; 2]>,
    /// Roughness of the displaced surfaces.
    pub roughness: OfSurfaces<f32>,
    /// Material of the displaced surfaces.
    pub applied_material: OfSurfaces<String>,
    /// Whether the scene offers this choice.
    pub offers: &'a dyn Fn(Choice) -> bool,
    /// Name of the device.
    pub device: &'a str,
    /// Measured frames per second.
    pub fps: Option<f64>,
    /// Passes of the latest frame with their times, milliseconds.
    pub passes: &'a [(String, f64)],
    /// Current and final sample counts of the picture.
    pub samples: (u32, u32),
    /// Drawn pixels (width, height), fewer than in the window while something moves on a slow device.
    pub pixels: (u32, u32),
    /// Upper bound on the triangles of a frame, and number of patches.
    pub triangles: (u64, u32),
}

/// A request of the user to the window.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Perform this action.
    Act(Action),
    /// Open a scene by name, or a file.
    Open(PathBuf),
    /// Play this animation of the model.
    Animation(String),
    /// Select an environment by its index.
    Environment(usize),
    /// Set the roughness (Beckmann alpha), or restore the scene's.
    Roughness(Option<f32>),
    /// Restore the scene's material.
    OwnMaterial,
    /// Go to a view of the scene: 0 near, 1 middle, 2 far.
    View(usize),
}
