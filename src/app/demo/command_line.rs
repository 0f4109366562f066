//! The command that makes the picture in the window.

use std::ffi::OsString;

use super::window::choices::Choices;
use crate::app::flags::command_line::CommandLine;
use crate::app::flags::scene::{SceneArgs, scene_choice};
use leadr_maps::tonemap::Tonemap;
use leadr_render::settings::{Quadrature, ShadingOptions};
use leadr_scenes::light::SunDirection;
use leadr_scenes::registry::SCENES;
use leadr_scenes::view::CameraPose;

/// Flags about the surface of a scene, which another scene does not take over.
const OF_ONE_SCENE: [&str; 31] = [
    "--scene",
    "--animation",
    "--lenient",
    "--displacement",
    "--measured",
    "--height-map",
    "--height",
    "--repeat",
    "--material",
    "--color-map",
    "--normal-map",
    "--roughness-map",
    "--occlusion-map",
    "--cone-map",
    "--normal-y",
    "--metal",
    "--anisotropy",
    "--anisotropy-rotation",
    "--detail",
    "--detail-repeat",
    "--detail-rotation",
    "--detail-height-scale",
    "--detail-mask",
    "--wind",
    "--wind-direction",
    "--fetch",
    "--depth",
    "--choppiness",
    "--fft",
    "--bare",
    "--roughness",
];

/// Flags about pictures of an environment, which the sky refuses.
const OF_PICTURES: [&str; 4] =
    ["--environment-lights", "--environment-light-threshold", "--environment-rotation", "--auto-exposure"];

/// What of the window's picture a command must say beside its choices.
pub struct Seen<'a> {
    /// How it looks.
    pub choices: &'a Choices,
    /// From where.
    pub pose: CameraPose,
    /// When, seconds.
    pub time: f64,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Where the sun is, if the scene is under a sky.
    pub sun: Option<SunDirection>,
}

impl CommandLine {
    /// Says another scene.
    pub fn enter(&mut self, scene: impl Into<OsString>) {
        for flag in OF_ONE_SCENE {
            self.remove(flag);
        }
        self.begin_with("--scene", scene);
    }

    /// Leaves out what its scene would refuse: choices of the window outlive the scene that they were made for.
    fn keep_what_its_scene_honours(&mut self) {
        let scene = self.value("--scene").and_then(|name| scene_choice(&name.to_string_lossy()).ok());
        let scene = scene.map_or(&SCENES[0], |choice| choice.scene);
        let flags = SceneArgs::unset().map(|unset| unset.choices()).unwrap_or_default();
        flags.iter().filter(|flag| !scene.offers(flag.2)).for_each(|flag| self.remove(flag.0));
    }

