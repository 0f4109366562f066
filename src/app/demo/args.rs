//! Arguments of `leadr demo`.

use std::path::PathBuf;

use clap::Args;

use super::window::pace::DEFAULT_MIN_FPS;
use crate::app::flags::scene::SceneArgs;
use leadr_render::settings::numbers::{not_negative, whole};
use leadr_render::settings::on_off;
use leadr_tools::command::device::DeviceArgs;

/// The folder of the shader sources from which this program was built.
const SHADERS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders-glsl");

/// Arguments of `leadr demo`.
#[derive(Clone, Debug, Args)]
pub struct DemoArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Start the animation at this time, in seconds
    #[arg(long, help_heading = "Window", value_name = "SECONDS", default_value = "0", value_parser = not_negative)]
    pub time: f32,
    /// Close the window after N frames
    #[arg(long, help_heading = "Window", value_name = "N", value_parser = |text: &str| whole(text, 1, u64::MAX))]
    pub frames: Option<u64>,
    /// Keep N frames per second while anything moves, with simpler shading and then with fewer pixels; 0 keeps all pixels
    #[arg(long, help_heading = "Window", hide_short_help = true, value_name = "N", default_value_t = DEFAULT_MIN_FPS, value_parser = not_negative)]
    pub min_fps: f32,
    /// Recompile the shaders in this folder when they change, and use them if they compile
    #[arg(long, help_heading = "Window", hide_short_help = true, value_name = "FOLDER", num_args = 0..=1, default_missing_value = SHADERS)]
    pub hot_reload: Option<PathBuf>,
    /// Open the window with or without the panel [default: as in the last session; in the first session, with the panel if there is room]
    #[arg(long, help_heading = "Window", value_name = "on|off", value_parser = on_off)]
    pub panel: Option<bool>,
    /// Ignore the stored layout of the window; with --frames, the layout is neither used nor stored
    #[arg(long, help_heading = "Window", hide_short_help = true)]
    pub fresh_layout: bool,
}
