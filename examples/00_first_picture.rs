//! Renders a displaced sphere in the evening, and writes the picture to `out/first_picture.png`: `cargo run --release --example
//! 00_first_picture`.

use leadr::glam::Vec3;
use leadr::{Camera, Environment, GpuOptions, Lights, NamedScene, RenderSettings, Renderer, Sky, open_gpu, save_png};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = NamedScene::find("sphere").ok_or("the scene is missing")?;
    let mut stage = scene.stage(Default::default(), &|_| ())?;
    let sky = Sky { ground_albedo: stage.below_horizon, ..Sky::with_sun(0.35, -1.92) };
    let camera = Camera::looking_at(Vec3::new(2.9, -2.9, -0.35), Vec3::ZERO, 36.0);
    let frame = stage.state(0.0, &camera, &Lights::under(&sky));

    let gpu = open_gpu(&GpuOptions::default())?;
    let environment = Environment::from_sky(&gpu, Environment::FACE_SIZE, &sky)?;
    let mut renderer = Renderer::new(&gpu, stage.take_scene(), environment)?;

    let settings = RenderSettings { size: (960, 640), samples: 16, ..Default::default() };
    let picture = renderer.render(&frame, &settings)?.image();
    std::fs::create_dir_all("out")?;
    save_png("out/first_picture.png", &picture, frame.exposure(), Default::default())?;
    Ok(())
}
