//! The arguments of `leadr capture`, and the configuration that results from them.

use std::path::PathBuf;

use clap::Args;
use serde::{Serialize, Serializer};

use super::frames::{Moment, Timeline, Travel, spread};
use super::pattern::{FRAME, FileKind, MovingKind, OutputPattern, StillKind, whole_size};
use super::sink::comparison::sheet_size;
use crate::app::flags::scene::{SceneArgs, choice};
use crate::app::flags::values::{FrameRange, Rate, Shard, Sheet, Split, sweep};
use leadr_maps::shown::shown_path;
use leadr_render::frame::Layer;
use leadr_render::settings::Technique;
use leadr_render::settings::numbers::not_negative;
use leadr_scenes::config::SceneConfig;
use leadr_scenes::given::CommandLine;
use leadr_scenes::stage::Sweep;
use leadr_scenes::view::{Size, ViewChoice};
use leadr_tools::command::device::DeviceArgs;
use leadr_tools::command::error::AppError;

/// Examples that are printed after the help text.
pub const EXAMPLES: &str = "Examples:
  leadr capture                                       draw the T-rex into out/
  leadr capture --camera far --samples 16 -o far.png
  leadr capture --frames 0..48 --fps 24 -o 'out/walk-{frame}.png' --resume
  leadr capture --frames 0..48 --shard 2/8 -o 'out/walk-{frame}.png'
  leadr capture --frames 0..48 --fps 24 -o walk.webp
  leadr capture --frames 0..48 --fps 24 --size 480x270 -o walk.webp
  leadr capture --frames 0..48 --fps 24 -o - | ffmpeg -i - -vf setparams=colorspace=bt709 walk.mp4
  leadr capture --frames 0..60 --sweep 5..200 -o 'out/away-{frame}.png'
  leadr capture --frames 0..90 --turntable --time 0.4 -o round.webp
  leadr capture --frames 0..48 --beside normal-mip --split 0.1..0.9 -o split.webp
  leadr capture --frames 0..48 --sheet 4x3 --size 320x180 -o sheet.png
  leadr capture --scene plane --material bricks/ --techniques leadr,normal-mip,reference --size 320x180 -o techniques.png
  leadr capture --scene shore --time-of-day 6.2
  leadr capture --scene ocean --frames 0..240 --day-length 10 -o 'out/day-{frame}.png'
  leadr capture --scene plane --height-map bricks.png --height 0.02 --repeat 1
  leadr capture --layers depth,normal,covariance -o trex.exr";

/// Arguments of `leadr capture`.
#[derive(Clone, Debug, Args)]
pub struct CaptureArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Draw the animation at this time, in seconds; with --frames, only for --sweep and --turntable [default: 0]
    #[arg(long, help_heading = SEQUENCE, value_name = "SECONDS", value_parser = not_negative)]
    pub time: Option<f32>,
    /// Render frames A to B-1; frame F shows the animation at F / fps seconds
    #[arg(long, help_heading = SEQUENCE, value_name = "A..B")]
    pub frames: Option<FrameRange>,
    /// Set the frames per second, such as 24, 29.97 or 30000/1001 [default: 30]
    #[arg(long, help_heading = SEQUENCE, value_name = "F", requires = "frames")]
    pub fps: Option<Rate>,
    /// Move the camera from NEAR to FAR metres from its target, by a constant factor per frame, instead of advancing time; --fps then
    /// sets only the playback rate of a .webp or .y4m
    #[arg(long, help_heading = SEQUENCE, hide_short_help = true, value_name = "NEAR..FAR", requires = "frames", conflicts_with = "distance", value_parser = sweep)]
    pub sweep: Option<Sweep>,
    /// Move the camera once around its target instead of advancing time
    #[arg(long, help_heading = SEQUENCE, requires = "frames")]
    pub turntable: bool,
    /// Arrange COLUMNS x ROWS evenly spaced frames of --frames in one .png; --size is the size of each frame
    #[arg(long, help_heading = SEQUENCE, hide_short_help = true, value_name = "COLUMNSxROWS", requires = "frames")]
    pub sheet: Option<Sheet>,
    /// Render only every N-th frame of the range, starting with its I-th; the first is 1
    #[arg(long, help_heading = SEQUENCE, hide_short_help = true, value_name = "I/N", requires = "frames")]
    pub shard: Option<Shard>,
    /// Keep the complete files of an earlier run if the program, the settings and the input files are the same
    #[arg(long, help_heading = SEQUENCE, hide_short_help = true)]
    pub resume: bool,
    /// Play a .webp N times; 0 repeats it forever [default: 0]
    #[arg(long = "loop", help_heading = SEQUENCE, hide_short_help = true, value_name = "N", requires = "frames")]
    pub plays: Option<u16>,
    /// Draw the right side of the picture with this technique
    #[arg(long, help_heading = OUTPUT, value_name = "TECHNIQUE", value_parser = choice(Technique::Leadr), conflicts_with = "layers")]
    pub beside: Option<Technique>,
    /// Draw the picture with each of these techniques, side by side in one .png. Labels state the device time, the FLIP error and the
    /// relative RMSE against the reference technique if it is in the list, or else against the first; error images are below. The
    /// reference takes at least 64 samples. With --frames, each frame is a row
    #[arg(long, help_heading = OUTPUT, value_name = "TECHNIQUE,...", value_parser = choice(Technique::Leadr), value_delimiter = ',',
        conflicts_with_all = ["technique", "beside", "layers", "sheet", "shard", "resume"])]
    pub techniques: Vec<Technique>,
    /// Set the left edge of the right side, as a share of the width; in a sequence, A..B moves the edge from A to B and back [default: 0.5]
    #[arg(long, help_heading = OUTPUT, hide_short_help = true, value_name = "SHARE|A..B", requires = "beside")]
    pub split: Option<Split>,
    /// Write these layers in addition to the colours (EXR only)
    #[arg(long, help_heading = OUTPUT, value_name = "NAME,...", value_parser = choice(Layer::Depth), value_delimiter = ',')]
    pub layers: Vec<Layer>,
    /// Write this file: a .png or .exr, with {frame} in its name for a sequence; one .webp or .y4m for an animation; or - for a .y4m on
    /// standard output [default: out/SCENE-TECHNIQUE-CAMERA...]
    #[arg(long, short, help_heading = OUTPUT, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

