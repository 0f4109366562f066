//! Measures the error of the reference by its number of samples, for a relief under a sun and a sky, with and without its own shadows. Two
//! seeds give independent pictures. The error of one picture is the RMS of half their difference, times √2.
//!
//! `cargo run --release --example 08_reference_convergence [SAMPLES]`

use std::error::Error;

use glam::Vec3;
use leadr::gpu::GpuOptions;
use leadr::maps::HeightMap;
use leadr::open_gpu;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::passes::accumulate::Accumulation;
use leadr::render::scene::{FrameState, Object, Pose};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::displacement::HeightField;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::plane::{even, plane};
use leadr_lab::ray_cast::{Spectrum, Tile};

fn main() -> Result<(), Box<dyn Error>> {
    let most: u32 = std::env::args().nth(1).map_or(Ok(1024), |s| s.parse())?;
    let gpu = open_gpu(&GpuOptions::default())?;
    let tile = Tile::new(Spectrum::Gaussian, 64, 6.0, 1);
    let heights = HeightField::repeating(HeightMap { width: 64, height: 64, texels: tile.heights().to_vec() });
    let mesh = plane(1.5, 6, 1.0, [0.6, 0.6, 0.6, 0.4], even);
    let object = Object::new("plane", mesh).with_heights(heights, 0.7 / 64.0);
    let sky = Sky::default();
    let mut renderer = Renderer::new(&gpu, vec![object], Environment::from_sky(&gpu, 64, &sky)?)?;
    let view = Vec3::new(0.866, 0.0, 0.5) * 200.0;
    let camera = Camera { near: 1.0, ..Camera::looking_at(view, Vec3::ZERO, 0.1432) };
    let state = FrameState::new(camera, vec![Pose::REST]).under(&sky);
    for relief_shadows in [false, true] {
        println!("{}", if relief_shadows { "with shadows of the relief" } else { "without" });
        let mut parts = [Accumulation::default(), Accumulation::default()];
        let mut done = 0;
        while done < most {
            let end = (2 * done).clamp(1, most);
            for (seed, part) in (0u64..).zip(&mut parts) {
                let settings = RenderSettings {
                    size: (32, 16),
                    samples: most,
                    seed,
                    shading: Technique::Reference.with(ShadingOptions { relief_shadows, ..Default::default() }),
                    tessellation: TessellationSettings { to_texels: true, ..Default::default() },
                    shadows: false,
                    ..Default::default()
                };
                part.add(&renderer.render_range(&state, &settings, done..end)?.color, end - done);
            }
            done = end;
            let [a, b] = [parts[0].mean(), parts[1].mean()];
            let mean = a.iter().zip(&b).map(|(a, b)| f64::from(a[1] + b[1]) * 0.5).sum::<f64>() / a.len() as f64;
            let square = a.iter().zip(&b).map(|(a, b)| f64::from(a[1] - b[1]).powi(2) * 0.5).sum::<f64>();
            println!("{done:>5} samples: {:.3} %", 100.0 * (square / a.len() as f64).sqrt() / mean);
        }
    }
    Ok(())
}
