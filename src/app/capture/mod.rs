//! `leadr capture`: renders moments of a scene. Each moment is written to its own file, or all are written to one file. Incomplete files
//! have temporary names.

pub mod args;
pub mod frame_source;
pub mod frames;
pub mod pattern;
pub mod recipe;
pub mod renderer_source;
pub mod save;
pub mod sink;

use std::fmt;
use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::time::Instant;

use serde::Serialize;

use self::args::{CaptureArgs, CaptureConfig};
use self::frame_source::{Frame, FrameSource, PassTime};
use self::frames::Moment;
use self::pattern::{FileKind, MovingKind, StillKind};
use self::recipe::Recipe;
use self::sink::Earlier;
use self::sink::comparison::TechniqueErrors;
use leadr_maps::reads::recorded;
use leadr_maps::shown::{shown, shown_path};
use leadr_maps::tonemap::Tonemap;
use leadr_render::light::panorama::EnvironmentLight;
use leadr_scenes::given::CommandLine;
use leadr_scenes::view::Size;
use leadr_tools::command::device::DeviceInfo;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::{begin, keep_inputs};
use leadr_tools::command::output::Output;
use leadr_tools::command::stop;

/// The result of a capture.
#[derive(Debug, Serialize)]
pub struct CaptureReport<'a> {
    command: &'static str,
    #[serde(flatten)]
    device: DeviceInfo,
    settings: &'a CaptureConfig,
    /// The lights extracted from the environment image.
    lights: Vec<EnvironmentLight>,
    frames: Vec<FrameReport>,
    /// Measured differences of `--techniques`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    errors: Vec<TechniqueErrors>,
    /// Wall-clock time of the set-up, seconds: reading files, baking and uploading maps, creating pipelines.
    set_up_seconds: f64,
    /// The wall-clock time for drawing and writing all frames in seconds, without the set-up.
    seconds: f64,
}

/// The result for one frame of a capture.
#[derive(Debug, Serialize)]
pub struct FrameReport {
    #[serde(flatten)]
    moment: Moment,
    /// The file of this frame, or the file of all frames.
    file: PathBuf,
    /// Whether the file was kept from an earlier run (`--resume`).
    kept: bool,
    /// Whether this run replaced the file of an earlier run, because its fingerprint differed (`--resume`).
    outdated: bool,
    passes: Vec<PassTime>,
}

impl fmt::Display for CaptureReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.frames.len();
        let noun = if count == 1 { "frame" } else { "frames" };
        let (seconds, set_up) = (self.seconds, self.set_up_seconds);
        write!(f, "{count} {noun} in {seconds:.1} s after {set_up:.1} s of set-up on {}", shown(&self.device.device))?;
        match self.frames.iter().filter(|frame| frame.kept).count() {
            0 => {}
            kept => write!(f, ", {kept} of them kept from an earlier run")?,
        }
        match self.frames.iter().filter(|frame| frame.outdated).count() {
            0 => Ok(()),
            outdated => write!(f, ", {outdated} of them drawn again, because the existing files did not match"),
        }
    }
}

/// Renders the selected moments. Prints the name of each completed file, and then the report. `line` has the arguments as text.
pub fn run(arguments: &CaptureArgs, line: CommandLine, output: &Output) -> Result<(), AppError> {
    let (config, read_first) = recorded(|| arguments.resolve(line));
    let config = config?;
    check_stdout(&config, output)?;
    check_files(&config)?;
    unheeded(&config).into_iter().chain(odd_video(&config)).for_each(|remark| output.say(remark));
    let source = renderer_source::open(&config, output)?;
    let files: Vec<PathBuf> = config.moments().iter().map(|moment| config.output.path(moment.frame)).collect();
    keep_inputs(
        files.iter().map(PathBuf::as_path),
        source.files.iter().chain(&read_first).map(|read| read.path.as_path()),
    )?;
    output.summary(&capture(&config, source, output)?)
}

