//! The scene of a window, and the trait of programs that open other scenes.

use std::path::Path;
use std::sync::Arc;

use super::surroundings::Surroundings;
use crate::app::demo::command_line::Seen;
use crate::app::demo::orbit::Orbit;
use leadr_gpu::Gpu;
use leadr_render::frame::Renderer;
use leadr_render::scene::FrameState;
use leadr_scenes::registry::Choice;
use leadr_scenes::set::Set;
use leadr_scenes::stage::Sweep;
use leadr_scenes::view::CameraPose;
use leadr_tools::command::error::AppError;

/// A scene that is ready to be drawn.
pub struct Show {
    /// The renderer, with the objects of the scene.
    pub renderer: Renderer,
    /// Returns the state at a time in seconds. If the scene's camera follows an object, so does the window's camera.
    pub scene: Box<dyn FnMut(f64) -> FrameState>,
    /// The first view.
    pub orbit: Orbit,
    /// Its near, middle and far views, if it has them.
    pub views: Option<[Orbit; 3]>,
    /// Camera distances of a sweep, if it has one.
    pub sweep: Option<Sweep>,
    /// Available environments. The renderer has the first.
    pub surroundings: Surroundings,
}

impl Show {
    /// Whether the scene is animated, judged by a few moments.
    pub fn moves(&mut self) -> bool {
        let mut at = |time: f64| FrameState { time: 0.0, ..(self.scene)(time) };
        let first = at(0.0);
        self.renderer.moves() || [0.37, 1.9, 7.3].into_iter().any(|time| at(time) != first)
    }

    /// Makes a show of an uploaded scene.
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
    /// The user cannot change it.
    Fixed,
    /// The scene's own value.
    Own,
    /// A value that the user chose.
    Chosen(T),
}

/// Opens scenes for a window, and gives the command that draws the same picture to a file. The default methods describe a program with
/// one fixed scene.
pub trait Program {
    /// Names of the scenes that can be opened.
    fn scenes(&self) -> &[String] {
        &[]
    }

    /// Name of the current scene.
    fn scene(&self) -> &str {
        ""
    }

    /// Opens a scene by name, or a model file.
    fn open(&mut self, _gpu: &Arc<Gpu>, name: &Path) -> Result<Show, AppError> {
        Err(AppError::Usage(format!("{}: this program shows one scene only", name.display())))
    }

    /// The roughness of the current scene: Beckmann alpha, above 0, up to 1.
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

    /// The current material: the name of a file or a folder.
    fn applied_material(&self) -> OfSurfaces<String> {
        OfSurfaces::Fixed
    }

    /// Opens the current scene again with another material: a file from `leadr fit`, a material folder, or with `None` its own.
    fn apply_material(&mut self, _gpu: &Arc<Gpu>, _material: Option<&Path>) -> Result<Show, AppError> {
        Err(AppError::Usage(AS_IT_IS.to_owned()))
    }

    /// Opens the current scene at full detail; returns `None` if it already has that.
    fn complete(&mut self, _gpu: &Arc<Gpu>) -> Result<Option<Show>, AppError> {
        Ok(None)
    }

    /// Records the environment for [`command`](Self::command).
    fn surround(&mut self, _environment: &str) {}

    /// The command that draws this picture.
    fn command(&self, _seen: &Seen<'_>) -> Option<String> {
        None
    }
}

const AS_IT_IS: &str = "this program cannot change the surfaces of its scene";

/// A program with one fixed scene.
pub struct OneScene;

impl Program for OneScene {}
