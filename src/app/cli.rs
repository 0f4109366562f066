//! The command line as it is written. Only commands and flags that work are offered.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use super::report::ReportSection;
use super::shading::{ShadingArgs, techniques};
use super::values::{
    CameraChoice, EnvironmentChoice, FrameRange, Layer, SceneKind, Shard, Size, Sun, atlas_tile, fft, finite, hour,
    not_negative, positive, roughness, sweep,
};
use super::waves::WaveArgs;
use crate::render::settings::Technique;
use crate::scenes::stage::Sweep;

/// Renders displaced surfaces that keep their look at every distance (LEADR mapping).
#[derive(Debug, Parser)]
#[command(name = "leadr", version, propagate_version = true, arg_required_else_help = true)]
#[command(after_help = "Exit codes: 0 done, 1 failed or over a threshold, 2 wrong usage.
Set LEADR_LOG (error, warn, info, debug, trace) for more on stderr.")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// How to report it.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Flags of every command.
#[derive(Clone, Copy, Debug, Args)]
pub struct OutputArgs {
    /// Print the result as one JSON object on stdout
    #[arg(long, global = true, display_order = 900)]
    pub json: bool,
    /// No progress and no result text; errors (and --json) remain
    #[arg(long, short, global = true, display_order = 901)]
    pub quiet: bool,
}

/// Flags of every command that needs a Vulkan device.
#[derive(Clone, Debug, Args)]
pub struct DeviceArgs {
    /// Vulkan device, by part of its name or by index
    #[arg(long, value_name = "NAME|INDEX")]
    pub device: Option<String>,
    /// Turn the Vulkan validation layers on; any message is an error
    #[arg(long)]
    pub validation: bool,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Look around the scene in a window
    #[cfg(feature = "window")]
    #[command(after_help = demo_keys())]
    Demo(Box<DemoArgs>),
    /// Render a picture or a sequence without a window
    #[command(after_help = CAPTURE_EXAMPLES)]
    Capture(Box<CaptureArgs>),
    /// Time every pass on the device: the paper's tables, scenes and a zoom, with ratios
    #[command(after_help = BENCH_EXAMPLES)]
    Bench(Box<BenchArgs>),
    /// Measure how far two pictures are apart: FLIP, relative RMSE, largest difference
    #[command(after_help = COMPARE_EXAMPLES)]
    Compare(CompareArgs),
    /// Measure again what the papers show, and write it as one page of tables, pictures and plots
    #[command(after_help = REPORT_EXAMPLES)]
    Report(ReportArgs),
}

#[cfg(feature = "window")]
const DEMO_KEYS: &str = "In the window:
  left drag                    turn around the target
  right drag, shift+left drag  pan
  wheel                        closer, away
  space                        stop time, let it run
  left, right                  half a second back or on
  , .                          a frame back or on
TECHNIQUES  g                            the paper's grid, or the visible-slope rules
  v                            shadowing model: masking alone, Smith, correlated
  [ ]                          the sun half an hour back or on
  t                            the sun stands, a day in two minutes, in twenty seconds
  r                            the view and time of the beginning
  s, F12                       save a screenshot into out/
  q, Esc                       end";

/// [`DEMO_KEYS`] with those of the techniques, in the order of the keys.
#[cfg(feature = "window")]
fn demo_keys() -> String {
    let mut techniques = Technique::ALL;
    techniques.sort_unstable_by_key(|technique| technique.key());
    let lines = techniques.map(|technique| format!("  {:<28} {}\n", technique.key(), technique.name()));
    DEMO_KEYS.replace("TECHNIQUES", &lines.concat())
}

const CAPTURE_EXAMPLES: &str = "Examples:
  leadr capture                                       the T-rex, into out/
  leadr capture --camera far --samples 16 -o far.png
  leadr capture --frames 0..48 --fps 24 -o 'out/walk-{frame}.png' --resume
  leadr capture --frames 0..48 --shard 2/8 -o 'out/walk-{frame}.png'
  leadr capture --frames 0..60 --sweep 5..200 -o 'out/away-{frame}.png'
  leadr capture --scene shore --time-of-day 6.2
  leadr capture --scene ocean --frames 0..240 --day-length 10 -o 'out/day-{frame}.png'
  leadr capture --scene plane --height-map bricks.png --height-scale 0.05 --distance 20
  leadr capture --layers depth,normal,covariance -o trex.exr";

const COMPARE_EXAMPLES: &str = "Examples:
  leadr compare reference.png test.png
  leadr compare reference.exr test.exr --max-flip 0.02 --error-image out/error.png && echo close enough
  leadr compare reference.png test.png --json";

const REPORT_EXAMPLES: &str = "Examples:
  leadr report                                  everything, into out/report; takes half an hour without a GPU
  leadr report --quick -o out/quick             everything, small, in minutes
  leadr report --only convergence -o out/one    a single section";

