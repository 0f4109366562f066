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

/// The roughness of the displaced surfaces of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Roughness {
    /// Its user has no say in it.
    Fixed,
    /// The scene's own.
    Own,
    /// Beckmann alpha instead of it, above 0, up to 1.
    Chosen(f32),
}

/// What the displaced surfaces of a scene are made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Worn {
    /// Its user has no say in it.
    Fixed,
    /// The scene's own material.
    Own,
    /// What a file or a folder of this name holds.
    Chosen(String),
}

/// Opens scenes for a window, and says how its picture is made without one.
pub trait Program {
    /// Names of the scenes that can be opened.
    fn scenes(&self) -> &[String];

    /// The one that is shown.
    fn scene(&self) -> &str;

    /// Opens a scene by its name, or a model's file.
    fn open(&mut self, gpu: &Arc<Gpu>, name: &Path) -> Result<Show, AppError>;

    /// The roughness of what is shown.
    fn roughness(&self) -> Roughness;

    /// Whether what is shown offers a choice.
    fn offers(&self, choice: Choice) -> bool;

    /// Makes the scene that is shown again with a flag said anew, or no longer.
    fn remake(&mut self, gpu: &Arc<Gpu>, flag: &str, value: Option<String>) -> Result<Show, AppError>;

    /// Whether what is shown keeps what colours that follow the relief take.
    fn keeps_relief_color(&self) -> bool;

    /// What the surfaces that are shown are made of.
    fn worn(&self) -> Worn;

    /// Makes the scene that is shown with another material: a measured one, as `leadr fit` keeps it, or a folder; or with its own.
    fn wear(&mut self, gpu: &Arc<Gpu>, material: Option<&Path>) -> Result<Show, AppError>;

    /// The scene that is shown in all detail, if it is not yet.
    fn complete(&mut self, gpu: &Arc<Gpu>) -> Result<Option<Show>, AppError>;

    /// Notes that another environment surrounds the scene.
    fn surround(&mut self, environment: &str);

    /// The command that makes a picture.
    fn command(&self, seen: &Seen<'_>) -> Option<String>;
}

/// A program with one scene.
pub struct OneScene;

impl Program for OneScene {
    fn scenes(&self) -> &[String] {
        &[]
    }

    fn scene(&self) -> &str {
        ""
    }

    fn open(&mut self, _gpu: &Arc<Gpu>, name: &Path) -> Result<Show, AppError> {
        Err(AppError::Usage(format!("{}: this program shows one scene only", name.display())))
    }

    fn roughness(&self) -> Roughness {
        Roughness::Fixed
    }

    fn offers(&self, choice: Choice) -> bool {
        matches!(choice, Choice::Objects | Choice::Relief)
    }

    fn remake(&mut self, _gpu: &Arc<Gpu>, _flag: &str, _value: Option<String>) -> Result<Show, AppError> {
        Err(AppError::Usage("this program shows its scene as it is".to_owned()))
    }

    fn keeps_relief_color(&self) -> bool {
        true
    }

    fn worn(&self) -> Worn {
        Worn::Fixed
    }

    fn wear(&mut self, _gpu: &Arc<Gpu>, _material: Option<&Path>) -> Result<Show, AppError> {
        Err(AppError::Usage("this program shows its scene as it is".to_owned()))
    }

    fn complete(&mut self, _gpu: &Arc<Gpu>) -> Result<Option<Show>, AppError> {
        Ok(None)
    }

    fn surround(&mut self, _environment: &str) {}

    fn command(&self, _seen: &Seen<'_>) -> Option<String> {
        None
    }
}
