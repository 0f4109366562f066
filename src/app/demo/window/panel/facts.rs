//! The input of the panel, [`Facts`], and its output, [`Request`]s.

use std::path::PathBuf;

use crate::app::demo::window::show::OfSurfaces;
use crate::app::demo::window::viewer::Action;
use leadr_scenes::registry::Choice;

/// The number of frames in the graph of frame times.
pub const HISTORY: usize = 120;

/// Values that the panel displays but cannot change.
pub struct Facts<'a> {
    /// The names of the scenes that can be opened. The list is empty if there is only one scene.
    pub scenes: &'a [String],
    /// The name of the current scene.
    pub scene: &'a str,
    /// Names of the animations of a model; empty if there are none.
    pub animations: &'a [String],
    /// Index of the current animation.
    pub animation: usize,
    /// Names of the environments.
    pub environments: &'a [String],
    /// The index of the current environment.
    pub environment: usize,
    /// The azimuth and the elevation of the sun in degrees, if the sky has a sun.
    pub sun: Option<[f32; 2]>,
    /// The roughness of the displaced surfaces.
    pub roughness: OfSurfaces<f32>,
    /// The material of the displaced surfaces.
    pub applied_material: OfSurfaces<String>,
    /// Whether the scene offers this choice.
    pub offers: &'a dyn Fn(Choice) -> bool,
    /// The name of the device.
    pub device: &'a str,
    /// The measured number of frames per second.
    pub fps: Option<f64>,
    /// The passes of the latest frame, with their times in milliseconds.
    pub passes: &'a [(String, f64)],
    /// The current and final sample counts of the picture.
    pub samples: (u32, u32),
    /// The size of the drawn picture in pixels (width, height). The picture is smaller than the window while something moves on a slow
    /// device.
    pub pixels: (u32, u32),
    /// An upper bound on the number of triangles in a frame, and the number of patches.
    pub triangles: (u64, u32),
}

/// A request that the user makes to the window.
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
    /// Set the roughness (Beckmann alpha), or restore the roughness of the scene.
    Roughness(Option<f32>),
    /// Restore the material of the scene.
    OwnMaterial,
    /// Go to a view of the scene: 0 near, 1 middle, 2 far.
    View(usize),
}
