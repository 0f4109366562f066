//! Builds the `leadr capture` command that draws the picture in the window.

use super::window::choices::Choices;
use leadr_scenes::config::Picture;
use leadr_scenes::given::CommandLine;
use leadr_scenes::light::SunDirection;
use leadr_scenes::options::{SceneOption, Sets};
use leadr_scenes::view::CameraPose;

/// Options that the command includes even with their default values, because the defaults depend on files, or describe the picture.
const SAID: [&str; 3] = ["technique", "shadowing", "samples"];

/// The state of the window that the command must reproduce.
pub struct Seen<'a> {
    /// The picture settings of the window.
    pub choices: &'a Choices,
    /// The camera pose of the window.
    pub pose: CameraPose,
    /// The time of the animation in seconds.
    pub time: f64,
    /// The width and height in pixels.
    pub size: [u32; 2],
    /// The direction of the sun, if the environment is a sky.
    pub sun: Option<SunDirection>,
}

/// Returns the `leadr capture` command that draws this picture.
pub fn command_of(line: &CommandLine, seen: &Seen<'_>) -> String {
    let mut line = line.clone();
    let Seen { choices, pose, time, size: [width, height], sun } = seen;
    for option in SceneOption::all().iter().filter(|o| matches!(o.sets, Sets::Picture(_) | Sets::Shading(_))) {
        let (flag, value) = (option.spec.flag(), option.write(&choices.picture));
        let is_usual = value == option.write(&Picture::default()) && !SAID.contains(&option.spec.name);
        line.remove(&flag);
        if let Some(value) = value.filter(|_| !is_usual) {
            line.add(&flag, option.takes_value().then(|| value.into()));
        }
    }
    line.set("--size", Some(format!("{width}x{height}")));
    for flag in ["--time-of-day", "--day-length", "--sun", "--distance"] {
        line.remove(flag);
    }
    if let Some(SunDirection { azimuth, elevation }) = sun {
        line.set("--sun", Some(format!("{},{}", short(*azimuth, ANGLE), short(*elevation, ANGLE))));
    }
    let place = metres_decimals(pose);
    let point = |of: [f32; 3]| of.map(|metres| short(metres, place)).join(",");
    let camera = format!("{}:{}:{}", point(pose.position), point(pose.target), short(pose.fov_degrees, ANGLE));
    line.set("--camera", Some(camera));
    if let Some(compare) = choices.compare {
        line.set("--beside", Some(compare.technique.name()));
        line.set("--split", Some(short(compare.split, SPLIT)));
    }
    line.set("--time", Some(short(*time, TIME)));
    format!("leadr capture{}", line.honoured())
}

/// Decimals of an angle in degrees, which the renderer keeps as a vector or in radians.
const ANGLE: i32 = 4;
/// Decimals of a time in seconds.
const TIME: i32 = 4;
/// Decimals of the split, a share of the width.
const SPLIT: i32 = 5;

/// Returns the decimals of a coordinate in metres, so that rounding moves the picture by less than a hundredth of a pixel.
fn metres_decimals(pose: &CameraPose) -> i32 {
    let squares = (0..3).map(|axis| f64::from(pose.position[axis] - pose.target[axis]).powi(2));
    5 - squares.sum::<f64>().sqrt().max(1e-9).log10().floor() as i32
}

