//! From raw arguments to a configuration that can only be right: files are read, flags agree with each other.

use std::path::PathBuf;

use clap::ValueEnum;
use serde::Serialize;

use super::camera_file::CameraPose;
use super::cli::{CaptureArgs, SceneArgs};
use super::error::AppError;
use super::frames::{FRAME, FileKind, OutputPattern, Timeline};
use super::values::{CameraChoice, EnvironmentChoice, Layer, SceneKind, Size, Sun};
use super::waves::Waves;
use crate::render::settings::Shading;

/// From where the scene is seen, with a camera file read.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum View {
    /// The scene's close view.
    Near,
    /// The scene fills the picture.
    Mid,
    /// The scene is small.
    Far,
    /// Given by the user.
    Pose(CameraPose),
}

/// What is drawn and how; units as in [`SceneArgs`].
#[derive(Clone, Debug, Serialize)]
pub struct SceneConfig {
    /// Which scene.
    #[serde(rename = "scene")]
    pub kind: SceneKind,
    /// Height map of the plane or sphere.
    pub height_map: Option<PathBuf>,
    /// The waves of the ocean.
    pub waves: Waves,
    /// Factor on the displacement, 0 or more.
    pub height_scale: f32,
    /// Light from all around.
    pub environment: EnvironmentChoice,
    /// Direction to the sun, at the beginning.
    pub sun: Sun,
    /// Hour of the day at the beginning, instead of `sun`.
    pub time_of_day: Option<f32>,
    /// Seconds in which the sun goes round; none where it stands.
    pub day_length: Option<f32>,
    /// How the surface is filtered and shaded.
    #[serde(flatten)]
    pub shading: Shading,
    /// Whether heights move the surface.
    pub displacement: bool,
    /// Screen pixels per triangle.
    pub triangle_pixels: f32,
    /// From where.
    pub view: View,
    /// Distance to the camera's target, metres, instead of the view's own.
    pub distance: Option<f32>,
    /// Pixels.
    pub size: Size,
    /// Samples per pixel.
    pub samples: u32,
    /// Seed of the sample positions.
    pub seed: u64,
    /// Stops over what the sun asks for, for PNG and window.
    pub exposure: f32,
    /// Texels along an atlas tile: a power of two, 8 to 128.
    pub atlas_tile: u32,
    /// Beckmann roughness of the whole surface instead of the scene's own.
    pub roughness: Option<f32>,
    /// Device by name or index.
    #[serde(skip)]
    pub device: Option<String>,
    /// Validation layers on.
    pub validation: bool,
}

impl SceneConfig {
    /// Resolves the arguments and reads the camera file, if one is named.
    ///
    /// # Errors
    /// [`AppError::Usage`] if flags contradict each other, [`AppError::Failed`] if a file is wrong.
    pub fn resolve(arguments: &SceneArgs) -> Result<Self, AppError> {
        let a = arguments.clone();
        if !matches!(a.scene, SceneKind::Plane | SceneKind::Sphere) && a.height_map.is_some() {
            let fault = "--height-map is for --scene plane or sphere; the other scenes bring their own";
            return Err(AppError::Usage(fault.into()));
        }
        let waves = a.waves.resolve(a.scene == SceneKind::Ocean)?;
        let moves = a.time_of_day.or(a.day_length).is_some();
        if moves && a.environment != EnvironmentChoice::Sky {
            let fault = "--time-of-day and --day-length are for --environment sky; a picture has its own light";
            return Err(AppError::Usage(fault.into()));
        }
        let shading = a.shading.resolve(a.edge_samples, a.relief_shadows)?;
        let view = match &a.camera {
            CameraChoice::Near => View::Near,
            CameraChoice::Mid => View::Mid,
            CameraChoice::Far => View::Far,
            CameraChoice::File(file) => View::Pose(CameraPose::read(file)?),
        };
        Ok(Self {
            kind: a.scene,
            height_map: a.height_map,
            waves,
            height_scale: a.height_scale,
            environment: a.environment,
            sun: a.sun,
            time_of_day: a.time_of_day,
            day_length: a.day_length,
            shading,
            displacement: !a.no_displacement,
            triangle_pixels: a.triangle_pixels,
            view,
            distance: a.distance,
            size: a.size,
            samples: a.samples,
            seed: a.seed,
            exposure: a.exposure,
            atlas_tile: a.atlas_tile,
            roughness: a.roughness,
            device: a.device.device,
            validation: a.device.validation,
        })
    }
}

/// Everything that `leadr capture` needs to know; units as in [`CaptureArgs`].
#[derive(Clone, Debug, Serialize)]
pub struct CaptureConfig {
    /// What is drawn and how.
    #[serde(flatten)]
    pub scene: SceneConfig,
    /// Which moments.
    pub timeline: Timeline,
    /// What is written beside the colour, each once, in a fixed order.
    pub layers: Vec<Layer>,
    /// Where to.
    pub output: OutputPattern,
    /// Keep complete frames that are already there.
    pub resume: bool,
}

