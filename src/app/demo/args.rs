//! Arguments of `leadr demo`.

use std::path::PathBuf;

use clap::Args;

use super::window::pace::DEFAULT_MIN_FPS;
use crate::app::flags::scene::SceneArgs;
use leadr_render::settings::numbers::{not_negative, whole};
use leadr_render::settings::{Technique, on_off};
use leadr_tools::command::device::DeviceArgs;

/// Folder of the shader sources that this program was built from.
const SHADERS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders-glsl");

const KEYS: &str = "In the window:
  Tab                          show or hide the panel
  F1                           show or hide this help
  left drag                    orbit around the target
  right drag, shift+left drag  pan
  wheel                        zoom in and out
  space                        pause or resume time
  left, right                  step back or forward by half a second
  , .                          step back or forward by one frame
TECHNIQUES  g                            switch between the paper's grid and the visible-slope rules
  v                            use the next shadowing model: masking alone, Smith, correlated
  [ ]                          move the sun back or forward by half an hour
  t                            use the next speed of the sun: still, a day in two minutes, a day in twenty seconds
  e                            use the next environment
  c                            compare with another technique on the right; drag the dividing line
  o                            zoom out to the far view and back
  f                            fly: drag to look around, press W A S D Q E to move
  x                            copy the command that draws this picture
  F11                          full screen
  r                            reset the view, the time and the sun
  s, F12                       save a screenshot into out/
  q, Esc                       quit
Drop these files on the window:
  .hdr, .exr                   an environment
  .glb, .gltf                  a model
  FIT.json                     a measured material for the plane, the sphere or a model
  a material folder            a material for the plane or the sphere";

/// Returns the keys of the window, printed below the help. Techniques are sorted by their keys.
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
