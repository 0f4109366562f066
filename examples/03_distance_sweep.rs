//! Zooms out from a displaced sphere and prints the change of its mean radiance per step, for LEADR mapping and normal
//! mipmapping.
//!
//! `cargo run --release --example 03_distance_sweep [HEIGHT_MAP [ENVIRONMENT]]`

use std::error::Error;

use leadr::gpu::GpuOptions;
use leadr::maps::{load_environment, load_height_map};
use leadr::open_gpu;
use leadr::render::frame::{FrameOutput, Renderer};
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::settings::{RenderSettings, Technique};
use leadr::scenes::stage::{Lights, ReliefOptions, sphere_stage};

const STEPS: i32 = 40;

/// Returns the luminance averaged over the object. Background pixels have no coverage.
fn mean_luminance(output: &FrameOutput) -> f64 {
    let inside = output.color.iter().filter(|c| c[3] > 0.99);
    let luminance = |c: &[f32; 4]| f64::from(0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]);
    inside.clone().map(luminance).sum::<f64>() / inside.count().max(1) as f64
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let map = arguments.next().map(load_height_map).transpose()?;
    let gpu = open_gpu(&GpuOptions::default())?;
    let (environment, sky) = match arguments.next() {
        Some(file) => (Environment::from_equirect(&gpu, Environment::FACE_SIZE, &load_environment(file)?)?, None),
        None => (Environment::from_sky(&gpu, Environment::FACE_SIZE, &Sky::default())?, Some(Sky::default())),
    };
    let mut stage = sphere_stage(ReliefOptions { map, tile: 32, ..ReliefOptions::default() });
    let mut renderer = Renderer::new(&gpu, std::mem::take(&mut stage.objects), environment)?;
    let lights = Lights { sky, ..Default::default() };
    println!("{} · {STEPS} distances from 5 to 50 m", gpu.device_name());
    for technique in [Technique::Leadr, Technique::NormalMip] {
        let mut luminances = Vec::new();
        for i in 0..STEPS {
            let distance = 5.0 * 10f32.powf(i as f32 / (STEPS - 1) as f32);
            let camera = stage.views.mid.at_distance(distance);
            let shading = technique.into();
            let settings =
                RenderSettings { size: (256, 256), samples: 4, shading, shadows: false, ..Default::default() };
            luminances.push(mean_luminance(&renderer.render(&stage.state(0.0, &camera, &lights), &settings)?));
        }
        let largest = luminances.windows(2).map(|w| (w[1] / w[0] - 1.0).abs()).fold(0.0, f64::max);
        let drift = luminances[luminances.len() - 1] / luminances[0] - 1.0;
        println!("{:<11} largest step {:.2} %, near to far {:+.1} %", technique.name(), 100.0 * largest, 100.0 * drift);
    }
    Ok(())
}