/// Refuses a video on standard output if this is a terminal, or if `--json` also writes to standard output.
fn check_stdout(config: &CaptureConfig, output: &Output) -> Result<(), AppError> {
    if !config.output.is_stdout() {
        return Ok(());
    }
    if output.is_json() {
        return Err(AppError::Usage("--json and '-o -' both write to standard output: give -o a file name".to_owned()));
    }
    if io::stdout().is_terminal() {
        return Err(AppError::Usage("'-o -' writes a video to the terminal: pipe it, or name a .y4m file".to_owned()));
    }
    Ok(())
}

/// Returns a remark if display settings have no effect because the file stores radiance. Such settings are not an error, because the flags
/// are valid for a PNG.
fn unheeded(config: &CaptureConfig) -> Option<&'static str> {
    let chosen = config.scene.picture.exposure != 0.0 || config.scene.picture.tonemap != Tonemap::SHOWN;
    let is_exr = config.output.kind == FileKind::Still(StillKind::Exr);
    (is_exr && chosen).then_some("an EXR holds linear radiance: --exposure and --tonemap affect only a PNG")
}

/// Returns a remark about the size of a video that most players could not show. The video itself has full colour resolution (4:4:4), so any
/// size is valid.
fn odd_video(config: &CaptureConfig) -> Option<&'static str> {
    let Size { width, height } = config.scene.size;
    let is_odd = width % 2 == 1 || height % 2 == 1;
    (config.output.kind == FileKind::Moving(MovingKind::Y4m) && is_odd).then_some(
        "the width or the height is odd: the .y4m is valid (4:4:4), but encoders refuse it for 4:2:0 (yuv420p); choose an even --size \
         for that",
    )
}

/// Checks before any work that the files can be written, and removes the partial files of killed runs.
fn check_files(config: &CaptureConfig) -> Result<(), AppError> {
    if config.output.is_stdout() {
        return Ok(());
    }
    // All files are in one folder, so one check suffices.
    config.moments().first().map_or(Ok(()), |first| begin(&config.output.path(first.frame)).map(drop))
}

/// Renders and writes every moment of `config` with `source`.
///
/// # Errors
/// If rendering or writing fails. The message names the frame. Files that are already written remain.
pub fn capture<'a>(
    config: &'a CaptureConfig,
    mut source: FrameSource<'_>,
    output: &Output,
) -> Result<CaptureReport<'a>, AppError> {
    let start = Instant::now();
    let moments = config.moments();
    let recipe = Recipe::new(config, &source.files);
    let count = moments.len();
    let bar = output.bar(moments.iter().map(|&moment| config.samples_of(moment) as usize).sum(), "rendering");
    let mut before = 0;
    let mut sink = sink::open(config)?;
    let own_files = matches!(config.output.kind, FileKind::Still(_));
    // One file for all frames is removed when the capture is stopped.
    let lost = if own_files || config.output.is_stdout() {
        String::new()
    } else {
        format!("; {} is not written", shown_path(config.output.path(0)))
    };
    let mut frames = Vec::with_capacity(moments.len());
    for (index, moment) in moments.into_iter().enumerate() {
        let (file, origin) = (config.output.path(moment.frame), recipe.origin(moment));
        let samples = config.samples_of(moment);
        let tell = |done: u32| {
            // A narrow terminal cuts off the end.
            bar.message(&format!("rendering {}: {}", part(index, count, moment, [done, samples]), shown_path(&file)));
            bar.at(before + done as usize);
        };
        tell(0);
        if index == 0 {
            stop::reached(format!("before frame {}{lost}", moment.frame));
        }
        let earlier = sink.earlier(&file, &origin);
        let (kept, outdated) = (earlier == Earlier::Same, earlier == Earlier::Outdated);
        let passes = if kept {
            Vec::new()
        } else {
            let frame = render_frame(config, &mut source, moment, &mut { tell })?;
            sink.put(&file, &frame, &origin)?;
            frame.passes
        };
        before += samples as usize;
        stop::reached(format!("after frame {}{lost}", moment.frame));
        if own_files {
            output.file(&file, &bar)?;
        }
        frames.push(FrameReport { moment, file, kept, outdated, passes });
    }
    let errors = sink.finish()?;
    if !own_files && !config.output.is_stdout() {
        output.file(&config.output.path(0), &bar)?;
    }
    drop(bar);
    let seconds = start.elapsed().as_secs_f64();
    let FrameSource { device, lights, set_up_seconds, .. } = source;
    Ok(CaptureReport { command: "capture", device, settings: config, lights, frames, errors, set_up_seconds, seconds })
}

