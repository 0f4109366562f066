//! The scenes that the window can open, and the `leadr capture` commands for their pictures.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::command_line::{Seen, command_of};
use super::window::pace::Pace;
use super::window::show::{OfSurfaces, Program, Show};
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

/// The current scene of `leadr demo` and its command line.
pub struct DemoProgram {
    config: SceneConfig,
    line: CommandLine,
    names: Vec<String>,
    name: String,
    pace: Pace,
    /// Whether `config` is shown at full detail.
    is_complete: bool,
}

impl DemoProgram {
    /// Starts with `config`, which was resolved from `line`.
    pub fn new(config: SceneConfig, line: CommandLine, pace: Pace) -> Self {
        let name = config.model.as_ref().map_or(config.scene.name.into(), |file| file.to_string_lossy().into_owned());
        let mut names: Vec<String> = SCENES.iter().map(|scene| scene.name.to_owned()).collect();
        if !names.contains(&name) {
            names.push(name.clone());
        }
        Self { config: own(&config), line, names, name, pace, is_complete: true }
    }

    /// Opens the first scene. On a software device its maps are coarse, so that the first picture appears sooner.
    pub fn begin(&mut self, inputs: Inputs, gpu: &Arc<Gpu>, watch: Watch<'_>) -> Result<Show, AppError> {
        let coarse = self.config.scene.first_tile(self.config.atlas_tile).filter(|_| gpu.is_software());
        self.is_complete = coarse.is_none();
        let tile = coarse.unwrap_or(self.config.atlas_tile);
        self.show_with(inputs, gpu, &SceneConfig { atlas_tile: tile, ..self.config.clone() }, watch)
    }

    /// Shows the scene of another command line at full detail.
    fn show_line(&mut self, gpu: &Arc<Gpu>, line: CommandLine) -> Result<Show, AppError> {
        let config = own(&SceneArgs { given: line.honoured() }.resolve()?);
        let show = self.show(gpu, &config, &|_| {})?;
        (self.config, self.line, self.is_complete) = (config, line, true);
        Ok(show)
    }

    /// Shows the scene with one flag changed, or removed if `value` is `None`.
    fn show_with_flag(
        &mut self,
        gpu: &Arc<Gpu>,
        flag: &str,
        value: Option<impl Into<OsString>>,
    ) -> Result<Show, AppError> {
        let mut line = self.line.clone();
        line.set(flag, value);
        self.show_line(gpu, line)
    }

    /// Loads and uploads the scene of a configuration.
    fn show(&self, gpu: &Arc<Gpu>, config: &SceneConfig, watch: Watch<'_>) -> Result<Show, AppError> {
        self.show_with(Inputs::load(config)?, gpu, config, watch)
    }

    /// Uploads a scene from its loaded files.
    fn show_with(
        &self,
        inputs: Inputs,
        gpu: &Arc<Gpu>,
        config: &SceneConfig,
        watch: Watch<'_>,
    ) -> Result<Show, AppError> {
        let first = self.pace.moving(&config.render_settings());
        let set = set(config, inputs, gpu, Some(&first), watch)?;
        let surroundings = Surroundings::new(config.environment.clone(), set.surroundings.clone());
        Ok(Show::of(set, surroundings))
    }
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
        &self.name
    }

    fn open(&mut self, gpu: &Arc<Gpu>, name: &Path) -> Result<Show, AppError> {
        let shown = name.to_string_lossy().into_owned();
        let mut line = self.line.clone();
        line.enter(shown.clone());
        ["--camera", "--distance"].into_iter().for_each(|flag| line.remove(flag));
        let show = self.show_line(gpu, line)?;
        if !self.names.contains(&shown) {
            self.names.push(shown.clone());
        }
        self.name = shown;
        Ok(show)
    }

    fn roughness(&self) -> OfSurfaces<f32> {
        match self.config.roughness {
            _ if !self.config.scene.offers(Choice::Roughness) => OfSurfaces::Fixed,
            None => OfSurfaces::Own,
            Some(alpha) => OfSurfaces::Chosen(alpha),
        }
    }

    fn offers(&self, choice: Choice) -> bool {
        self.config.scene.offers(choice)
    }

    fn remake(&mut self, gpu: &Arc<Gpu>, flag: &str, value: Option<String>) -> Result<Show, AppError> {
        self.show_with_flag(gpu, flag, value)
    }

    fn keeps_relief_color(&self) -> bool {
        self.config.picture.options.relief_color
    }

    fn applied_material(&self) -> OfSurfaces<String> {
        let config = &self.config;
        let file = match config.measured.as_slice() {
            _ if config.model.is_none() && !config.scene.offers(Choice::HeightMap) => return OfSurfaces::Fixed,
            [.., MeasuredMaterial(last)] => Some(&last.file),
            [] => config.material.folder.as_ref(),
        };
        let name = |file: &PathBuf| file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        file.map_or(OfSurfaces::Own, |file| OfSurfaces::Chosen(name(file)))
    }

    fn apply_material(&mut self, gpu: &Arc<Gpu>, material: Option<&Path>) -> Result<Show, AppError> {
        if self.config.model.is_some() {
            if let Some(folder) = material.filter(|material| material.is_dir()) {
                let fault =
                    "a material folder is for the plane and the sphere: drop a measured material, FIT.json, on a model";
                return Err(AppError::Usage(format!("{}: {fault}", shown_path(folder))));
            }
            let value = material.map(|file| [OsStr::new("*="), file.as_os_str()].into_iter().collect::<OsString>());
            self.show_with_flag(gpu, "--measured", value)
        } else {
            self.config.scene.check_offers("--material", Choice::HeightMap).map_err(AppError::Usage)?;
            self.show_with_flag(gpu, "--material", material.map(Path::as_os_str))
        }
    }

    fn complete(&mut self, gpu: &Arc<Gpu>) -> Result<Option<Show>, AppError> {
        if self.is_complete {
            return Ok(None);
        }
        self.is_complete = true;
        self.show(gpu, &self.config, &|_| {}).map(Some)
    }

    fn surround(&mut self, environment: &str) {
        self.line.set("--environment", Some(environment));
    }

    fn command(&self, seen: &Seen<'_>) -> Option<String> {
        Some(command_of(&self.line, seen))
    }
}
