//! Renders the sea from several heights: `cargo run --release --example 10_ocean [FOLDER]`.

use std::error::Error;
use std::path::PathBuf;

use glam::Vec3;
use leadr::gpu::GpuOptions;
use leadr::maps::save::save_png;
use leadr::maps::tonemap::Tonemap;
use leadr::open_gpu;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::settings::RenderSettings;
use leadr::scenes::ocean::sea::{RESOLUTION, ocean};
use leadr::scenes::ocean::spectrum::Sea;
use leadr::scenes::stage::{Lights, Stage, Views};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "out".to_owned()));
    let gpu = open_gpu(&GpuOptions { validation: true, ..GpuOptions::default() })?;
    let sky = Sky { sun_direction: Vec3::new(0.85, 0.2, 0.32).normalize(), ..Sky::default() };
    let environment = Environment::from_sky(&gpu, Environment::FACE_SIZE, &sky)?;
    let start = std::time::Instant::now();
    let mut renderer = Renderer::new(&gpu, ocean(&Sea::default(), RESOLUTION, 1), environment)?;
    println!("sea generated in {:.2} s", start.elapsed().as_secs_f64());
    for (name, height, pitch) in
        [("near", 2.5f32, -0.12f32), ("100m", 100.0, -0.25), ("1km", 1000.0, -0.35), ("below", 30.0, -1.2)]
    {
        let eye = Vec3::new(0.0, 0.0, height);
        let camera = Camera::looking_at(eye, eye + Vec3::new(pitch.cos(), 0.0, pitch.sin()) * 5.0, 45.0);
        let stage = Stage::still(Vec::new(), Views { near: camera, mid: camera, far: camera });
        let state = stage.state(3.0, &camera, &Lights::under(&sky));
        let size = (640, 400);
        let settings = RenderSettings { size, ..RenderSettings::default() };
        let output = renderer.render(&state, &settings)?;
        let times: Vec<String> = output.times.iter().map(|t| format!("{} {:.0}", t.pass, t.milliseconds)).collect();
        println!("{name}: {} triangles; {}", output.triangles, times.join(", "));
        save_png(folder.join(format!("ocean-{name}.png")), &output.image(), 1.0, Tonemap::Filmic)?;
    }
    println!("{:?}", gpu.validation_messages());
    Ok(())
}
