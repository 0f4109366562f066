//! The scenes that the window can open, and the commands that make their pictures without it.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::command_line::Seen;
use super::window::pace::Pace;
use super::window::show::{Program, Roughness, Show, Worn};
use super::window::surroundings::Surroundings;
use crate::app::flags::command_line::CommandLine;
use crate::app::flags::scene::scene_choice;
use leadr_gpu::Gpu;
use leadr_scenes::config::{MaterialFiles, SceneConfig};
use leadr_scenes::model::measured::MeasuredMaterial;
use leadr_scenes::model::named::NamedFile;
use leadr_scenes::registry::{Choice, SCENES};
use leadr_scenes::set::{Inputs, Watch, set};
use leadr_scenes::view::View;
use leadr_tools::command::error::AppError;

/// What `leadr demo` was asked for, and what it shows now.
pub struct DemoProgram {
    config: SceneConfig,
    line: CommandLine,
    names: Vec<String>,
    name: String,
    pace: Pace,
    /// Whether `config` is shown in all detail.
    is_complete: bool,
}

impl DemoProgram {
    /// A program that begins with `config`, which came from the flags of `line`.
    #[must_use]
    pub fn new(config: SceneConfig, line: CommandLine, pace: Pace) -> Self {
        let name = config.model.as_ref().map_or(config.scene.name.into(), |file| file.to_string_lossy().into_owned());
        let mut names: Vec<String> = SCENES.iter().map(|scene| scene.name.to_owned()).collect();
        if !names.contains(&name) {
            names.push(name.clone());
        }
        Self { config, line, names, name, pace, is_complete: true }
    }

    /// The first picture: on a processor that draws by itself, of coarse maps, which are there sooner.
    pub fn begin(&mut self, inputs: Inputs, gpu: &Arc<Gpu>, watch: Watch<'_>) -> Result<Show, AppError> {
        let coarse = self.config.scene.first_tile(self.config.atlas_tile).filter(|_| gpu.is_software());
        self.is_complete = coarse.is_none();
        let tile = coarse.unwrap_or(self.config.atlas_tile);
        self.show_with(inputs, gpu, &SceneConfig { atlas_tile: tile, ..self.config.clone() }, watch)
    }

    /// What is shown now is `config`, in all detail.
    fn shows(&mut self, config: SceneConfig) {
        self.config = config;
        self.is_complete = true;
    }

    /// Loads and uploads a configuration.
    fn show(&self, gpu: &Arc<Gpu>, config: &SceneConfig, watch: Watch<'_>) -> Result<Show, AppError> {
        self.show_with(Inputs::load(config)?, gpu, config, watch)
    }

    /// The same with files that are loaded.
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

impl Program for DemoProgram {
    fn scenes(&self) -> &[String] {
        &self.names
    }

    fn scene(&self) -> &str {
        &self.name
    }

    fn open(&mut self, gpu: &Arc<Gpu>, name: &Path) -> Result<Show, AppError> {
        let shown = name.to_string_lossy().into_owned();
        let choice = scene_choice(&shown).map_err(AppError::Usage)?;
        // What was said about one surface is not about another.
        let config = SceneConfig {
            scene: choice.scene,
            model: choice.model,
            animation: None,
            model_camera: None,
            displacements: Vec::new(),
            measured: Vec::new(),
            height_map: None,
            height: None,
            repeat: None,
            material: MaterialFiles::default(),
            bare: false,
            waves: choice.scene.waves(),
            roughness: None,
            view: View::Mid,
            distance: None,
            ..self.config.clone()
        };
        let show = self.show(gpu, &config, &|_| {})?;
        self.shows(config);
        self.line.enter(shown.clone());
        if !self.names.contains(&shown) {
            self.names.push(shown.clone());
        }
        self.name = shown;
        Ok(show)
    }

    fn roughness(&self) -> Roughness {
        match self.config.roughness {
            _ if !self.config.scene.offers(Choice::Roughness) => Roughness::Fixed,
            None => Roughness::Own,
            Some(alpha) => Roughness::Chosen(alpha),
        }
    }

    fn stretches(&self) -> bool {
        self.config.scene.offers(Choice::Stretch)
    }

    fn roughen(&mut self, gpu: &Arc<Gpu>, alpha: Option<f32>) -> Result<Show, AppError> {
        self.config.scene.check_offers("--roughness", Choice::Roughness).map_err(AppError::Usage)?;
        let config = SceneConfig { roughness: alpha, ..self.config.clone() };
        let show = self.show(gpu, &config, &|_| {})?;
        self.shows(config);
        self.line.set("--roughness", alpha.map(|alpha| alpha.to_string()));
        Ok(show)
    }

    fn worn(&self) -> Worn {
        let config = &self.config;
        let file = match config.measured.as_slice() {
            _ if config.model.is_none() && !config.scene.offers(Choice::HeightMap) => return Worn::Fixed,
            [.., MeasuredMaterial(last)] => Some(&last.file),
            [] => config.material.folder.as_ref(),
        };
        let name = |file: &PathBuf| file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        file.map_or(Worn::Own, |file| Worn::Chosen(name(file)))
    }

    fn wear(&mut self, gpu: &Arc<Gpu>, material: Option<&Path>) -> Result<Show, AppError> {
        let mut config = self.config.clone();
        let (flag, value) = if config.model.is_some() {
            if let Some(folder) = material.filter(|material| material.is_dir()) {
                let fault =
                    "a folder of maps is for the plane and the sphere; a model takes a measured material, FIT.json";
                return Err(AppError::Usage(format!("{}: {fault}", folder.display())));
            }
            let of_all = |file: &Path| MeasuredMaterial(NamedFile { material: None, file: file.to_path_buf() });
            config.measured = material.map(of_all).into_iter().collect();
            let value = material.map(|file| [OsStr::new("*="), file.as_os_str()].into_iter().collect::<OsString>());
            ("--measured", value)
        } else {
            config.scene.check_offers("--material", Choice::HeightMap).map_err(AppError::Usage)?;
            config.material.folder = material.map(Path::to_path_buf);
            ("--material", material.map(|file| file.as_os_str().to_owned()))
        };
        let show = self.show(gpu, &config, &|_| {})?;
        self.shows(config);
        self.line.set(flag, value);
        Ok(show)
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
        Some(self.line.of_picture(seen))
    }
}
