//! The scene of a window, and the trait for programs that open other scenes.

use std::path::Path;
use std::sync::Arc;

use super::surroundings::Surroundings;
use crate::app::demo::command_line::Seen;
use crate::app::demo::orbit::Orbit;
use leadr_gpu::Gpu;
use leadr_maps::shown::shown_path;
use leadr_render::frame::Renderer;
use leadr_render::scene::FrameState;
use leadr_scenes::registry::Choice;
use leadr_scenes::set::Set;
use leadr_scenes::stage::Sweep;
use leadr_scenes::view::CameraPose;
use leadr_tools::command::error::AppError;

/// A scene that is ready to be drawn.
pub struct Show {
    /// The renderer that holds the objects of the scene.
    pub renderer: Renderer,
    /// Returns the state at a time in seconds. If the scene's camera follows an object, the window's camera does too.
    pub scene: Box<dyn FnMut(f64) -> FrameState>,
    /// The initial view.
    pub orbit: Orbit,
    /// The near, middle and far views, if the scene has them.
    pub views: Option<[Orbit; 3]>,
    /// Camera distances of a sweep, if the scene has one.
    pub sweep: Option<Sweep>,
    /// Available environments, the first of which the renderer holds.
    pub surroundings: Surroundings,
}

impl Show {
    /// Whether the scene is animated, which a few sample times decide.
    pub fn moves(&mut self) -> bool {
        let mut at = |time: f64| FrameState { time: 0.0, ..(self.scene)(time) };
        let first = at(0.0);
        self.renderer.moves() || [0.37, 1.9, 7.3].into_iter().any(|time| at(time) != first)
    }

    /// Creates a show from an uploaded scene.
    pub fn of(set: Set, surroundings: Surroundings) -> Self {
        let orbit = |camera| Orbit::new(&CameraPose::of(&camera));
        let views = [set.views.near, set.views.mid, set.views.far].map(orbit);
        let (orbit, sweep) = (orbit(set.camera), Some(set.views.sweep()));
        Self { renderer: set.renderer, scene: set.animation, orbit, views: Some(views), sweep, surroundings }
    }
}

/// A property of the displaced surfaces of a scene, such as the roughness.
#[derive(Clone, Debug, PartialEq)]
pub enum OfSurfaces<T> {
    /// A property that the user cannot change.
    Fixed,
    /// The scene's own value of the property.
    Own,
    /// The user chose this value.
    Chosen(T),
}

/// Opens scenes for a window, and returns the command that draws the same picture to a file. The default methods describe a program with
/// one fixed scene.
pub trait Program {
    /// Returns the names of the scenes that can be opened.
    fn scenes(&self) -> &[String] {
        &[]
    }

    /// Returns the name of the current scene.
    fn scene(&self) -> &str {
        ""
    }

    /// Opens a scene by name, or a model file.
    fn open(&mut self, _gpu: &Arc<Gpu>, name: &Path) -> Result<Show, AppError> {
        Err(AppError::Usage(format!("{}: this program shows one scene only", shown_path(name))))
    }

    /// Returns the roughness of the current scene as Beckmann alpha, above 0 and at most 1.
    fn roughness(&self) -> OfSurfaces<f32> {
        OfSurfaces::Fixed
    }

    /// Whether the current scene offers a choice.
    fn offers(&self, choice: Choice) -> bool {
        matches!(choice, Choice::Objects | Choice::Relief)
    }

    /// Opens the current scene again with one flag changed, or removed if the value is `None`.
    fn remake(&mut self, _gpu: &Arc<Gpu>, _flag: &str, _value: Option<String>) -> Result<Show, AppError> {
        Err(AppError::Usage(AS_IT_IS.to_owned()))
    }

    /// Whether the current maps include the data for colours that follow the relief (`--relief-color`).
    fn keeps_relief_color(&self) -> bool {
        true
    }

    /// Returns the current material as the name of a file or folder.
    fn applied_material(&self) -> OfSurfaces<String> {
        OfSurfaces::Fixed
    }

    /// Opens the current scene again with another material: a file from `leadr fit`, a material folder, or `None` for the scene's own.
    fn apply_material(&mut self, _gpu: &Arc<Gpu>, _material: Option<&Path>) -> Result<Show, AppError> {
        Err(AppError::Usage(AS_IT_IS.to_owned()))
    }

    /// Opens the current scene at full detail; returns `None` if it already has full detail.
    fn complete(&mut self, _gpu: &Arc<Gpu>) -> Result<Option<Show>, AppError> {
        Ok(None)
    }

    /// Records the environment for [`command`](Self::command).
    fn surround(&mut self, _environment: &str) {}

    /// Returns the command that draws this picture.
    fn command(&self, _seen: &Seen<'_>) -> Option<String> {
        None
    }
}

const AS_IT_IS: &str = "this program cannot change the surfaces of its scene";

/// A program with one fixed scene.
pub struct OneScene;

impl Program for OneScene {}
