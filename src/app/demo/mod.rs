//! `leadr demo`: a scene in a window, with a camera that orbits its target.

pub mod args;
pub mod orbit;
pub mod window;

use std::fmt;

use serde::Serialize;

use self::args::DemoArgs;
use self::orbit::Orbit;
use self::window::pace::{KeptQuality, Pace};
use self::window::surroundings::Surroundings;
use self::window::{Display, WindowOptions, WindowReport};
use crate::app::error::AppError;
use crate::app::flags::device::{DeviceArgs, DeviceInfo};
use crate::app::output::Output;
use crate::gpu::Gpu;
use crate::lab::progress::Progress;
use crate::render::light::panorama::EnvironmentLight;
use crate::scenes::config::SceneConfig;
use crate::scenes::set::{Inputs, Set, set};
use crate::scenes::view::CameraPose;

/// What to show.
#[derive(Debug, Serialize)]
struct DemoConfig {
    #[serde(flatten)]
    scene: SceneConfig,
    #[serde(flatten)]
    device: DeviceArgs,
}

/// What was shown.
#[derive(Debug, Serialize)]
pub struct DemoReport {
    command: &'static str,
    #[serde(flatten)]
    device: DeviceInfo,
    settings: DemoConfig,
    /// Taken out of the picture of the environment.
    lights: Vec<EnvironmentLight>,
    #[serde(flatten)]
    window: WindowReport,
}

impl fmt::Display for DemoReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for file in &self.window.screenshots {
            writeln!(f, "{}", file.display())?;
        }
        write!(f, "{} frame(s) on {}", self.window.frames, self.device.device)?;
        let [median, slow] = self.window.frame_times();
        if median > 0.0 {
            write!(f, ", a frame every {median:.1} ms (median; 95 of 100 within {slow:.1} ms)")?;
        }
        Ok(())
    }
}

/// Shows a scene until its window is closed, or for as many frames as `arguments` say, and prints what was shown.
///
/// # Errors
/// Flags or files that are wrong, no display, no device that can draw on it, a lost device; with `--validation`, any
/// validation message.
pub fn run(arguments: &DemoArgs, output: &Output) -> Result<(), AppError> {
    output.result(&demo(arguments, output)?)
}

fn demo(arguments: &DemoArgs, output: &Output) -> Result<DemoReport, AppError> {
    let config = arguments.scene.resolve()?;
    // Files first: their errors are found at once, without display or device.
    let inputs = Inputs::load(&config)?;
    // The device must be able to draw on the display, so the display is opened first.
    let display = Display::open()?;
    let device = arguments.device.clone();
    let gpu = Gpu::new(&display.gpu_options(device.device.clone(), device.validation)?)?;
    // What is asked for is drawn in motion too.
    let kept = KeptQuality { msaa: arguments.scene.msaa, probes: arguments.scene.shading.probes.is_some() };
    let settings = config.render_settings();
    let first = Pace::on(&gpu, kept).moving(&settings);
    let Set { renderer, animation, camera, surroundings, .. } =
        set(&config, inputs, &gpu, Some(&first), &output.share(config.scene.making))?;
    let lights = renderer.environment().lights().to_vec();
    let options = WindowOptions {
        title: "leadr".to_owned(),
        time: f64::from(arguments.time),
        exposure: config.exposure.exp2(),
        frames: arguments.frames,
        kept,
        ..Default::default()
    };
    let orbit = Orbit::new(&CameraPose::of(&camera));
    let surroundings = Surroundings::new(config.environment.clone(), surroundings);
    let window = window::run(display, renderer, animation, orbit, settings, surroundings, options)?;
    if let Some(first) = gpu.take_validation_messages().first() {
        return Err(AppError::Failed(format!("Vulkan validation: {first}")));
    }
    let settings = DemoConfig { scene: config, device };
    Ok(DemoReport { command: "demo", device: DeviceInfo::of(&gpu), settings, lights, window })
}
