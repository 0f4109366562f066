//! `leadr demo`: the scene in a window, with a camera that circles what it follows.

use std::fmt;

use serde::Serialize;

use super::camera_file::CameraPose;
use super::cli::DemoArgs;
use super::config::SceneConfig;
use super::error::AppError;
use super::frame_source::DeviceInfo;
use super::orbit::Orbit;
use super::output::Output;
use super::renderer_source::render_settings;
use super::stage::{self, Inputs, Set};
use super::window::{self, Display, WindowOptions, WindowReport};
use crate::gpu::Gpu;

/// What a demo showed.
#[derive(Debug, Serialize)]
pub struct DemoReport {
    command: &'static str,
    #[serde(flatten)]
    device: DeviceInfo,
    settings: SceneConfig,
    #[serde(flatten)]
    window: WindowReport,
}

impl fmt::Display for DemoReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for file in &self.window.screenshots {
            writeln!(f, "{}", file.display())?;
        }
        write!(f, "{} frame(s) on {}", self.window.frames, self.device.device)
    }
}

/// Shows a scene until its window is closed, or for as many frames as `arguments` say.
///
/// # Errors
/// Flags or files that are wrong, no display, no device that can draw on it, a lost device; with `--validation`, any
/// validation message.
pub fn demo(arguments: &DemoArgs, output: &Output) -> Result<DemoReport, AppError> {
    let config = SceneConfig::resolve(&arguments.scene)?;
    // Files first: their faults are found in no time and need neither display nor device.
    let inputs = Inputs::load(&config)?;
    // The device must be able to draw on the display, so the display comes before it.
    let display = Display::open()?;
    let gpu = Gpu::new(&display.gpu_options(config.device.clone(), config.validation)?)?;
    let Set { renderer, animation, camera } = stage::set(&config, inputs, &gpu, output)?;
    let options = WindowOptions {
        title: "leadr".to_owned(),
        time: f64::from(arguments.time),
        exposure: config.exposure.exp2(),
        frames: arguments.frames,
        ..Default::default()
    };
    let orbit = Orbit::new(&CameraPose::of(&camera));
    let window = window::run(display, renderer, animation, orbit, render_settings(&config), options)?;
    if let Some(first) = gpu.take_validation_messages().first() {
        return Err(AppError::Failed(format!("Vulkan validation: {first}")));
    }
    let device = DeviceInfo { device: gpu.device_name().to_owned(), driver: gpu.driver_info().to_owned() };
    Ok(DemoReport { command: "demo", device, settings: config, window })
}
