//! What the panel is told, and what it asks for.

use crate::app::demo::window::show::OfSurfaces;
use crate::app::demo::window::viewer::Action;
use leadr_scenes::registry::Choice;

/// Frames in the graph of their times.
pub const HISTORY: usize = 120;

/// What the panel tells and cannot change.
pub struct Facts<'a> {
    /// Names of the scenes that can be opened; empty where there is one only.
    pub scenes: &'a [String],
    /// The one that is shown.
    pub scene: &'a str,
    /// Names of the environments.
    pub environments: &'a [String],
    /// Which of them surrounds the scene.
    pub environment: usize,
    /// Direction to the sun as it is, if there is one: degrees.
    pub sun: Option<[f32; 2]>,
    /// The roughness of its displaced surfaces.
    pub roughness: OfSurfaces<f32>,
    /// What they are made of.
    pub worn: OfSurfaces<String>,
    /// Whether it offers a choice.
    pub offers: &'a dyn Fn(Choice) -> bool,
    /// The device.
    pub device: &'a str,
    /// Frames in a second.
    pub fps: Option<f64>,
    /// Passes of the last frame and their milliseconds.
    pub passes: &'a [(String, f64)],
    /// Samples in the picture, and those that it will have.
    pub samples: (u32, u32),
    /// Pixels that are drawn; fewer than the window has while something moves on a slow device.
    pub pixels: (u32, u32),
    /// Upper bound on the triangles of a frame, and its patches.
    pub triangles: (u64, u32),
}

/// What the user asks the window for.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// What a key does.
    Act(Action),
    /// Another scene, by name.
    Scene(String),
    /// One of the environments.
    Environment(usize),
    /// Another roughness, Beckmann alpha, or the scene's own.
    Roughness(Option<f32>),
    /// The scene's own material.
    OwnMaterial,
    /// One of the scene's views: 0 near, 1 middle, 2 far.
    View(usize),
}
