//! `leadr demo`: shows a scene in a window with an orbit camera.

pub mod args;
pub mod command_line;
pub mod orbit;
pub mod program;
pub mod window;

use std::fmt;

use serde::Serialize;

use self::args::DemoArgs;
use self::program::DemoProgram;
use self::window::layout::Layout;
use self::window::pace::{KeptQuality, Pace};
use self::window::{Display, WindowOptions, WindowReport};
use leadr_maps::shown::{shown, shown_path};
use leadr_render::light::panorama::EnvironmentLight;
use leadr_scenes::config::SceneConfig;
use leadr_scenes::given::CommandLine;
use leadr_scenes::set::Inputs;
use leadr_tools::command::device::{DeviceArgs, DeviceInfo};
use leadr_tools::command::error::AppError;
use leadr_tools::command::output::Output;

/// The configuration of `leadr demo`.
#[derive(Debug, Serialize)]
struct DemoConfig {
    #[serde(flatten)]
    scene: SceneConfig,
    #[serde(flatten)]
    device: DeviceArgs,
}

/// The result of `leadr demo`.
#[derive(Debug, Serialize)]
pub struct DemoReport {
    command: &'static str,
    #[serde(flatten)]
    device: DeviceInfo,
    settings: DemoConfig,
    /// The lights extracted from the environment image.
    lights: Vec<EnvironmentLight>,
    #[serde(flatten)]
    window: WindowReport,
}

impl fmt::Display for DemoReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for file in &self.window.screenshots {
            writeln!(f, "{}", shown_path(file))?;
        }
        write!(f, "{} frame(s) on {}", self.window.frames, shown(&self.device.device))?;
        let [median, slow] = self.window.frame_times();
        if median > 0.0 {
            write!(f, ", {median:.1} ms per frame (median; 95th percentile {slow:.1} ms)")?;
        }
        Ok(())
    }
}

/// Shows a scene until the window closes or `--frames` frames are drawn. Then prints the report. `line` has the flags of the user.
pub fn run(arguments: &DemoArgs, line: CommandLine, output: &Output) -> Result<(), AppError> {
    let config = arguments.scene.resolve()?;
    // Files are read first, so that errors in files are reported even without a display or a device.
    let inputs = Inputs::load(&config)?;
    // The device must be able to present on the display, so the display is opened first.
    let display = Display::open()?;
    let device = arguments.device.clone();
    let gpu = leadr_render::open_gpu(&display.gpu_options(device.device.clone(), device.validation)?)?;
    // Quality flags that the user sets also apply while the picture moves.
    let given = &arguments.scene.given;
    let msaa = given.has("msaa").then_some(config.msaa);
    let kept = KeptQuality { msaa, probes: given.has("probes"), min_fps: arguments.min_fps };
    let settings = config.render_settings();
    let sized = line.value("--size").is_some();
    let mut program = DemoProgram::new(config.clone(), line, Pace::on(&gpu, kept));
    let show = program.begin(inputs, &gpu, &output.set_up())?;
    let lights = show.renderer.environment().lights().to_vec();
    // With --frames, the result must not depend on a stored layout.
    let layout_file = Layout::file().filter(|_| arguments.frames.is_none());
    let mut layout = match &layout_file {
        Some(file) if !arguments.fresh_layout => Layout::read(file).unwrap_or_else(|fault| {
            tracing::warn!("{fault}");
            Layout::default()
        }),
        _ => Layout::default(),
    };
    layout.panel = arguments.panel.or(layout.panel);
    layout.size = layout.size.filter(|_| !sized);
    let options = WindowOptions {
        title: "leadr".to_owned(),
        time: f64::from(arguments.time),
        picture: Some(config.picture),
        frames: arguments.frames,
        kept,
        layout,
        layout_file,
        hot_reload: arguments.hot_reload.clone(),
        ..Default::default()
    };
    let window = window::run(display, show, settings, &mut program, options)?;
    if let Some(first) = gpu.take_validation_messages().first() {
        return Err(AppError::Failed(format!("Vulkan validation: {first}")));
    }
    let settings = DemoConfig { scene: config, device };
    output.result(&DemoReport { command: "demo", device: DeviceInfo::of(&gpu), settings, lights, window })
}