impl CaptureConfig {
    /// Resolves the arguments and reads the camera file, if one is named.
    ///
    /// # Errors
    /// [`AppError::Usage`] if flags contradict each other, [`AppError::Failed`] if a file is wrong.
    pub fn resolve(arguments: &CaptureArgs) -> Result<Self, AppError> {
        let a = arguments.clone();
        let timeline = match a.frames {
            Some(frames) => Timeline::Sequence { frames, fps: f64::from(a.fps), shard: a.shard, sweep: a.sweep },
            None => Timeline::Still { time: f64::from(a.time) },
        };
        let path = a.output.clone().unwrap_or_else(|| default_output(&a, &timeline));
        let output = OutputPattern::new(&path, &timeline)?;
        if output.kind == FileKind::Png && !a.layers.is_empty() {
            return Err(AppError::Usage(format!("--layers needs an .exr output, not '{}'", path.display())));
        }
        let mut layers = a.layers;
        layers.sort_unstable();
        layers.dedup();
        let scene = SceneConfig::resolve(&a.scene)?;
        Ok(Self { scene, timeline, layers, output, resume: a.resume })
    }
}

fn default_output(a: &CaptureArgs, timeline: &Timeline) -> PathBuf {
    let name = |value: Option<clap::builder::PossibleValue>| value.map_or(String::new(), |v| v.get_name().to_owned());
    let camera = match &a.scene.camera {
        CameraChoice::Near => "near",
        CameraChoice::Mid => "mid",
        CameraChoice::Far => "far",
        CameraChoice::File(_) => "camera",
    };
    let frame = if matches!(timeline, Timeline::Sequence { .. }) { format!("-{FRAME}") } else { String::new() };
    let kind = if a.layers.is_empty() { "png" } else { "exr" };
    let (scene, technique) = (name(a.scene.scene.to_possible_value()), a.scene.shading.technique.name());
    PathBuf::from("out").join(format!("{scene}-{technique}-{camera}{frame}.{kind}"))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::app::cli::{Cli, Command};
    use crate::reflectance::masking::shadowing::Shadowing;
    use crate::render::settings::{Quadrature, Technique, Terms};
    use clap::Parser;

    /// Resolves `leadr capture …`.
    pub(in crate::app) fn resolve(flags: &[&str]) -> Result<CaptureConfig, AppError> {
        let Command::Capture(arguments) = Cli::try_parse_from([&["leadr", "capture"], flags].concat())
            .map_err(|e| AppError::Usage(e.to_string()))?
            .command
        else {
            unreachable!("the command is capture")
        };
        CaptureConfig::resolve(&arguments)
    }

    #[test]
    fn defaults_name_a_file_in_out() {
        let file = |flags: &[&str]| resolve(flags).unwrap().output.path(3);
        assert_eq!(file(&[]), PathBuf::from("out/trex-leadr-mid.png"));
        assert_eq!(file(&["--frames", "0..9", "--camera", "far"]), PathBuf::from("out/trex-leadr-far-0003.png"));
        assert_eq!(file(&["--layers", "depth"]), PathBuf::from("out/trex-leadr-mid.exr"));
    }

    #[test]
    fn flags_reach_the_configuration() {
        let config = resolve(&[
            "--scene",
            "plane",
            "--height-map",
            "h.png",
            "--height-scale",
            "0.5",
            "--sun",
            "-30,60",
            "--technique",
            "normal-mip",
            "--grid",
            "7",
            "--masking",
            "masking",
            "--terms",
            "diffuse-lights",
            "--no-displacement",
            "--camera",
            "near",
            "--distance",
            "7",
            "--size",
            "64x32",
            "--samples",
            "9",
            "--edge-samples",
            "8",
            "--seed",
            "4",
            "--exposure",
            "-1.5",
            "--atlas-tile",
            "32",
            "--roughness",
            "0.2",
            "--layers",
            "lod,depth,lod",
            "-o",
            "a.exr",
            "--device",
            "llvmpipe",
            "--validation",
            "--time",
            "0.25",
        ])
        .unwrap();
        let scene = &config.scene;
        assert_eq!((scene.kind, scene.shading.technique()), (SceneKind::Plane, Technique::NormalMip));
        assert_eq!((scene.height_map.as_deref(), scene.height_scale), (Some("h.png".as_ref()), 0.5));
        assert_eq!((scene.sun.azimuth, scene.sun.elevation), (-30.0, 60.0));
        let shading = scene.shading;
        let integral = shading.integral().unwrap();
        assert_eq!((integral.quadrature, integral.shadowing), (Quadrature::Grid(7), Shadowing::None));
        assert_eq!((shading.terms(), scene.displacement), (Terms::DIFFUSE_LIGHTS, false));
        assert_eq!((scene.view, scene.distance), (View::Near, Some(7.0)));
        assert_eq!((scene.size, scene.samples, scene.seed), (Size { width: 64, height: 32 }, 9, 4));
        assert_eq!(shading.edge_samples(), Some(8));
        assert_eq!((scene.exposure, scene.atlas_tile, scene.roughness), (-1.5, 32, Some(0.2)));
        assert_eq!((scene.device.as_deref(), scene.validation), (Some("llvmpipe"), true));
        assert_eq!(config.layers, [Layer::Depth, Layer::Lod]);
        assert_eq!(config.timeline, Timeline::Still { time: 0.25 });
    }

    #[test]
    fn contradictions_are_wrong_usage() {
        let cases: [&[&str]; 18] = [
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
            &["--shard", "1/2"],
            &["--fps", "24"],
            &["--height-map", "h.png"],
            &["--grid", "0"],
            &["--samples", "0"],
        ];
        for flags in cases {
            assert_eq!(resolve(flags).expect_err(&flags.join(" ")).exit_code(), 2, "{flags:?}");
        }
    }
}
