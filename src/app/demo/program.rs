//! The scenes that the window can open, and the `leadr capture` commands that draw their pictures.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;
use std::sync::Arc;

use super::command_line::{Seen, command_of};
use super::window::loading::file_name;
use super::window::pace::Pace;
use super::window::show::{Animations, Load, OfSurfaces, Program, SceneChange, Show};
use super::window::surroundings::Surroundings;
use crate::app::flags::scene::SceneArgs;
use leadr_gpu::Gpu;
use leadr_maps::shown::shown_path;
use leadr_scenes::config::{Picture, SceneConfig};
use leadr_scenes::given::CommandLine;
use leadr_scenes::model::measured::MeasuredMaterial;
use leadr_scenes::registry::{Choice, SCENES};
use leadr_scenes::set::{Inputs, Watch, set};
use leadr_tools::command::error::AppError;

/// A scene of `leadr demo` and its command line.
#[derive(Clone)]
struct Current {
    config: SceneConfig,
    line: CommandLine,
    name: String,
    /// Whether `config` is shown at full detail.
    is_complete: bool,
}

/// The scenes of `leadr demo`.
pub struct DemoProgram {
    current: Current,
    /// The scene that is being loaded.
    next: Option<Current>,
    names: Vec<String>,
    pace: Pace,
}

impl DemoProgram {
    /// Starts with `config`, which was resolved from `line`.
    pub fn new(config: SceneConfig, line: CommandLine, pace: Pace) -> Self {
        let name = config.model.as_ref().map_or(config.scene.name.into(), |file| file.to_string_lossy().into_owned());
        let mut names: Vec<String> = SCENES.iter().map(|scene| scene.name.to_owned()).collect();
        if !names.contains(&name) {
            names.push(name.clone());
        }
        let current = Current { config: own(&config), line, name, is_complete: true };
        Self { current, next: None, names, pace }
    }

    /// Opens the first scene. On a software device, the maps are coarse, so that the first picture appears sooner.
    pub fn begin(&mut self, inputs: Inputs, gpu: &Arc<Gpu>, watch: Watch<'_>) -> Result<Show, AppError> {
        let Current { config, is_complete, .. } = &mut self.current;
        let coarse = config.scene.first_tile(config.atlas_tile).filter(|_| gpu.is_software());
        *is_complete = coarse.is_none();
        let tile = coarse.unwrap_or(config.atlas_tile);
        show(inputs, gpu, &SceneConfig { atlas_tile: tile, ..config.clone() }, &self.pace, watch)
    }

    /// Returns the command line of a changed scene, and its name.
    fn changed(&self, change: &SceneChange) -> Result<(CommandLine, String), AppError> {
        let Current { config, line, name, .. } = &self.current;
        let (mut line, mut name) = (line.clone(), name.clone());
        match change {
            SceneChange::Open(path) => {
                name = path.to_string_lossy().into_owned();
                line.enter(name.clone());
                ["--camera", "--distance"].into_iter().for_each(|flag| line.remove(flag));
            }
            SceneChange::Flag(flag, value) => line.set(&format!("--{flag}"), value.clone()),
            SceneChange::Material(material) if config.model.is_some() => {
                if let Some(folder) = material.as_ref().filter(|material| material.is_dir()) {
                    let fault = "a material folder is for the plane and the sphere: drop a measured material, FIT.json, on a model";
                    return Err(AppError::Usage(format!("{}: {fault}", shown_path(folder))));
                }
                let all = |file: &PathBuf| [OsStr::new("*="), file.as_os_str()].into_iter().collect::<OsString>();
                line.set("--measured", material.as_ref().map(all));
            }
            SceneChange::Material(material) => {
                config.scene.check_offers("--material", Choice::HeightMap).map_err(AppError::Usage)?;
                line.set("--material", material.clone());
            }
            SceneChange::Complete => {}
        }
        Ok((line, name))
    }
}

/// Uploads a scene from its loaded files.
fn show(inputs: Inputs, gpu: &Arc<Gpu>, config: &SceneConfig, pace: &Pace, watch: Watch<'_>) -> Result<Show, AppError> {
    let animations = inputs.model.as_ref().map(Animations::of).unwrap_or_default();
    let set = set(config, inputs, gpu, Some(&pace.moving(&config.render_settings())), watch)?;
    let surroundings = Surroundings::new(config.environment.clone(), set.surroundings.clone());
    Ok(Show::of(set, surroundings, animations))
}

/// Returns a configuration without the settings that the window applies separately.
fn own(config: &SceneConfig) -> SceneConfig {
    let picture = Picture { height_scale: 1.0, stretch: 1.0, ..config.picture };
    SceneConfig { picture, ..config.clone() }
}

impl Program for DemoProgram {
    fn scenes(&self) -> &[String] {
        &self.names
    }

    fn scene(&self) -> &str {
        &self.current.name
    }

    fn roughness(&self) -> OfSurfaces<f32> {
        match self.current.config.roughness {
            _ if !self.offers(Choice::Roughness) => OfSurfaces::Fixed,
            None => OfSurfaces::Own,
            Some(alpha) => OfSurfaces::Chosen(alpha),
        }
    }

    fn offers(&self, choice: Choice) -> bool {
        self.current.config.scene.offers(choice)
    }

    fn relief_color(&self) -> Option<bool> {
        Some(self.current.config.picture.options.relief_color)
    }

    fn applied_material(&self) -> OfSurfaces<String> {
        let config = &self.current.config;
        let file = match config.measured.as_slice() {
            _ if config.model.is_none() && !config.scene.offers(Choice::HeightMap) => return OfSurfaces::Fixed,
            [.., MeasuredMaterial(last)] => Some(&last.file),
            [] => config.material.folder.as_ref(),
        };
        file.map_or(OfSurfaces::Own, |file| OfSurfaces::Chosen(file_name(file)))
    }

    fn prepare(&mut self, gpu: &Arc<Gpu>, change: &SceneChange) -> Result<Option<Load>, AppError> {
        if *change == SceneChange::Complete && self.current.is_complete {
            return Ok(None);
        }
        let (line, name) = self.changed(change)?;
        let config = own(&SceneArgs { given: line.honoured() }.resolve()?);
        self.next = Some(Current { config: config.clone(), line, name, is_complete: true });
        let (gpu, pace) = (gpu.clone(), self.pace.clone());
        Ok(Some(Box::new(move || show(Inputs::load(&config)?, &gpu, &config, &pace, &|_| {}))))
    }

    fn accept(&mut self) {
        let Some(next) = self.next.take() else { return };
        self.current = next;
        if !self.names.contains(&self.current.name) {
            self.names.push(self.current.name.clone());
        }
    }

    fn surround(&mut self, environment: &str) {
        self.current.line.set("--environment", Some(environment));
    }

    fn command(&self, seen: &Seen<'_>) -> Option<String> {
        Some(command_of(&self.current.line, seen))
    }
}
