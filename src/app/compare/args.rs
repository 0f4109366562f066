//! Arguments of `leadr compare`.

use std::path::PathBuf;

use clap::Args;

use crate::app::flags::values::threshold;
use leadr_render::settings::numbers::{finite, within};
use leadr_tools::metrics::Crop;

/// Examples that are printed after the help text.
pub const EXAMPLES: &str = "Examples:
  leadr compare reference.png test.png
  leadr compare reference.exr test.exr --max-flip 0.02 --error-image out/error.png && echo close enough
  leadr compare reference.exr test.exr --layer Diffuse
  leadr compare reference.png test.png --crop 64,32,256,128
  leadr compare reference.exr test.exr --mask object.png --json";

/// Arguments of `leadr compare`.
#[derive(Clone, Debug, Args)]
pub struct CompareArgs {
    /// The reference picture (PNG or EXR)
    pub reference: PathBuf,
    /// The test picture, with the file format and size of the reference
    pub test: PathBuf,
    /// Compare the layer of this name in two EXR files, such as Combined or ViewLayer.AO. Without it, the unnamed layer is compared, or
    /// one named Combined, beauty or rgba, or the only layer with colour
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Measure only this rectangle of both pictures, in pixels from the top left corner
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT")]
    pub crop: Option<Crop>,
    /// Measure only the pixels over 0.5 in this PNG, JPEG or EXR of the pictures' size: in its alpha channel if a pixel is transparent,
    /// or else in its grey. --crop also crops the mask
    #[arg(long, value_name = "FILE")]
    pub mask: Option<PathBuf>,
    /// Exit with code 1 if the mean FLIP error exceeds X, from 0 to 1
    #[arg(long, value_name = "X", value_parser = |text: &str| within(text, 0.0, 1.0))]
    pub max_flip: Option<f64>,
    /// Exit with code 1 if the relative RMSE of the linear values exceeds X, at least 0
    #[arg(long, value_name = "X", value_parser = threshold)]
    pub max_rrmse: Option<f64>,
    /// Write the FLIP error of every pixel to this image; colours range from black (0) to pale yellow (1)
    #[arg(long, value_name = "OUT.png")]
    pub error_image: Option<PathBuf>,
    /// Set the exposure for the FLIP comparison of two EXR files, in stops
    #[arg(long, value_name = "EV", default_value = "0", allow_negative_numbers = true, value_parser = finite)]
    pub exposure: f32,
}