    /// `leadr capture` with what makes this picture.
    #[must_use]
    pub fn of_picture(&self, seen: &Seen<'_>) -> String {
        let mut line = self.clone();
        let Seen { choices, pose, time, size: [width, height], sun } = seen;
        let (technique, options, default) = (choices.technique, choices.options, ShadingOptions::default());
        let shading = choices.shading();
        line.set("--technique", Some(technique.name()));
        for flag in ["--rule", "--grid", "--probes", "--masking", "--terms", "--pixel-kernel", "--relief-occlusion"] {
            line.remove(flag);
        }
        if line.value("--environment").is_none_or(|environment| environment == "sky") {
            OF_PICTURES.iter().for_each(|flag| line.remove(flag));
        }
        line.remove("--multiscattering");
        line.remove("--sky-occlusion");
        let on_off = |on: bool| if on { "on" } else { "off" };
        if let Some(integral) = shading.integral() {
            match integral.quadrature {
                Quadrature::Grid(side) => line.set("--grid", Some(side.to_string())),
                other if other == default.quadrature => {}
                Quadrature::VisibleSlopes(probes) => line.set("--probes", Some(probes.count().to_string())),
            }
            line.set("--masking", Some(integral.shadowing.name()));
            if integral.relief_occlusion != default.relief_occlusion {
                line.set("--relief-occlusion", Some(on_off(integral.relief_occlusion)));
            }
        } else {
            for flag in ["--diffuse-lights", "--base-frame", "--relief-color"] {
                line.remove(flag);
            }
        }
        if technique.has_pixel_kernel() && options.pixel_kernel != default.pixel_kernel {
            line.set("--pixel-kernel", Some(on_off(options.pixel_kernel)));
        }
        if technique.has_multiscattering() && options.multiscattering != default.multiscattering {
            line.set("--multiscattering", Some(on_off(options.multiscattering)));
        }
        if technique.is_lit() && !options.sky_occlusion {
            line.set("--sky-occlusion", Some("off"));
        }
        if technique.is_lit() && options.terms != default.terms {
            line.set("--terms", Some(options.terms.names().collect::<Vec<_>>().join(",")));
        }
        if technique.is_reference() {
            line.remove("--msaa");
            line.remove("--edge-samples");
        } else {
            line.remove("--relief-shadows");
        }
        line.set("--height-scale", (choices.height_scale != 1.0).then(|| choices.height_scale.to_string()));
        line.set("--stretch", (choices.stretch != 1.0).then(|| choices.stretch.to_string()));
        line.set("--triangle-pixels", (choices.triangle_pixels != 4.0).then(|| choices.triangle_pixels.to_string()));
        line.set("--samples", Some(choices.samples.to_string()));
        line.set("--exposure", (choices.exposure != 0.0).then(|| choices.exposure.to_string()));
        line.set("--tonemap", (choices.tonemap != Tonemap::SHOWN).then(|| choices.tonemap.name()));
        line.set("--size", Some(format!("{width}x{height}")));
        for flag in ["--time-of-day", "--day-length", "--sun", "--distance"] {
            line.remove(flag);
        }
        if let Some(SunDirection { azimuth, elevation }) = sun {
            line.set("--sun", Some(format!("{azimuth},{elevation}")));
        }
        let point = |[x, y, z]: [f32; 3]| format!("{x},{y},{z}");
        let camera = format!("{}:{}:{}", point(pose.position), point(pose.target), pose.fov_degrees);
        line.set("--camera", Some(camera));
        if let Some(compare) = choices.compare {
            line.set("--beside", Some(compare.technique.name()));
            line.set("--split", Some(compare.split.to_string()));
        }
        line.set("--time", Some(time.to_string()));
        line.keep_what_its_scene_honours();
        format!("leadr capture{line}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::capture::args::tests::resolve;
    use crate::app::demo::args::DemoArgs;
    use clap::{Args, Command, CommandFactory, FromArgMatches, Parser};
    use leadr_render::settings::{RenderSettings, Technique, Terms};
    use leadr_scenes::config::SceneConfig;
    use leadr_scenes::view::{Size, View};

    #[derive(Parser)]
    struct Demo {
        #[command(flatten)]
        arguments: DemoArgs,
    }

    fn given(flags: &[&str]) -> (CommandLine, SceneConfig) {
        let matches = Demo::command().try_get_matches_from([&["demo"], flags].concat()).unwrap();
        let config = Demo::from_arg_matches(&matches).unwrap().arguments.scene.resolve().unwrap();
        (CommandLine::given::<SceneArgs>(&matches), config)
    }

    /// What the shell makes of a command without quotes.
    fn captured(command: &str) -> SceneConfig {
        let words: Vec<&str> = command.split(' ').collect();
        assert_eq!(&words[..2], ["leadr", "capture"]);
        resolve(&words[2..]).unwrap().scene
    }

    const SUN: SunDirection = SunDirection { azimuth: -12.5, elevation: 30.25 };

    fn seen(choices: &Choices) -> Seen<'_> {
        Seen { choices, pose: POSE, time: 1.25, size: [640, 360], sun: Some(SUN) }
    }

    const POSE: CameraPose =
        CameraPose { position: [6.125, -8.0, 5.3], target: [0.0, 0.1, 2.0], up: [0.0, 0.0, 1.0], fov_degrees: 41.0 };

    #[test]
    fn the_command_draws_what_the_window_shows() {
        let flags = [
            "--scene",
            "sphere",
            "--roughness",
            "0.3",
            "--exposure",
            "-1",
            "--distance",
            "7",
            "--time-of-day",
            "8",
            "--masking",
            "smith",
        ];
        let (line, config) = given(&flags);
        let settings = config.render_settings();
        let mut choices = Choices::new(&settings, config.exposure);
        let drawn = captured(&line.of_picture(&seen(&choices)));
        let expected = SceneConfig {
            view: View::Pose(POSE),
            distance: None,
            time_of_day: None,
            sun: SUN,
            size: Size { width: 640, height: 360 },
            ..config.clone()
        };
        assert_eq!(drawn, expected);

        // What is about a picture is said while one is shown.
        let (mut line, of_studio) =
            given(&["--environment", "studio", "--environment-rotation", "40", "--auto-exposure"]);
        let without_sun = Seen { sun: None, ..seen(&choices) };
        let rotation = |line: &CommandLine| captured(&line.of_picture(&without_sun)).environment_rotation;
        assert_eq!((rotation(&line), of_studio.environment_rotation), (40.0, 40.0));
        line.set("--environment", Some("sky"));
        assert_eq!(rotation(&line), 0.0);

        let (line, _) = given(&flags);
        choices.technique = Technique::NormalMip;
        choices.options.quadrature = Quadrature::Grid(9);
        choices.options.terms = Terms::DIFFUSE_LIGHTS;
        choices.options.pixel_kernel = false;
        choices.height_scale = 0.5;
        choices.stretch = 1.25;
        choices.samples = 9;
        choices.triangle_pixels = 6.5;
        choices.tonemap = Tonemap::Aces;
        let drawn = captured(&line.of_picture(&seen(&choices)));
        assert_eq!(drawn.tonemap, Tonemap::Aces);
        let [expected] = choices.sides(&RenderSettings { size: (640, 360), ..settings }).try_into().unwrap();
        assert_eq!(drawn.render_settings(), expected);
        assert_eq!((drawn.height_scale, drawn.stretch), (0.5, 1.25));
        for technique in Technique::ALL {
            choices.technique = technique;
            assert_eq!(captured(&line.of_picture(&seen(&choices))).shading, choices.shading(), "{technique:?}");
        }
    }

    #[test]
    fn another_scene_has_another_surface() {
        let (mut line, _) =
            given(&["--scene", "plane", "--material", "my wall", "--no-displacement", "--samples", "2"]);
        assert_eq!(line.to_string(), " --scene plane --material 'my wall' --no-displacement --samples 2");
        line.enter("it's.glb");
        assert_eq!(line.to_string(), r" --scene 'it'\''s.glb' --no-displacement --samples 2");
        // What was chosen for one scene is not said of another that would refuse it.
        line.enter("ocean");
        let (_, config) = given(&[]);
        let choices = Choices { height_scale: 0.5, stretch: 2.0, ..Choices::new(&config.render_settings(), 0.0) };
        let drawn = captured(&line.of_picture(&seen(&choices)));
        assert_eq!((drawn.scene.name, drawn.displacement), ("ocean", true));
        assert_eq!((drawn.height_scale, drawn.stretch), (1.0, 1.0));
        let names: Vec<_> = SceneArgs::augment_args(Command::new("scene"))
            .get_arguments()
            .filter_map(|argument| argument.get_long().map(|long| format!("--{long}")))
            .collect();
        assert!(OF_ONE_SCENE.iter().all(|flag| names.iter().any(|name| name == flag)));
    }
}