/// Formats a number with at most this many decimals, without zeros at the end. Computed numbers, such as angles of a vector, otherwise have
/// rounding errors in their last digits.
fn short(number: impl Into<f64>, decimals: i32) -> String {
    let scale = 10f64.powi(decimals);
    // Adding zero turns -0 into 0.
    ((number.into() * scale).round() / scale + 0.0).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::capture::args::tests::resolve;
    use crate::app::demo::args::DemoArgs;
    use crate::app::demo::orbit::Orbit;
    use crate::app::flags;
    use crate::app::flags::scene::SceneArgs;
    use crate::app::flags::scene::tests::other_value;
    use clap::{CommandFactory, FromArgMatches, Parser};
    use glam::Vec3;
    use leadr_maps::tonemap::Tonemap;
    use leadr_render::settings::{PixelKernel, Quadrature, RenderSettings, ShadingOptions, Technique, Terms};
    use leadr_scenes::config::SceneConfig;
    use leadr_scenes::view::{Size, ViewChoice};

    #[derive(Parser)]
    struct Demo {
        #[command(flatten)]
        arguments: DemoArgs,
    }

    fn given(flags: &[&str]) -> (CommandLine, SceneConfig) {
        let matches = Demo::command().try_get_matches_from([&["demo"], flags].concat()).unwrap();
        let config = Demo::from_arg_matches(&matches).unwrap().arguments.scene.resolve().unwrap();
        (flags::given::<SceneArgs>(&matches), config)
    }

    /// Resolves a command that contains no quotes.
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
    fn command_reproduces_the_window_picture() {
        let flags: Vec<&str> =
            "--scene sphere --roughness 0.3 --light -1,0,2,ff8000,3 --light 1,2,3,2700K,1 --exposure -1 --distance 7 --time-of-day 8 --shadowing smith"
                .split(' ')
                .collect();
        let (line, config) = given(&flags);
        let settings = config.render_settings();
        let mut choices = Choices::new(config.picture);
        let drawn = captured(&command_of(&line, &seen(&choices)));
        let expected = SceneConfig {
            view: ViewChoice::Pose(POSE),
            distance: None,
            time_of_day: None,
            sun: Some(SUN),
            size: Size { width: 640, height: 360 },
            ..config.clone()
        };
        assert_eq!(drawn, expected);

        // The flags of an environment image are included only while the image is shown.
        let (mut line, of_studio) =
            given(&["--environment", "studio", "--environment-rotation", "40", "--auto-exposure"]);
        let without_sun = Seen { sun: None, ..seen(&choices) };
        let rotation = |line: &CommandLine| captured(&command_of(line, &without_sun)).environment_rotation;
        assert_eq!((rotation(&line), of_studio.environment_rotation), (40.0, 40.0));
        line.set("--environment", Some("sky"));
        assert_eq!(rotation(&line), 0.0);

        let (line, _) = given(&flags);
        let options = ShadingOptions {
            quadrature: Quadrature::Grid(9),
            terms: Terms::DIFFUSE_LIGHTS,
            pixel_kernel: PixelKernel::Off,
            ..choices.picture.options
        };
        choices.picture = Picture {
            technique: Technique::NormalMip,
            options,
            displacement: false,
            height_scale: 0.5,
            stretch: 1.25,
            triangle_pixels: 6.5,
            samples: 9,
            exposure: -1.0,
            tonemap: Tonemap::Aces,
            dither: false,
        };
        let drawn = captured(&command_of(&line, &seen(&choices)));
        let [expected] = choices.sides(&RenderSettings { size: (640, 360), ..settings }).try_into().unwrap();
        assert_eq!(drawn.render_settings(), expected);
        // Options that the technique does not support are left out.
        let options = ShadingOptions { pixel_kernel: PixelKernel::Normal, ..options };
        assert_eq!(drawn.picture, Picture { options, ..choices.picture });
        for technique in Technique::ALL {
            choices.picture.technique = technique;
            let drawn = captured(&command_of(&line, &seen(&choices))).picture;
            assert_eq!(drawn.shading(), choices.picture.shading(), "{technique:?}");
        }
    }

    #[test]
    fn command_contains_every_changed_option() {
        let sphere = given(&["--scene", "sphere"]);
        let with_cones = given(&["--scene", "plane", "--cone-map", "cones.png"]);
        let on_grid = given(&["--scene", "sphere", "--grid", "5"]);
        for option in SceneOption::all() {
            let (line, config) = match option.spec.name {
                name if name.starts_with("grid-") => &on_grid,
                name if name.starts_with("cone-") => &with_cones,
                _ => &sphere,
            };
            let mut changed = config.clone();
            if !matches!(option.sets, Sets::Picture(_) | Sets::Shading(_)) {
                continue;
            }
            let value = other_value(option, config);
            option.set(&mut changed, value.as_ref()).unwrap();
            for technique in Technique::ALL.into_iter().filter(|&t| option.applies_to(config.scene, t)) {
                if option.spec.name != "technique" {
                    changed.picture.technique = technique;
                }
                // Traced relief shadows include the occlusion of the sky.
                let options = &mut changed.picture.options;
                options.sky_occlusion &= !options.relief_shadows;
                let drawn = captured(&command_of(line, &seen(&Choices::new(changed.picture))));
                assert_eq!(
                    option.json(&drawn.picture),
                    option.json(&changed.picture),
                    "{technique:?} {}",
                    option.spec.name
                );
                assert_ne!(option.json(&drawn.picture), option.json(&config.picture), "--{} {value}", option.spec.name);
            }
        }
    }

    #[test]
    fn numbers_of_the_command_are_what_the_user_set() {
        // The sun passes through a vector, and the camera through angles.
        let value = |command: &str, flag: &str| {
            let mut words = command.split([' ', '=']);
            words.find(|word| *word == flag).unwrap();
            words.next().unwrap().to_owned()
        };
        let (line, config) = given(&[]);
        let choices = Choices::new(config.picture);
        for tenths in (-1790..=1800).step_by(37) {
            let set = SunDirection { azimuth: tenths as f32 / 10.0, elevation: (tenths / 40) as f32 / 2.0 };
            let sun = SunDirection::of(set.vector());
            let command = command_of(&line, &Seen { sun: Some(sun), ..seen(&choices) });
            assert_eq!(value(&command, "--sun"), format!("{},{}", set.azimuth, set.elevation));
        }
        for pose in [
            CameraPose { position: [6.1, -8.0, 5.3], target: [0.0, 0.1, 2.0], ..POSE },
            CameraPose { position: [0.25, -0.3, 0.05], target: [0.0, 0.01, 0.0], ..POSE },
            CameraPose { position: [900.5, -300.0, 5.0], target: [0.0, 0.0, 0.0], ..POSE },
        ] {
            let pose = CameraPose { fov_degrees: 41.3, ..pose };
            let command = command_of(&line, &Seen { pose: Orbit::new(&pose).pose(), ..seen(&choices) });
            let point = |of: [f32; 3]| of.map(|metres| metres.to_string()).join(",");
            let set = format!("{}:{}:41.3", point(pose.position), point(pose.target));
            assert_eq!(value(&command, "--camera"), set);
        }
        for hundredths in (0..3000).step_by(7) {
            let time = f64::from(hundredths as f32 / 100.0);
            let command = command_of(&line, &Seen { time, ..seen(&choices) });
            assert_eq!(value(&command, "--time"), (f64::from(hundredths) / 100.0).to_string());
        }
        // A dragged camera changes by much less than a pixel.
        let mut orbit = Orbit::new(&POSE);
        orbit.rotate(17.3, -4.9);
        orbit.zoom(1.7);
        let drawn = captured(&command_of(&line, &Seen { pose: orbit.pose(), ..seen(&choices) }));
        let ViewChoice::Pose(read) = drawn.view else { panic!("{:?}", drawn.view) };
        let apart = Vec3::from_array(read.position).distance(Vec3::from_array(orbit.pose().position));
        assert!(apart < 1e-5 * orbit.distance(), "{apart} m");
        assert_eq!([short(-0.000_01, 4), short(-49.999_996f32, ANGLE), short(0.1f32, SPLIT)], ["0", "-50", "0.1"]);
    }

    #[test]
    fn another_scene_has_another_surface() {
        let (mut line, _) =
            given(&["--scene", "plane", "--material", "my wall", "--no-displacement", "--samples", "2"]);
        assert_eq!(line.to_string(), " --scene plane --material 'my wall' --smooth-geometry --samples 2");
        line.enter("it's.glb");
        assert_eq!(line.to_string(), r" --scene 'it'\''s.glb' --smooth-geometry --samples 2");
        // Settings that the scene of the command would refuse are left out.
        line.enter("ocean");
        let (_, config) = given(&[]);
        let choices = Choices::new(Picture { height_scale: 0.5, stretch: 2.0, ..config.picture });
        let drawn = captured(&command_of(&line, &seen(&choices)));
        assert_eq!((drawn.scene.name, drawn.picture.displacement), ("ocean", true));
        assert_eq!((drawn.picture.height_scale, drawn.picture.stretch), (1.0, 1.0));
    }
}