const SEQUENCE: &str = "Time and sequences";
/// The help heading of the flags for files and printed results.
pub const OUTPUT: &str = "Output";

/// The complete configuration of `leadr capture`, in the units of [`CaptureArgs`].
#[derive(Clone, Debug, Serialize)]
pub struct CaptureConfig {
    /// The scene and its render settings.
    #[serde(flatten)]
    pub scene: SceneConfig,
    /// The device.
    #[serde(flatten)]
    pub device: DeviceArgs,
    /// The moments of the whole capture. A contact sheet shows some of them.
    pub timeline: Timeline,
    /// The number of frames per second of an animation file.
    #[serde(skip)]
    pub rate: Rate,
    /// The number of times that an animated WebP plays. With 0, it repeats forever.
    #[serde(rename = "loop")]
    pub plays: u16,
    /// The layers that are written in addition to the colour. They are sorted, without repeats.
    pub layers: Vec<Layer>,
    /// The technique of the right side, and the position of the split.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "name_of_beside")]
    pub beside: Option<(Technique, Split)>,
    /// The techniques of a comparison; empty for one technique.
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "names_of")]
    pub techniques: Vec<Technique>,
    /// The files to write.
    pub output: OutputPattern,
    /// Whether frames of an earlier run are kept if they match.
    pub resume: bool,
    /// The command that renders these pictures. It is recorded in their files.
    #[serde(skip)]
    pub command: String,
}

fn name_of_beside<S: Serializer>(beside: &Option<(Technique, Split)>, serializer: S) -> Result<S::Ok, S::Error> {
    beside.map(|(technique, _)| technique.name()).serialize(serializer)
}

fn names_of<S: Serializer>(techniques: &[Technique], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(techniques.iter().map(|technique| technique.name()))
}

/// Minimum number of samples per pixel of the reference in a comparison. With fewer, its noise would hide the errors of others.
const REFERENCE_SAMPLES: u32 = 64;

impl CaptureConfig {
    /// Returns the moments that will be drawn, in order.
    pub fn moments(&self) -> Vec<Moment> {
        let moments = self.timeline.moments();
        match self.output.kind {
            FileKind::Sheet { sheet } => spread(&moments, sheet.cells() as usize),
            FileKind::Comparison => {
                let drawn = |moment| self.techniques.iter().map(move |&t| Moment { technique: Some(t), ..moment });
                moments.into_iter().flat_map(drawn).collect()
            }
            _ => moments,
        }
    }