/// Returns the words for the frame and the sample that are being drawn.
fn part(index: usize, count: usize, moment: Moment, [done, samples]: [u32; 2]) -> String {
    let mut words = format!("frame {} of {count}", index + 1);
    if samples > 1 {
        words += &format!(", sample {} of {samples}", (done + 1).min(samples));
    }
    words + &moment.technique.map_or_else(String::new, |technique| format!(", {}", technique.name()))
}

/// Renders one moment and checks the size, the layers and the values of the frame.
fn render_frame(
    config: &CaptureConfig,
    source: &mut FrameSource<'_>,
    moment: Moment,
    done: &mut dyn FnMut(u32),
) -> Result<Frame, AppError> {
    let fault = |what: String| AppError::Failed(format!("frame {}: {what}", moment.frame));
    let frame = (source.render)(moment, done).map_err(|e| fault(e.to_string()))?;
    let (width, height) = (config.scene.size.width, config.scene.size.height);
    let pixels = width as usize * height as usize;
    if (frame.width, frame.height) != (width, height) || frame.color.len() != pixels {
        return Err(fault(format!("the renderer returned {}x{} pixels", frame.width, frame.height)));
    }
    for &layer in &config.layers {
        let planes = frame.layers.iter().find(|(name, _)| *name == layer).map(|(_, planes)| planes);
        let right = planes.is_some_and(|p| p.len() == layer.channels().len() && p.iter().all(|c| c.len() == pixels));
        if !right {
            return Err(fault(format!("the renderer returned no {} layer", layer.channels()[0])));
        }
    }
    if let Some(at) = frame.color.iter().position(|c| !c.iter().all(|v| v.is_finite())) {
        let (x, y) = (at % width as usize, at / width as usize);
        return Err(fault(format!("the radiance at pixel ({x}, {y}) is not finite: {:?}", frame.color[at])));
    }
    Ok(frame)
}

#[cfg(test)]
pub mod tests {
    use super::args::tests::resolve;
    use super::*;
    use leadr_maps::RgbImage;
    use leadr_maps::origin::Origin;
    use leadr_maps::save::{save_exr_rgb, save_png};
    use leadr_render::frame::Layer;
    use leadr_scenes::config::SceneConfig;
    use std::path::Path;

    /// A test renderer that draws a gradient depending on the time. The renderer counts its calls, and fails at a chosen frame.
    #[derive(Default)]
    pub struct Double {
        pub size: (u32, u32),
        pub layers: Vec<Layer>,
        pub calls: u32,
        pub fail_at: Option<u32>,
        pub poison: bool,
    }

    impl Double {
        /// Creates a test renderer with the size and layers of `config`.
        pub fn new(config: &CaptureConfig) -> Self {
            let Size { width, height } = config.scene.size;
            Self { size: (width, height), layers: config.layers.clone(), ..Self::default() }
        }
    }

    impl Double {
        fn source(&mut self) -> FrameSource<'_> {
            FrameSource {
                device: DeviceInfo { device: "double".into(), driver: "none".into() },
                files: Vec::new(),
                lights: Vec::new(),
                set_up_seconds: 0.0,
                render: Box::new(|moment, done| self.render(moment, done)),
            }
        }

