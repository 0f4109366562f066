//! Shows the orientation of a height map: a raised letter F on the plane, seen from above with +x to the right and +y up.
//!
//! `cargo run --release --example 15_map_orientation [PICTURE]` writes `out/map_orientation.png`, or the file named.

use std::error::Error;

use leadr::gpu::GpuOptions;
use leadr::maps::tonemap::Tonemap;
use leadr::maps::{HeightMap, save};
use leadr::open_gpu;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::settings::RenderSettings;
use leadr::scenes::stage::{Lights, ReliefOptions, plane_stage};

/// The map as a picture, with its first row on top.
const LETTER: [&str; 8] =
    ["........", ".#####..", ".#......", ".#......", ".####...", ".#......", ".#......", "........"];

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args_os().nth(1).unwrap_or_else(|| "out/map_orientation.png".into());
    let side = 128;
    let raised = |i: u32| LETTER[(i / side * 8 / side) as usize].as_bytes()[(i % side * 8 / side) as usize] == b'#';
    let map = HeightMap::new(side, side, (0..side * side).map(|i| f32::from(u8::from(raised(i)))).collect())?;
    let mut stage = plane_stage(ReliefOptions { map: Some(map), ..ReliefOptions::default() });
    // The camera is above the middle of the repeat between (0, 0) and (2, 2), slightly to the south, so that +y is up.
    let middle = glam::Vec3::new(1.0, 1.0, 0.0);
    let camera = Camera::looking_at(middle + glam::Vec3::new(0.0, -0.6, 6.0), middle, 30.0);
    let sky = Sky::with_sun(0.6, -2.2);
    let state = stage.state(0.0, &camera, &Lights::under(&sky));
    let gpu = open_gpu(&GpuOptions::default())?;
    let environment = Environment::from_sky(&gpu, Environment::FACE_SIZE, &sky)?;
    let mut renderer = Renderer::new(&gpu, stage.take_scene(), environment)?;
    let settings = RenderSettings { size: (480, 480), samples: 16, ..Default::default() };
    let picture = renderer.render(&state, &settings)?.image();
    if let Some(folder) = std::path::Path::new(&file).parent() {
        std::fs::create_dir_all(folder)?;
    }
    save::save_png(&file, &picture, state.exposure(), Tonemap::default())?;
    println!("wrote {}", file.display());
    Ok(())
}
