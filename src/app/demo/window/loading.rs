//! Changes of the scene and its environment. Another thread loads them while the window shows the old picture.

use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use super::Session;
use super::show::{Program, SceneChange, Show};
use super::surroundings::{Lit, Surroundings};
use leadr_gpu::Gpu;
use leadr_scenes::light::EnvironmentChoice;
use leadr_tools::command::error::AppError;

/// Interval for polling a change that must be finished before the next frame.
const WAIT: Duration = Duration::from_millis(5);

/// A change that takes time.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Another environment.
    Environment(EnvironmentChoice),
    /// Another scene, or other surfaces of the scene.
    Scene(SceneChange),
}

impl Change {
    /// Returns the name of what is loaded; `None` for work that the user has not requested.
    fn name(&self) -> Option<String> {
        Some(match self {
            Self::Environment(EnvironmentChoice::Sky) => "the sky".to_owned(),
            Self::Environment(EnvironmentChoice::Studio) => "the studio".to_owned(),
            Self::Environment(EnvironmentChoice::File(path)) | Self::Scene(SceneChange::Open(path)) => file_name(path),
            Self::Scene(SceneChange::Flag(flag, _)) => format!("the scene with another {}", flag.replace('-', " ")),
            Self::Scene(SceneChange::Material(Some(path))) => file_name(path),
            Self::Scene(SceneChange::Material(None)) => "the scene's own material".to_owned(),
            Self::Scene(SceneChange::Complete) => return None,
        })
    }
}

/// Returns the last part of a path.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// A loaded change.
pub enum Loaded {
    /// An environment.
    Environment(Box<Lit>),
    /// A scene.
    Scene(Box<Show>),
}

type Work = Box<dyn FnOnce() -> Result<Loaded, AppError> + Send>;

/// The change that is being loaded, and the changes that wait for it.
#[derive(Default)]
pub struct Loading {
    running: Option<(Change, JoinHandle<Result<Loaded, AppError>>)>,
    waiting: VecDeque<Change>,
}

impl Loading {
    /// Adds a change. It replaces a waiting change of the same kind, which it would undo.
    pub fn request(&mut self, change: Change) {
        if let Change::Scene(SceneChange::Open(_)) = change {
            self.waiting.clear();
        }
        let kind = |change: &Change| match change {
            Change::Environment(_) => "environment",
            Change::Scene(SceneChange::Open(_)) => "scene",
            Change::Scene(SceneChange::Flag(flag, _)) => *flag,
            Change::Scene(SceneChange::Material(_)) => "material",
            Change::Scene(SceneChange::Complete) => "detail",
        };
        self.waiting.retain(|other| kind(other) != kind(&change));
        self.waiting.push_back(change);
    }

    /// Whether a change is being loaded or waits.
    pub fn is_busy(&self) -> bool {
        self.running.is_some() || !self.waiting.is_empty()
    }

    /// Returns the message about the running change.
    pub fn message(&self) -> Option<String> {
        let (change, _) = self.running.as_ref()?;
        change.name().map(|name| format!("loading {name} ..."))
    }

    /// Returns the change that is finished, if any.
    pub fn finished(&mut self) -> Option<(Change, Result<Loaded, AppError>)> {
        let (change, work) = self.running.take_if(|(_, work)| work.is_finished())?;
        let panicked = || AppError::Failed("the loading thread failed: start the program again".to_owned());
        Some((change, work.join().unwrap_or_else(|_| Err(panicked()))))
    }

    /// Starts the next change, if none is running. Returns whether one starts, or an error of its preparation.
    pub fn start(
        &mut self,
        gpu: &Arc<Gpu>,
        program: &mut dyn Program,
        surroundings: &Surroundings,
    ) -> Result<bool, AppError> {
        if self.running.is_some() {
            return Ok(false);
        }
        let Some(change) = self.waiting.pop_front() else { return Ok(false) };
        let work: Work = match &change {
            Change::Environment(choice) => {
                let light = surroundings.loader(gpu, choice.clone());
                Box::new(move || Ok(Loaded::Environment(Box::new(light()?))))
            }
            Change::Scene(scene) => match program.prepare(gpu, scene)? {
                Some(load) => Box::new(move || Ok(Loaded::Scene(Box::new(load()?)))),
                None => return Ok(false),
            },
        };
        let thread = std::thread::Builder::new().name("loading".to_owned());
        let spawned = thread.spawn(work).map_err(|e| AppError::Failed(format!("no thread can be started: {e}")))?;
        self.running = Some((change, spawned));
        Ok(true)
    }
}

