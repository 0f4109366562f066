//! The scene of a window, and the trait of programs that open other scenes.

use std::path::PathBuf;
use std::sync::Arc;

use super::surroundings::Surroundings;
use crate::app::demo::command_line::Seen;
use crate::app::demo::orbit::Orbit;
use leadr_gpu::Gpu;
use leadr_maps::shown::shown_path;
use leadr_render::frame::Renderer;
use leadr_render::scene::FrameState;
use leadr_scenes::model::ModelChoice;
use leadr_scenes::registry::Choice;
use leadr_scenes::set::Set;
use leadr_scenes::stage::Sweep;
use leadr_scenes::view::CameraPose;
use leadr_tools::command::error::AppError;

/// A scene that is ready to draw.
pub struct Show {
    /// The renderer that holds the objects of the scene.
    pub renderer: Renderer,
    /// Returns the state at a time in seconds. If the scene's camera follows an object, the window's camera does too.
    pub scene: Box<dyn FnMut(f64) -> FrameState + Send>,
    /// The initial view.
    pub orbit: Orbit,
    /// The near, middle and far views, if the scene has them.
    pub views: Option<[Orbit; 3]>,
    /// The camera distances of a sweep, if the scene has one.
    pub sweep: Option<Sweep>,
    /// The available environments. The renderer starts with the first environment.
    pub surroundings: Surroundings,
    /// The animations of a model.
    pub animations: Animations,
}

/// The animations of a model.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animations {
    /// Names of the animations.
    pub names: Vec<String>,
    /// Index of the current animation.
    pub current: usize,
}

impl Animations {
    /// Returns the animations of a model with a selected animation. An animation without a name of its own has its number, from 1.
    pub fn of(choice: &ModelChoice) -> Self {
        let model = &choice.model;
        let name = |(number, animation): (usize, &leadr_models::Animation)| {
            let is_own = !animation.name.is_empty() && model.animation_named(&animation.name) == Some(number);
            if is_own { animation.name.clone() } else { (number + 1).to_string() }
        };
        let names = model.animations.iter().enumerate().map(name).collect();
        Self { names, current: choice.animation.unwrap_or(0) }
    }
}

impl Show {
    /// Whether the scene is animated, judged from a few sample times.
    pub fn moves(&mut self) -> bool {
        let mut at = |time: f64| FrameState { time: 0.0, ..(self.scene)(time) };
        let first = at(0.0);
        self.renderer.moves() || [0.37, 1.9, 7.3].into_iter().any(|time| at(time) != first)
    }

    /// Creates a show from an uploaded scene.
    pub fn of(set: Set, surroundings: Surroundings, animations: Animations) -> Self {
        let orbit = |camera| Orbit::new(&CameraPose::of(&camera));
        let views = [set.views.near, set.views.mid, set.views.far].map(orbit);
        let (orbit, sweep) = (orbit(set.camera), Some(set.views.sweep()));
        Self {
            renderer: set.renderer,
            scene: set.animation,
            orbit,
            views: Some(views),
            sweep,
            surroundings,
            animations,
        }
    }
}

/// A property of the displaced surfaces of a scene, such as the roughness.
#[derive(Clone, Debug, PartialEq)]
pub enum OfSurfaces<T> {
    /// The user cannot change the property.
    Fixed,
    /// The property has the value of the scene.
    Own,
    /// The property has a value that the user chose.
    Chosen(T),
}

/// A change of the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneChange {
    /// Open a scene by name, or a model file.
    Open(PathBuf),
    /// Set a flag, written without dashes, to a value, or remove it for `None`.
    Flag(&'static str, Option<String>),
    /// Apply a material: a file from `leadr fit`, a material folder, or `None` for the scene's own.
    Material(Option<PathBuf>),
    /// Show full detail.
    Complete,
}

/// Loads a changed scene, on any thread.
pub type Load = Box<dyn FnOnce() -> Result<Show, AppError> + Send>;

/// Opens scenes for a window, and returns the command that draws the same picture to a file. The default methods describe a program with
/// one fixed scene.
pub trait Program {
    /// Returns the names of the scenes that can be opened.
    fn scenes(&self) -> &[String] {
        &[]
    }

    /// Returns the name of the current scene, empty for a program with one scene.
    fn scene(&self) -> &str {
        ""
    }

    /// Returns the roughness of the current scene as Beckmann alpha, above 0 and at most 1.
    fn roughness(&self) -> OfSurfaces<f32> {
        OfSurfaces::Fixed
    }

    /// Whether the current scene offers a choice.
    fn offers(&self, choice: Choice) -> bool {
        matches!(choice, Choice::Objects | Choice::Relief)
    }

    /// Whether the classes of the current scene include colours that follow the relief (`--relief-color`), or `None` if the scene cannot
    /// change.
    fn relief_color(&self) -> Option<bool> {
        None
    }

    /// Returns the current material as the name of a file or folder.
    fn applied_material(&self) -> OfSurfaces<String> {
        OfSurfaces::Fixed
    }

    /// Checks a change and returns the work that loads the changed scene, or `None` if nothing changes. The current scene stays until
    /// [`accept`](Self::accept).
    fn prepare(&mut self, _gpu: &Arc<Gpu>, change: &SceneChange) -> Result<Option<Load>, AppError> {
        let fault = match change {
            SceneChange::Complete => return Ok(None),
            SceneChange::Open(path) => format!("{}: this program shows one scene only", shown_path(path)),
            _ => "this program cannot change the surfaces of its scene".to_owned(),
        };
        Err(AppError::Usage(fault))
    }

    /// Makes the scene of the last [`prepare`](Self::prepare) the current scene.
    fn accept(&mut self) {}

    /// Records the environment for [`command`](Self::command).
    fn surround(&mut self, _environment: &str) {}

    /// Returns the command that draws this picture.
    fn command(&self, _seen: &Seen<'_>) -> Option<String> {
        None
    }
}

/// A program with one fixed scene.
pub struct OneScene;

impl Program for OneScene {}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_models::{Animation, Model};

    #[test]
    fn every_animation_can_be_selected() {
        let named = |name: &str| Animation { name: name.to_owned(), ..Animation::default() };
        let model = Model { animations: ["Walk", "", "Walk"].map(named).to_vec(), ..Model::default() };
        let chosen = |name: Option<&str>| Animations::of(&ModelChoice::new(model.clone(), name).unwrap());
        let Animations { names, current } = chosen(None);
        assert_eq!((names.as_slice(), current), (&["Walk", "2", "3"].map(str::to_owned)[..], 0));
        for (number, name) in names.iter().enumerate() {
            assert_eq!(chosen(Some(name)).current, number);
        }
        for wrong in ["0", "4", "Run"] {
            assert!(ModelChoice::new(model.clone(), Some(wrong)).is_err(), "{wrong}");
        }
    }
}