        pub fn render(&mut self, moment: Moment, done: &mut dyn FnMut(u32)) -> Result<Frame, AppError> {
            self.calls += 1;
            done(1);
            if self.fail_at == Some(moment.frame) {
                return Err(AppError::Failed("the device was lost".into()));
            }
            let (width, height) = self.size;
            let pixels = (width * height) as usize;
            let brighter = moment.technique.map_or(0.0, |technique| technique.name().len() as f32);
            let value = |i: usize| (i as f32 + moment.time as f32 + brighter) / (pixels as f32 + 1.0);
            let mut color: Vec<_> = (0..pixels).map(|i| [value(i), 0.5, 0.0, 1.0]).collect();
            if self.poison {
                color[pixels - 1][0] = f32::NAN;
            }
            let planes = |layer: Layer| layer.channels().iter().map(|_| (0..pixels).map(value).collect()).collect();
            let layers = self.layers.iter().map(|&layer| (layer, planes(layer))).collect();
            let passes = vec![PassTime { pass: "geometry".into(), ms: 1.5 }];
            Ok(Frame { width, height, color, layers, exposure: 1.0, passes })
        }
    }

    /// Returns a configuration for pictures of 5x3 pixels, written to `name` in `folder`.
    pub fn configure(folder: &Path, name: &str, flags: &[&str]) -> CaptureConfig {
        let path = folder.join(name);
        resolve(&[&["--size", "5x3", "-o", path.to_str().unwrap()], flags].concat()).unwrap()
    }

    /// Returns the scene of `config` for a picture of this size.
    pub fn sized(config: &CaptureConfig, width: u32, height: u32) -> SceneConfig {
        SceneConfig { size: Size { width, height }, ..config.scene.clone() }
    }

    /// Returns the sorted names of all files in `folder`.
    pub fn files(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs a capture and returns its report as JSON.
    pub fn run(config: &CaptureConfig, double: &mut Double) -> Result<serde_json::Value, AppError> {
        capture(config, double.source(), &Output::new(true, true)).map(|report| serde_json::to_value(&report).unwrap())
    }

    #[test]
    fn the_same_call_gives_the_same_bytes_and_another_moment_does_not() {
        let folder = tempfile::tempdir().unwrap();
        for kind in ["png", "exr"] {
            let mut bytes = Vec::new();
            for time in ["1", "1", "3"] {
                let config = configure(folder.path(), &format!("a.{kind}"), &["--time", time]);
                run(&config, &mut Double::new(&config)).unwrap();
                bytes.push(std::fs::read(config.output.path(0)).unwrap());
            }
            assert_eq!(bytes[0], bytes[1]);
            assert_ne!(bytes[1], bytes[2]);
        }
        assert_eq!(files(folder.path()), ["a.exr", "a.png"]);
    }

    #[test]
    fn progress_names_the_frame_first() {
        let config = configure(Path::new("out"), "a.webp", &["--frames", "0..24"]);
        let moment = config.moments()[0];
        assert_eq!(part(0, 24, moment, [0, 1]), "frame 1 of 24");
        assert_eq!(part(2, 24, moment, [4, 4]), "frame 3 of 24, sample 4 of 4");
    }

    #[test]
    fn shards_write_the_frames_of_the_whole_range() {
        let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let flags = ["--frames", "3..8"];
        let config = configure(whole.path(), "{frame}.png", &flags);
        run(&config, &mut Double::new(&config)).unwrap();
        for shard in ["1/2", "2/2"] {
            let config = configure(parts.path(), "{frame}.png", &[&flags[..], &["--shard", shard]].concat());
            run(&config, &mut Double::new(&config)).unwrap();
        }
        assert_eq!(files(whole.path()), ["0003.png", "0004.png", "0005.png", "0006.png", "0007.png"]);
        assert_eq!(files(whole.path()), files(parts.path()));
        for name in files(whole.path()) {
            let read = |folder: &Path| std::fs::read(folder.join(&name)).unwrap();
            assert_eq!(read(whole.path()), read(parts.path()), "{name}");
        }
    }

    #[test]
    fn failed_range_resumes_and_redraws_damaged_frames() {
        let folder = tempfile::tempdir().unwrap();
        for kind in ["png", "exr"] {
            let config = configure(folder.path(), &format!("{{frame}}.{kind}"), &["--frames", "0..5", "--resume"]);
            let mut double = Double { fail_at: Some(3), ..Double::new(&config) };
            let fault = run(&config, &mut double).unwrap_err().to_string();
            assert!(fault.contains("frame 3") && fault.contains("lost"), "{fault}");
            let intact = std::fs::read(config.output.path(1)).unwrap();
            std::fs::write(config.output.path(1), &intact[..intact.len() - 20]).unwrap();

            let mut double = Double::new(&config);
            let report = run(&config, &mut double).unwrap();
            assert_eq!(double.calls, 3, "frames 1 (damaged), 3 and 4");
            let kept: Vec<_> = (0..5).map(|i| report["frames"][i]["kept"].as_bool().unwrap()).collect();
            assert_eq!(kept, [true, false, true, false, false]);
            assert_eq!(std::fs::read(config.output.path(1)).unwrap(), intact);

            let other_size = CaptureConfig { scene: sized(&config, 4, 3), ..config };
            let mut double = Double::new(&other_size);
            run(&other_size, &mut double).unwrap();
            assert_eq!(double.calls, 5, "frames of another size are not kept");
        }
    }

    #[test]
    fn frames_of_other_or_unknown_settings_are_redrawn() {
        let folder = tempfile::tempdir().unwrap();
        for kind in ["png", "exr"] {
            let name = format!("{{frame}}.{kind}");
            let drawn = |flags: &[&str]| {
                let config = configure(folder.path(), &name, &[&["--frames", "0..3", "--resume"], flags].concat());
                let mut double = Double::new(&config);
                let report = capture(&config, double.source(), &Output::new(true, true)).unwrap();
                (double.calls, report.to_string())
            };
            let (calls, message) = drawn(&["--technique", "constant"]);
            assert!(calls == 3 && !message.contains("again"), "{calls}: {message}");
            let (calls, message) = drawn(&["--technique", "leadr"]);
            assert!(
                calls == 3 && message.contains("3 of them drawn again") && !message.contains("kept"),
                "{calls}: {message}"
            );
            let (calls, message) = drawn(&[]);
            assert!(
                calls == 0 && message.contains("3 of them kept") && !message.contains("again"),
                "{calls}: {message}"
            );
            // A picture from another program has no fingerprint, even if its size matches.
            let config = configure(folder.path(), &name, &["--frames", "0..3"]);
            let texels = vec![[0.5; 3]; 15];
            match kind {
                "png" => save_png(config.output.path(1), &RgbImage::new(5, 3, texels).unwrap(), 1.0, Tonemap::Clamp),
                _ => save_exr_rgb(config.output.path(1), &RgbImage::new(5, 3, texels).unwrap()),
            }
            .unwrap();
            let (calls, message) = drawn(&[]);
            assert!(calls == 1 && message.contains("1 of them drawn again"), "{calls}: {message}");
        }
    }

    #[test]
    fn frames_name_the_command_that_makes_them() {
        let folder = tempfile::tempdir().unwrap();
        for kind in ["png", "exr"] {
            let config = configure(folder.path(), &format!("a.{kind}"), &["--seed", "7", "--resume", "--validation"]);
            run(&config, &mut Double::new(&config)).unwrap();
            let file = config.output.path(0);
            let origin = match kind {
                "png" => Origin::of_png(&std::fs::read(file).unwrap()).unwrap(),
                _ => Origin::of_exr(&file).unwrap(),
            };
            assert_eq!(origin.command, "leadr capture --size 5x3 --seed 7");
            assert!(origin.software.starts_with("leadr "), "{origin:?}");
        }
    }

    #[test]
    fn targets_are_checked_and_leftovers_removed_first() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("far.png"), "").unwrap();
        let fault = check_files(&configure(folder.path(), "far.png/x.png", &[])).unwrap_err().to_string();
        assert!(fault.contains("far.png"), "{fault}");
        std::fs::write(folder.path().join(".leadr-0123456789abcdef.part"), "").unwrap();
        check_files(&configure(folder.path(), "{frame}.png", &["--frames", "0..2"])).unwrap();
        assert_eq!(files(folder.path()), ["far.png"]);
    }

    #[test]
    fn failed_write_keeps_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let blocked = folder.path().join("folder.png");
        std::fs::create_dir(&blocked).unwrap();
        let config = configure(folder.path(), "folder.png", &[]);
        let fault = run(&config, &mut Double::new(&config)).unwrap_err().to_string();
        assert!(fault.contains("folder.png"), "{fault}");
        assert_eq!(files(folder.path()), ["folder.png"]);
    }

    #[test]
    fn flags_ignored_by_exr_are_reported() {
        let message = |name: &str, flags: &[&str]| unheeded(&configure(Path::new("out"), name, flags)).is_some();
        assert!(message("a.exr", &["--exposure", "1"]) && message("a.exr", &["--tonemap", "clamp"]));
        assert!(!message("a.exr", &[]) && !message("a.png", &["--exposure", "1", "--tonemap", "clamp"]));
    }

    #[test]
    fn odd_videos_are_reported_before_drawing() {
        let remark = |name: &str, size: &str| {
            odd_video(&resolve(&["--frames", "0..2", "--size", size, "-o", name]).unwrap()).is_some()
        };
        assert!(remark("a.y4m", "5x4") && remark("a.y4m", "4x5") && remark("a.y4m", "5x3"));
        assert!(!remark("a.y4m", "4x4") && !remark("a.webp", "5x3"));
    }

    #[test]
    fn folders_are_made_and_one_pixel_is_enough() {
        let folder = tempfile::tempdir().unwrap();
        let config = configure(folder.path(), "a/b/c.exr", &[]);
        let config = CaptureConfig { scene: sized(&config, 1, 1), ..config };
        run(&config, &mut Double::new(&config)).unwrap();
        assert!(config.output.path(0).is_file());
    }

    #[test]
    fn non_finite_radiance_reports_its_pixel() {
        let folder = tempfile::tempdir().unwrap();
        let config = configure(folder.path(), "a.png", &[]);
        let mut double = Double { poison: true, ..Double::new(&config) };
        let fault = run(&config, &mut double).unwrap_err().to_string();
        assert!(fault.contains("(4, 2)"), "{fault}");
        assert!(files(folder.path()).is_empty());
    }

    #[test]
    fn a_missing_layer_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let config = configure(folder.path(), "a.exr", &["--layers", "depth,normal"]);
        let mut double = Double { layers: vec![Layer::Depth], ..Double::new(&config) };
        assert!(run(&config, &mut double).unwrap_err().to_string().contains("normal"));
        run(&config, &mut Double::new(&config)).unwrap();
    }

    #[test]
    fn report_states_device_and_revision() {
        let folder = tempfile::tempdir().unwrap();
        let config = configure(folder.path(), "a.png", &["--time", "0.5"]);
        let report = run(&config, &mut Double::new(&config)).unwrap();
        assert_eq!((&report["command"], &report["device"]), (&"capture".into(), &"double".into()));
        assert_eq!(report["settings"]["technique"], "leadr");
        assert_eq!(report["frames"][0]["time"], 0.5);
        assert_eq!(report["frames"][0]["passes"][0]["pass"], "geometry");
    }
}