impl Session<'_> {
    /// Shows a finished change and starts the next one. After an error the current scene stays. With a fixed number of frames, changes are
    /// waited for, so that the frames do not depend on their time.
    pub(super) fn load(&mut self) -> Result<(), AppError> {
        loop {
            if let Some((change, loaded)) = self.loading.finished() {
                match loaded {
                    Ok(Loaded::Environment(lit)) => {
                        self.painter.surround(self.surroundings.show(*lit))?;
                        self.program.surround(&self.surroundings.names()[self.surroundings.shown()]);
                        self.viewer.invalidate();
                    }
                    Ok(Loaded::Scene(show)) => {
                        self.program.accept();
                        self.enter(&change, *show)?;
                    }
                    Err(error) => self.complain(&error),
                }
                self.window.request_redraw();
            }
            match self.loading.start(self.painter.gpu(), self.program, &self.surroundings) {
                Ok(true) => {
                    self.loading.message().iter().for_each(|message| tracing::info!("{message}"));
                    self.window.request_redraw();
                }
                Ok(false) => {}
                Err(error) => self.complain(&error),
            }
            if self.options.frames.is_none() || !self.loading.is_busy() {
                return Ok(());
            }
            std::thread::sleep(WAIT);
        }
    }

    /// Shows another scene, or the same scene with other surfaces in the same view and environment.
    fn enter(&mut self, change: &Change, mut show: Show) -> Result<(), AppError> {
        let moves = show.moves();
        if matches!(change, Change::Scene(SceneChange::Open(_))) {
            self.painter.replace(show.renderer)?;
            (self.views, self.surroundings) = (show.views, show.surroundings);
            self.viewer.enter(show.orbit, show.sweep, moves);
        } else {
            self.painter.replace_keeping_environment(show.renderer)?;
            self.viewer.scene_moves = moves;
            self.viewer.invalidate();
        }
        match change {
            Change::Scene(SceneChange::Flag("animation", _)) => self.viewer.play(),
            Change::Scene(SceneChange::Flag("relief-color", _)) => {
                let options = &mut self.viewer.choices.picture.options;
                options.relief_color = self.program.relief_color().unwrap_or(options.relief_color);
            }
            _ => {}
        }
        (self.scene, self.animations) = (show.scene, show.animations);
        self.kinds.forget();
        self.clock.pause();
        self.pace.interrupt();
        Ok(())
    }
}

impl Drop for Loading {
    /// Waits for the thread, which uses the device.
    fn drop(&mut self) {
        if let Some((_, work)) = self.running.take() {
            _ = work.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waiting_changes_replace_those_of_their_kind() {
        let mut loading = Loading::default();
        let environment = |name: &str| Change::Environment(EnvironmentChoice::File(name.into()));
        let roughness = |alpha: &str| Change::Scene(SceneChange::Flag("roughness", Some(alpha.to_owned())));
        for change in [environment("a.hdr"), roughness("0.1"), environment("b.hdr"), roughness("0.2")] {
            loading.request(change);
        }
        assert_eq!(loading.waiting, [environment("b.hdr"), roughness("0.2")]);
        // Another scene has its own surfaces and environment.
        let scene = Change::Scene(SceneChange::Open("models/snail.glb".into()));
        loading.request(scene.clone());
        assert_eq!(loading.waiting, std::slice::from_ref(&scene));
        assert_eq!(scene.name().as_deref(), Some("snail.glb"));
        assert!(loading.is_busy() && loading.message().is_none() && loading.finished().is_none());
    }
}
