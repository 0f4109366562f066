//! Shows a displaced sphere in a window. Drag to rotate the sphere; `space` pauses, digits select the technique, `e` the environment, `q`
//! quits.
//!
//! ```sh
//! cargo run --release --example 02_orbit
//! ```

use std::path::PathBuf;

use clap::Parser;
use glam::Affine3A;
use leadr::maps::procedural::rock;
use leadr::open_gpu;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, Object, Pose};
use leadr::render::settings::RenderSettings;
use leadr::render::surfaces::displacement::HeightField;
use leadr::scenes::light::EnvironmentChoice;
use leadr::scenes::set::SkyOrPicture;
use leadr::scenes::sphere::displaced_sphere;
use leadr::scenes::view::CameraPose;
use leadr::window::{Animations, Display, OneScene, Orbit, Show, Surroundings, WindowOptions, run};

/// A displaced sphere in a window.
#[derive(Parser)]
struct Arguments {
    /// Width in pixels
    #[arg(long, default_value_t = 960)]
    width: u32,
    /// Height in pixels
    #[arg(long, default_value_t = 540)]
    height: u32,
    /// Samples per pixel of a still picture
    #[arg(long, default_value_t = 16)]
    samples: u32,
    /// Quit after this many frames
    #[arg(long)]
    frames: Option<u64>,
    /// Path prefix of screenshots; a number and `.png` are appended
    #[arg(long, default_value = "out/orbit")]
    screenshots: PathBuf,
    /// Vulkan device: part of its name, or its index
    #[arg(long)]
    device: Option<String>,
    /// Enable the Vulkan validation layers; any message is an error
    #[arg(long)]
    validation: bool,
}

/// Opens the window.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments = Arguments::parse();

    // The display is opened first, because the device must be able to present on it.
    let display = Display::open()?;
    let gpu = open_gpu(&display.gpu_options(arguments.device, arguments.validation)?)?;

    let rock = HeightField::repeating(rock(256, 256, 7));
    let (mesh, heights) = displaced_sphere(&rock, 1.0, 8, 64, [0.45, 0.35, 0.26, 0.25]);
    let sphere = Object::new("sphere", mesh).with_heights(heights, 0.12);

    let sky = Sky::default();
    let environment = Environment::from_sky(&gpu, Environment::FACE_SIZE, &sky)?;
    let renderer = Renderer::new(&gpu, vec![sphere], environment)?;

    // A scene is a pure function of time. In this scene, a sphere rotates once in twenty seconds.
    let start = CameraPose { position: [3.2, -3.2, 0.7], target: [0.0; 3], up: [0.0, 0.0, 1.0], fov_degrees: 35.0 };
    let scene = move |time: f64| {
        let rotation = Affine3A::from_rotation_z((time * 0.314) as f32);
        FrameState::new(start.camera(), vec![Pose::Rigid(rotation)]).under(&sky)
    };

    let size = (arguments.width, arguments.height);
    let settings = RenderSettings { size, samples: arguments.samples, ..Default::default() };
    let options = WindowOptions {
        title: "Orbit".to_owned(),
        screenshots: arguments.screenshots,
        frames: arguments.frames,
        ..Default::default()
    };
    let surroundings = Surroundings::new(EnvironmentChoice::Sky, SkyOrPicture::under(sky));
    let orbit = Orbit::new(&start);
    let animations = Animations::default();
    let show = Show { renderer, scene: Box::new(scene), orbit, views: None, sweep: None, surroundings, animations };
    let report = run(display, show, settings, &mut OneScene, options)?;
    println!("{}", serde_json::to_string(&report)?);
    match gpu.validation_messages().as_slice() {
        [] => Ok(()),
        messages => Err(messages.join("\n").into()),
    }
}
