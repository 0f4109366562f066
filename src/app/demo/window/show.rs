//! What a window shows, and who opens other things for it.

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

/// A scene that is ready to be shown.
pub struct Show {
    /// Holds its objects.
    pub renderer: Renderer,
    /// Its state at a time in seconds. Its camera may follow something; then the window's does, too.
    pub scene: Box<dyn FnMut(f64) -> FrameState>,
    /// Where it is seen from at first.
    pub orbit: Orbit,
    /// Its near, middle and far view, if it has them.
    pub views: Option<[Orbit; 3]>,
    /// Distances between which it is swept.
    pub sweep: Option<Sweep>,
    /// Environments that it can be shown in. The renderer has the first.
    pub surroundings: Surroundings,
}

impl Show {
    /// Whether anything of it changes as time goes on, as far as a few moments tell.
    pub fn moves(&mut self) -> bool {
        let mut at = |time: f64| FrameState { time: 0.0, ..(self.scene)(time) };
        let first = at(0.0);
        self.renderer.moves() || [0.37, 1.9, 7.3].into_iter().any(|time| at(time) != first)
    }

    /// A scene on the device.
    pub fn of(set: Set, surroundings: Surroundings) -> Self {
        let orbit = |camera| Orbit::new(&CameraPose::of(&camera));
        let views = [set.views.near, set.views.mid, set.views.far].map(orbit);
        let (orbit, sweep) = (orbit(set.camera), Some(set.views.sweep()));
        Self { renderer: set.renderer, scene: set.animation, orbit, views: Some(views), sweep, surroundings }
    }
}

/// What the displaced surfaces of a scene have, such as a roughness.
#[derive(Clone, Debug, PartialEq)]
pub enum OfSurfaces<T> {
    /// Its user has no say in it.
    Fixed,
    /// The scene's own.
    Own,
    /// This instead of it.
    Chosen(T),
}

/// Opens scenes for a window, and says how its picture is made without one. By default it is a program with one scene, which it shows as
/// it is.
pub trait Program {
    /// Names of the scenes that can be opened.
    fn scenes(&self) -> &[String] {
        &[]
    }

    /// The one that is shown.
    fn scene(&self) -> &str {
        ""
    }

    /// Opens a scene by its name, or a model's file.
    fn open(&mut self, _gpu: &Arc<Gpu>, name: &Path) -> Result<Show, AppError> {
        Err(AppError::Usage(format!("{}: this program shows one scene only", name.display())))
    }

    /// The roughness of what is shown: Beckmann alpha, above 0, up to 1.
    fn roughness(&self) -> OfSurfaces<f32> {
        OfSurfaces::Fixed
    }

    /// Whether what is shown offers a choice.
    fn offers(&self, choice: Choice) -> bool {
        matches!(choice, Choice::Objects | Choice::Relief)
    }

    /// Makes the scene that is shown again with a flag said anew, or no longer.
    fn remake(&mut self, _gpu: &Arc<Gpu>, _flag: &str, _value: Option<String>) -> Result<Show, AppError> {
        Err(AppError::Usage(AS_IT_IS.to_owned()))
    }

    /// Whether what is shown keeps what colours that follow the relief take.
    fn keeps_relief_color(&self) -> bool {
        true
    }

    /// The material that is shown: the name of a file or a folder.
    fn worn(&self) -> OfSurfaces<String> {
        OfSurfaces::Fixed
    }

    /// Makes the scene that is shown with another material: a measured one, as `leadr fit` keeps it, or a folder; or with its own.
    fn wear(&mut self, _gpu: &Arc<Gpu>, _material: Option<&Path>) -> Result<Show, AppError> {
        Err(AppError::Usage(AS_IT_IS.to_owned()))
    }

    /// The scene that is shown in all detail, if it is not yet.
    fn complete(&mut self, _gpu: &Arc<Gpu>) -> Result<Option<Show>, AppError> {
        Ok(None)
    }

    /// Notes that another environment surrounds the scene.
    fn surround(&mut self, _environment: &str) {}

    /// The command that makes a picture.
    fn command(&self, _seen: &Seen<'_>) -> Option<String> {
        None
    }
}

const AS_IT_IS: &str = "this program shows its scene as it is";

/// A program with one scene.
pub struct OneScene;

impl Program for OneScene {}
