//! Arguments of `leadr demo`.

use std::path::PathBuf;

use clap::Args;

use super::window::pace::DEFAULT_MIN_FPS;
use crate::app::flags::scene::SceneArgs;
use leadr_render::settings::numbers::{not_negative, whole};
use leadr_render::settings::{Technique, on_off};
use leadr_tools::command::device::DeviceArgs;

/// The sources that this program was built from.
const SHADERS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders-glsl");

const KEYS: &str = "In the window:
  Tab                          the panel
  F1                           this help
  left drag                    turn around the target
  right drag, shift+left drag  pan
  wheel                        move closer, away
  space                        stop time, let it run
  left, right                  half a second back, forward
  , .                          a frame back, forward
TECHNIQUES  g                            the paper's grid, the visible-slope rules
  v                            shadowing model: masking alone, Smith, correlated
  [ ]                          the sun half an hour back, forward
  t                            the sun stands still, goes round in two minutes, in twenty seconds
  e                            the next environment; or drop a .hdr or .exr on the window, a .glb or .gltf model,
                               or what the plane, the sphere or a model is made of: a FIT.json, a folder
  c                            another technique on the right; drag the line between them
  o                            zoom out to the far view and back
  f                            fly: drag to look, W A S D Q E to move
  x                            copy the command that makes this picture
  F11                          the whole screen
  r                            back to the first view and time
  s, F12                       save a screenshot into out/
  q, Esc                       quit";

/// Shown below the help: the keys of the window, those of the techniques in their order.
pub fn keys() -> String {
    let mut techniques = Technique::ALL;
    techniques.sort_unstable_by_key(|technique| technique.key());
    let lines = techniques.map(|technique| format!("  {:<28} {}\n", technique.key(), technique.name()));
    KEYS.replace("TECHNIQUES", &lines.concat())
}

/// Arguments of `leadr demo`.
#[derive(Clone, Debug, Args)]
pub struct DemoArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Start the animation at this moment, seconds
    #[arg(long, help_heading = "Window", value_name = "SECONDS", default_value = "0", value_parser = not_negative)]
    pub time: f32,
    /// Close the window after N frames
    #[arg(long, help_heading = "Window", value_name = "N", value_parser = |text: &str| whole(text, 1, u64::MAX))]
    pub frames: Option<u64>,
    /// Keep this many frames a second while something moves, by simpler shading and at last by fewer pixels; 0 keeps all pixels
    #[arg(long, help_heading = "Window", hide_short_help = true, value_name = "N", default_value_t = DEFAULT_MIN_FPS, value_parser = not_negative)]
    pub min_fps: f32,
    /// Compile shaders that change while the window is open, and draw with them once they work
    #[arg(long, help_heading = "Window", hide_short_help = true, value_name = "FOLDER", num_args = 0..=1, default_missing_value = SHADERS)]
    pub hot_reload: Option<PathBuf>,
    /// Show or hide the panel at first [default: as it was left; the first time shown where there is room]
    #[arg(long, help_heading = "Window", value_name = "on|off", value_parser = on_off)]
    pub panel: Option<bool>,
    /// Open the window as the first time, not as it was left; --frames implies this and stores nothing
    #[arg(long, help_heading = "Window", hide_short_help = true)]
    pub fresh_layout: bool,
}