/// Flags of `leadr report`.
#[derive(Clone, Debug, Args)]
pub struct ReportArgs {
    /// Small pictures and few samples
    #[arg(long)]
    pub quick: bool,
    /// Only these sections
    #[arg(long, value_name = "NAME,...", value_enum, value_delimiter = ',')]
    pub only: Vec<ReportSection>,
    /// Take over the sections that an earlier run of this program on this device left in the folder
    #[arg(long)]
    pub resume: bool,
    /// Folder of the report: index.html, report.json and the pictures
    #[arg(long, short, value_name = "DIR", default_value = "out/report")]
    pub output: PathBuf,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArgs,
}

const BENCH_EXAMPLES: &str = "Examples:
  leadr bench                                  everything: minutes without a GPU
  leadr bench --paper --frames 9 --json        a full-screen quad over a LEADR map of its size, and the goals
  leadr bench --scene sphere --size 512x512
  leadr bench --scene trex --technique leadr
  leadr bench --scene ocean --frames 9         every pass of the sea, by size of transform and of picture
  leadr bench --scene ocean --soak 5000 --size 64x48 --fft 64

Times are medians over frames on the device itself. Rows are measured turn and turn about, and ratios taken within
each turn, so another program slows the rows down but hardly moves the ratios.";

/// Flags of `leadr bench`.
#[derive(Clone, Debug, Args)]
pub struct BenchArgs {
    /// Only this scene, mid and from afar [default: the paper's tables, sphere and trex]
    #[arg(long, value_enum)]
    pub scene: Option<SceneKind>,
    /// Only this technique in scenes [default: all]
    #[arg(long, value_name = "NAME", value_parser = techniques())]
    pub technique: Option<Technique>,
    /// Size of the pictures, pixels [default: 1024x1024 for the paper's tables, 512x512 for scenes]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// Rounds: frames of every row, but for rows of over a second
    #[arg(long, value_name = "N", default_value = "15", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub frames: u32,
    /// Only the paper's tables (with --scene or --technique: too), its Figure 11 and variants of both
    #[arg(long)]
    pub paper: bool,
    /// Of the paper's tables only the rows that goals compare: seconds
    #[arg(long, requires = "paper")]
    pub goals: bool,
    /// Height map of the plane or the sphere (PNG or EXR)
    #[arg(long, value_name = "FILE", requires = "scene")]
    pub height_map: Option<PathBuf>,
    /// Samples along the edge of the ocean's tiles of waves: 64, 128, 256 or 512 [default: 256]
    #[arg(long, value_name = "N", value_parser = fft, requires = "scene")]
    pub fft: Option<u32>,
    /// Instead of timing, draw so many frames of the ocean or the shore, a day long, and watch what memory does
    #[arg(long, value_name = "FRAMES", requires = "scene", conflicts_with = "paper", value_parser = clap::value_parser!(u32).range(1..))]
    pub soak: Option<u32>,
    /// Texels along a patch's tile in the displacement atlas: 8, 16, 32, 64 or 128
    #[arg(long, value_name = "N", default_value = "64", value_parser = atlas_tile)]
    pub atlas_tile: u32,
    /// Edge samples of every technique of a scene but the reference, see capture
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub edge_samples: u32,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Flags of `leadr compare`.
#[derive(Clone, Debug, Args)]
pub struct CompareArgs {
    /// What is right (PNG or EXR)
    pub reference: PathBuf,
    /// What is held against it: the same kind and size
    pub test: PathBuf,
    /// End with 1 if the mean FLIP error (0 to 1) is over this
    #[arg(long, value_name = "X", value_parser = not_negative)]
    pub max_flip: Option<f32>,
    /// End with 1 if the relative RMSE of the linear values is over this
    #[arg(long, value_name = "X", value_parser = not_negative)]
    pub max_rrmse: Option<f32>,
    /// Write the FLIP error of every pixel: black is none, pale yellow is 1
    #[arg(long, value_name = "OUT.png")]
    pub error_image: Option<PathBuf>,
    /// Exposure at which two EXR are looked at, stops
    #[arg(long, value_name = "EV", default_value = "0", allow_negative_numbers = true, value_parser = finite)]
    pub exposure: f32,
}

/// Flags of every command that draws a scene.
#[derive(Clone, Debug, Args)]
pub struct SceneArgs {
    /// What is drawn
    #[arg(long, value_enum, default_value = "trex")]
    pub scene: SceneKind,
    /// Height map of the plane or the sphere (PNG or EXR)
    #[arg(long, value_name = "FILE")]
    pub height_map: Option<PathBuf>,
    /// The waves of the ocean.
    #[command(flatten)]
    pub waves: WaveArgs,
    /// Factor on the displacement; 0 is flat
    #[arg(long, value_name = "X", default_value = "1", value_parser = not_negative)]
    pub height_scale: f32,
    /// Light from all around: the analytic sky, a studio, or an equirectangular picture
    #[arg(long, value_name = "sky|studio|FILE.hdr|FILE.exr", default_value = "sky")]
    pub environment: EnvironmentChoice,
    /// Direction to the sun, degrees: counter-clockwise from +x, and above the horizon
    #[arg(long, value_name = "AZIMUTH,ELEVATION", default_value = "-50,38", allow_hyphen_values = true)]
    pub sun: Sun,
    /// Hour at which the scene begins, instead of --sun: the sun rises in the east (+x) at half past five and sets at half past six
    #[arg(long, value_name = "HOURS", conflicts_with = "sun", value_parser = hour)]
    pub time_of_day: Option<f32>,
    /// The sun goes round the sky once in so many seconds of the scene [default: it stands still]
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub day_length: Option<f32>,
    /// How it is shaded.
    #[command(flatten)]
    pub shading: ShadingArgs,
    /// Leave the geometry smooth; the slopes of the height map shade it all the same
    #[arg(long)]
    pub no_displacement: bool,
    /// With --technique reference: bumps shadow each other, from every light and the environment; slow, wants many samples
    #[arg(long)]
    pub relief_shadows: bool,
    /// Screen pixels per triangle of the displaced surface
    #[arg(long, value_name = "PIXELS", default_value = "4", value_parser = positive)]
    pub triangle_pixels: f32,
    /// From where: a view of the scene, or a JSON file {position, target, up, fov_degrees}
    #[arg(long, value_name = "near|mid|far|FILE.json", default_value = "mid")]
    pub camera: CameraChoice,
    /// Move the camera along its view line to this distance from its target, metres
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub distance: Option<f32>,
    /// Size of the picture, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720")]
    pub size: Size,
    /// Samples per pixel (in a window: of a picture that stands still)
    #[arg(long, value_name = "N", default_value = "4", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub samples: u32,
    /// Look at the geometry at N places per sample (16, 64 and 256 are the fastest): outlines are smooth, and each surface is shaded once for what all see of it
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub edge_samples: u32,
    /// Seed of the sample positions
    #[arg(long, value_name = "N", default_value = "0")]
    pub seed: u64,
    /// Exposure of a picture that is looked at, stops over what the height of the sun asks for (an EXR keeps linear radiance)
    #[arg(long, value_name = "EV", default_value = "0", allow_negative_numbers = true, value_parser = finite)]
    pub exposure: f32,
    /// Texels along a patch's tile in the displacement atlas: 8, 16, 32, 64 or 128
    #[arg(long, value_name = "N", default_value = "64", value_parser = atlas_tile)]
    pub atlas_tile: u32,
    /// Beckmann roughness of the whole surface instead of the scene's own
    #[arg(long, value_name = "A", value_parser = roughness)]
    pub roughness: Option<f32>,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Flags of `leadr demo`.
#[cfg(feature = "window")]
#[derive(Clone, Debug, Args)]
pub struct DemoArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Moment at which the animation starts, seconds
    #[arg(long, value_name = "SECONDS", default_value = "0", value_parser = not_negative)]
    pub time: f32,
    /// Close the window after N frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub frames: Option<u64>,
}

/// Flags of `leadr capture`.
#[derive(Clone, Debug, Args)]
pub struct CaptureArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Moment of the animation, seconds
    #[arg(long, value_name = "SECONDS", default_value = "0", conflicts_with = "frames", value_parser = not_negative)]
    pub time: f32,
    /// Render frames A to B-1; frame F shows the time F / fps
    #[arg(long, value_name = "A..B")]
    pub frames: Option<FrameRange>,
    /// Frames per second
    #[arg(long, value_name = "F", default_value = "30", requires = "frames", value_parser = positive)]
    pub fps: f32,
    /// Frames are steps away from the target, each by the same factor, instead of steps in time
    #[arg(long, value_name = "NEAR..FAR", requires = "frames", conflicts_with_all = ["distance", "fps"], value_parser = sweep)]
    pub sweep: Option<Sweep>,
    /// Render only every N-th frame, starting with the I-th
    #[arg(long, value_name = "I/N", requires = "frames")]
    pub shard: Option<Shard>,
    /// Keep frames that are already there, complete and of the right size
    #[arg(long)]
    pub resume: bool,
    /// Write these beside the colour (EXR only)
    #[arg(long, value_name = "NAME,...", value_enum, value_delimiter = ',')]
    pub layers: Vec<Layer>,
    /// Where to: OUT.png, OUT.exr, or with {frame} for a sequence [default: out/SCENE-TECHNIQUE-CAMERA...]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_declaration_is_consistent() {
        Cli::command().debug_assert();
    }
}