    /// Returns the number of samples per pixel of a moment, including the right side.
    pub fn samples_of(&self, moment: Moment) -> u32 {
        let samples = self.scene.picture.samples.max(1);
        match moment.technique {
            Some(technique) if technique.is_reference() => samples.max(REFERENCE_SAMPLES),
            _ => samples * if self.beside.is_some() { 2 } else { 1 },
        }
    }
}

impl CaptureArgs {
    /// Checks that the arguments are consistent, and reads the camera file if there is one. `line` has the arguments as text.
    pub fn resolve(&self, line: CommandLine) -> Result<CaptureConfig, AppError> {
        let rate = self.fps.unwrap_or(Rate::DEFAULT);
        let timeline = self.timeline(rate)?;
        let scene = self.scene.resolve()?;
        let path = self.output.clone().unwrap_or_else(|| default_output(self, &scene, &timeline));
        let compared = (!self.techniques.is_empty()).then_some(FileKind::Comparison);
        let together = self.sheet.map(|sheet| FileKind::Sheet { sheet }).or(compared);
        let output = OutputPattern::new(&path, &timeline, together)?;
        self.check_output(output.kind, &shown_path(&path)).map_err(AppError::Usage)?;
        if let Some(sheet) = self.sheet {
            whole_size(sheet, scene.size).map_err(AppError::Usage)?;
        }
        self.check_techniques(scene.size, &timeline).map_err(AppError::Usage)?;
        let mut layers = self.layers.clone();
        layers.sort_unstable();
        layers.dedup();
        let split = self.split.unwrap_or_default();
        if split.start != split.end && self.frames.is_none() {
            return Err(AppError::Usage(
                "--split A..B moves the line from frame to frame: add --frames, or give one share".to_owned(),
            ));
        }
        Ok(CaptureConfig {
            scene,
            device: self.device.clone(),
            timeline,
            rate,
            plays: self.plays.unwrap_or(0),
            layers,
            beside: self.beside.map(|technique| (technique, split)),
            techniques: self.techniques.clone(),
            output,
            resume: self.resume,
            command: command_of(line),
        })
    }

    /// Returns the camera motion that replaces time, if there is one.
    fn travel(&self) -> Option<Travel> {
        let time = f64::from(self.time.unwrap_or(0.0));
        let (sweep, turntable) = (self.sweep, self.turntable);
        (turntable || sweep.is_some()).then_some(Travel { time, sweep, turntable })
    }

    fn timeline(&self, fps: Rate) -> Result<Timeline, AppError> {
        let travel = self.travel();
        match self.frames {
            Some(_) if self.time.is_some() && travel.is_none() => Err(AppError::Usage(
                "--time and --frames exclude each other without --sweep or --turntable: leave one of them out"
                    .to_owned(),
            )),
            Some(frames) => Ok(Timeline::Sequence { frames, fps, shard: self.shard, travel }),
            None => Ok(Timeline::Still { time: f64::from(self.time.unwrap_or(0.0)) }),
        }
    }

    /// Checks that several different techniques are compared, in a sheet of at most the largest size.
    fn check_techniques(&self, size: Size, timeline: &Timeline) -> Result<(), String> {
        let techniques = &self.techniques;
        if techniques.is_empty() {
            return Ok(());
        }
        let repeats = |(index, technique): (usize, &Technique)| techniques[..index].contains(technique);
        if techniques.len() < 2 || techniques.iter().enumerate().any(repeats) {
            return Err("--techniques compares two or more different techniques: name each of them once".to_owned());
        }
        sheet_size(techniques.len(), timeline.moments().len(), size).map(drop)
    }

    /// Checks that the format of the output `shown` supports the flags.
    fn check_output(&self, kind: FileKind, shown: &str) -> Result<(), String> {
        if kind != FileKind::Still(StillKind::Exr) && !self.layers.is_empty() {
            return Err(format!("--layers needs an .exr output, and '{shown}' is none: name an .exr file"));
        }
        if self.plays.is_some() && kind != FileKind::Moving(MovingKind::Webp) {
            return Err(format!("--loop needs an animated .webp output, and '{shown}' is none: name a .webp file"));
        }
        if let FileKind::Moving(kind) = kind {
            let (rates, rate) = (kind.rates(), self.fps.unwrap_or(Rate::DEFAULT).per_second());
            if !rates.contains(&rate) {
                let (least, most) = rates.into_inner();
                let what = format!("'{shown}' supports {least} to {most} frames per second, not {rate}");
                return Err(format!("{what}: choose another --fps or format"));
            }
        } else if self.travel().is_some() && self.fps.is_some() {
            let what =
                "--fps has no effect on stills of a --sweep or --turntable: leave it out, or write a .webp or .y4m";
            return Err(what.to_owned());
        }
        if let (FileKind::Sheet { sheet }, Some(frames)) = (kind, self.frames) {
            let (cells, frames) = (sheet.cells(), frames.end - frames.start);
            if cells > frames {
                return Err(format!(
                    "--sheet needs {cells} frames, and --frames has {frames}: give more frames or fewer cells"
                ));
            }
        }
        let parts = [("--resume", self.resume), ("--shard", self.shard.is_some())];
        match parts.iter().find(|part| part.1) {
            Some((flag, _)) if !matches!(kind, FileKind::Still(_)) => Err(format!(
                "{flag} needs one file per frame, and '{shown}' is one file: name a .png or .exr with {FRAME} in it"
            )),
            _ => Ok(()),
        }
    }
}

