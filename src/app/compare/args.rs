//! Arguments of `leadr compare`.

use std::path::PathBuf;

use clap::Args;

use crate::app::flags::values::threshold;
use leadr_render::settings::numbers::finite;

/// Shown below the help.
pub const EXAMPLES: &str = "Examples:
  leadr compare reference.png test.png
  leadr compare reference.exr test.exr --max-flip 0.02 --error-image out/error.png && echo close enough
  leadr compare reference.png test.png --json";

/// Arguments of `leadr compare`.
#[derive(Clone, Debug, Args)]
pub struct CompareArgs {
    /// The picture that is right (PNG or EXR)
    pub reference: PathBuf,
    /// The picture to measure: the same kind and size
    pub test: PathBuf,
    /// Exit with 1 if the mean FLIP error (0 to 1) is above this
    #[arg(long, value_name = "X", value_parser = threshold)]
    pub max_flip: Option<f64>,
    /// Exit with 1 if the relative RMSE of the linear values is above this
    #[arg(long, value_name = "X", value_parser = threshold)]
    pub max_rrmse: Option<f64>,
    /// Write the FLIP error of every pixel: black is 0, pale yellow is 1
    #[arg(long, value_name = "OUT.png")]
    pub error_image: Option<PathBuf>,
    /// Exposure for FLIP of two EXR, stops
    #[arg(long, value_name = "EV", default_value = "0", allow_negative_numbers = true, value_parser = finite)]
    pub exposure: f32,
}
