//! A picture of a scene by its name: `cargo run --release --example 00_first_picture [SCENE]`.

use leadr::{Environment, Gpu, GpuOptions, Lights, NamedScene, RenderSettings, Renderer, SceneOptions, Sky, save_png};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "sphere".to_owned());
    let scene = NamedScene::find(&name).ok_or("no scene of that name")?;
    let mut stage = scene.stage(SceneOptions::default(), &|_| ())?;
    let sky = Sky { ground_albedo: stage.below_horizon, ..Sky::default() };
    let frame = stage.state(0.0, &stage.views.mid, &Lights::under(&sky));

    let gpu = Gpu::new(&GpuOptions::default())?;
    let environment = Environment::from_sky(&gpu, Environment::FACE_SIZE, &sky)?;
    let mut renderer = Renderer::new(&gpu, stage.take_scene(), environment)?;

    let settings = RenderSettings { size: (960, 640), samples: 16, ..Default::default() };
    let picture = renderer.render(&frame, &settings)?.image();
    save_png(format!("{name}.png"), &picture, frame.exposure(), Default::default())?;
    Ok(())
}