/// Returns the command of `line` without the flags that do not change the pictures.
fn command_of(mut line: CommandLine) -> String {
    for flag in ["--output", "--device", "--validation", "--resume", "--shard"] {
        line.remove(flag);
    }
    format!("leadr capture{line}")
}

fn default_output(a: &CaptureArgs, config: &SceneConfig, timeline: &Timeline) -> PathBuf {
    let camera = match config.view {
        ViewChoice::Near => "near",
        ViewChoice::Mid => "mid",
        ViewChoice::Far => "far",
        ViewChoice::Pose(_) => "camera",
        ViewChoice::Model => "model",
    };
    let frame = match timeline {
        _ if !a.techniques.is_empty() => "-techniques".to_owned(),
        Timeline::Sequence { .. } if a.sheet.is_some() => "-sheet".to_owned(),
        Timeline::Sequence { .. } => format!("-{FRAME}"),
        Timeline::Still { .. } => String::new(),
    };
    let kind = if a.layers.is_empty() { "png" } else { "exr" };
    let technique =
        if a.techniques.is_empty() { format!("-{}", config.picture.technique.name()) } else { String::new() };
    let of_file = config.model.as_ref().and_then(|file| file.file_stem());
    let scene = of_file.map_or(config.scene.name.into(), |stem| stem.to_string_lossy());
    PathBuf::from("out").join(format!("{scene}{technique}-{camera}{frame}.{kind}"))
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::app::flags::given;
    use clap::{CommandFactory, FromArgMatches, Parser};
    use leadr_reflectance::masking::shadowing::Shadowing;
    use leadr_render::settings::{Quadrature, Technique, Terms};
    use leadr_scenes::light::SunDirection;

    #[derive(Parser)]
    struct Capture {
        #[command(flatten)]
        arguments: CaptureArgs,
    }

    /// Resolves `leadr capture …`.
    pub fn resolve(flags: &[&str]) -> Result<CaptureConfig, AppError> {
        let matches = Capture::command().try_get_matches_from([&["capture"], flags].concat());
        let matches = matches.map_err(|e| AppError::Usage(e.to_string()))?;
        let capture = Capture::from_arg_matches(&matches).unwrap();
        capture.arguments.resolve(given::<CaptureArgs>(&matches))
    }

    #[test]
    fn defaults_name_a_file_in_out() {
        let file = |flags: &[&str]| resolve(flags).unwrap().output.path(3);
        assert_eq!(file(&[]), PathBuf::from("out/trex-leadr-mid.png"));
        assert_eq!(file(&["--frames", "0..9", "--camera", "far"]), PathBuf::from("out/trex-leadr-far-0003.png"));
        assert_eq!(file(&["--frames", "0..9", "--sheet", "3x3"]), PathBuf::from("out/trex-leadr-mid-sheet.png"));
        assert_eq!(file(&["--layers", "depth"]), PathBuf::from("out/trex-leadr-mid.exr"));
    }

    #[test]
    fn flags_reach_the_configuration() {
        let flags = "--scene sphere --height-map h.png --height-scale 0.5 --sun -30,60 --technique normal-mip \
             --grid 7 --masking masking --terms diffuse-lights --no-displacement --camera near --distance \
             7 --size 64x32 --samples 9 --edge-samples 8 --seed 4 --exposure -1.5 --atlas-tile 32 \
             --roughness 0.2 --layers lod,depth,lod -o a.exr --device llvmpipe --validation --time 0.25";
        let config = resolve(&flags.split(' ').collect::<Vec<_>>()).unwrap();
        let scene = &config.scene;
        let picture = scene.picture;
        assert_eq!((scene.scene.name, picture.technique), ("sphere", Technique::NormalMip));
        assert_eq!((scene.height_map.as_deref(), picture.height_scale), (Some("h.png".as_ref()), 0.5));
        assert_eq!(scene.sun, Some(SunDirection { azimuth: -30.0, elevation: 60.0 }));
        let options = picture.options;
        assert_eq!((options.quadrature, options.shadowing), (Quadrature::Grid(7), Shadowing::None));
        assert_eq!((options.terms, picture.displacement), (Terms::DIFFUSE_LIGHTS, false));
        assert_eq!((scene.view, scene.distance), (ViewChoice::Near, Some(7.0)));
        assert_eq!((scene.size, picture.samples, scene.seed), (Size { width: 64, height: 32 }, 9, 4));
        assert_eq!(options.edge_samples, 8);
        assert_eq!((picture.exposure, scene.atlas_tile, scene.roughness), (-1.5, 32, Some(0.2)));
        assert_eq!((config.device.device.as_deref(), config.device.validation), (Some("llvmpipe"), true));
        assert_eq!(config.layers, [Layer::Depth, Layer::Lod]);
        assert_eq!(config.timeline, Timeline::Still { time: 0.25 });
    }

    #[test]
    fn contradictions_are_wrong_usage() {
        let cases: [&[&str]; 47] = [
            &["--time-of-day", "6", "--sun", "0,10"],
            &["--time-of-day", "25"],
            &["--day-length", "60", "--environment", "studio"],
            &["--relief-shadows"],
            &["--edge-samples", "0"],
            &["--edge-samples", "4", "--technique", "reference"],
            &["--sweep", "1..2"],
            &["--frames", "0..4", "--sweep", "1..2", "--distance", "3"],
            &["--frames", "0..4", "--sweep", "1..2", "--fps", "3"],
            &["--layers", "depth", "-o", "a.png"],
            &["--frames", "0..4", "-o", "a.png"],
            &["-o", "a-{frame}.png"],
            &["--frames", "0..4", "--time", "1"],
            &["--frames", "0..4", "--time", "1", "-o", "a.webp"],
            &["--shard", "1/2"],
            &["--fps", "24"],
            &["--height-map", "h.png"],
            &["--grid", "0"],
            &["--samples", "0"],
            &["-o", "a.webp"],
            &["--frames", "0..4", "-o", "a-{frame}.webp"],
            &["--frames", "0..4", "-o", "a.webp", "--resume"],
            &["--frames", "0..4", "-o", "a.webp", "--shard", "1/2"],
            &["--frames", "0..4", "-o", "a.webp", "--layers", "depth"],
            &["--frames", "0..4", "-o", "a.gif"],
            &["--frames", "0..4", "-o", "a.webp", "--fps", "0.005"],
            &["--frames", "0..4", "-o", "a.webp", "--fps", "120"],
            &["--frames", "0..4", "-o", "a.webp", "--loop", "65536"],
            &["--turntable"],
            &["--sheet", "2x2"],
            &["--frames", "0..4", "--sheet", "2x2", "-o", "a.exr"],
            &["--frames", "0..4", "--sheet", "2x2", "-o", "a.webp"],
            &["--frames", "0..4", "--sheet", "2x2", "-o", "a-{frame}.png"],
            &["--frames", "0..4", "--sheet", "5x1"],
            &["--frames", "0..4", "--sheet", "2x2", "--resume"],
            &["--frames", "0..4", "--sheet", "2x2", "--shard", "1/2"],
            &["--frames", "0..4", "--sheet", "2x2", "--layers", "depth"],
            &["--frames", "0..4", "--sheet", "2x2", "--loop", "1"],
            &["--frames", "0..4", "--sheet", "4x1", "--size", "8192x4"],
            &["--frames", "0..4", "--turntable", "--fps", "24"],
            &["--frames", "0..4", "--loop", "2"],
            &["--frames", "0..4", "-o", "a.y4m", "--loop", "2"],
            &["--frames", "0..4", "-o", "-", "--resume"],
            &["--frames", "0..4", "-o", "-", "--shard", "1/2"],
            &["-o", "-"],
            &["--loop", "2"],
            &["--fps", "0", "--frames", "0..4"],
        ];
        for flags in cases {
            assert_eq!(resolve(flags).expect_err(&flags.join(" ")).exit_code(), 2, "{flags:?}");
        }
    }
}
