//! Arguments of `leadr demo`.

use clap::Args;

use crate::app::flags::device::DeviceArgs;
use crate::app::flags::scene::SceneArgs;
use crate::app::flags::values::not_negative;
use crate::render::settings::Technique;

const KEYS: &str = "In the window:
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
  r                            back to the first view and time
  s, F12                       save a screenshot into out/
  q, Esc                       quit";

/// Shown below the help: the keys of the window, those of the techniques in their order.
#[must_use]
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
    /// Moment at which the animation starts, seconds
    #[arg(long, value_name = "SECONDS", default_value = "0", value_parser = not_negative)]
    pub time: f32,
    /// Close the window after N frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub frames: Option<u64>,
}
