//! Measures the error of pictures with one sample per pixel against a supersampled reference, as FLIP and relative RMSE. The techniques are
//! LEADR mapping and normal mipmapping. In the reference, every texel is a vertex, and maps use their finest level.
//!
//! `cargo run --release --example 06_against_reference [sphere|trex [SAMPLES [HEIGHT_MAP [ENVIRONMENT]]]]`
//!
//! The T-rex has no ground and a coarse atlas in this example, to limit the cost of the reference.

use std::error::Error;

use leadr::gpu::GpuOptions;
use leadr::maps::tonemap::Tonemap;
use leadr::maps::{RgbImage, load_environment, load_height_map};
use leadr::open_gpu;
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::stage::{Lights, ReliefOptions, sphere_stage};
use leadr::scenes::trex::stage::trex_stage;
use leadr_tools::metrics::compare::compare;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let scene = arguments.first().map_or("sphere", String::as_str);
    let samples: u32 = arguments.get(1).map_or(Ok(64), |s| s.parse())?;
    let gpu = open_gpu(&GpuOptions::default())?;
    let (mut stage, distance) = match scene {
        "trex" => (trex_stage(16, &|_| {})?, 90.0),
        _ => {
            let map = arguments.get(2).map(load_height_map).transpose()?;
            (sphere_stage(ReliefOptions { map, tile: 32, ..ReliefOptions::default() }), 24.0)
        }
    };
    let (environment, sky, exposure) = match arguments.get(3) {
        Some(file) => (Environment::from_equirect(&gpu, Environment::FACE_SIZE, &load_environment(file)?)?, None, 0.35),
        None => (Environment::from_sky(&gpu, Environment::FACE_SIZE, &Sky::default())?, Some(Sky::default()), 1.0),
    };
    let mut objects = std::mem::take(&mut stage.objects);
    objects.truncate(2);
    let count = objects.len();
    let mut renderer = Renderer::new(&gpu, objects, environment)?;
    let camera = stage.views.mid.at_distance(distance);
    let mut state = stage.state(0.4, &camera, &Lights { sky, ..Default::default() });
    state.poses.truncate(count);

    let mut render = |technique: Technique,
                      samples: u32,
                      shadowing: Shadowing|
     -> Result<(RgbImage, f64), Box<dyn Error>> {
        let settings = RenderSettings {
            size: (128, 128),
            samples,
            shading: technique.with(ShadingOptions { shadowing, relief_occlusion: false, ..Default::default() }),
            tessellation: TessellationSettings { to_texels: technique == Technique::Reference, ..Default::default() },
            ..Default::default()
        };
        let output = renderer.render(&state, &settings)?;
        let time = output.times.iter().map(|t| t.milliseconds).sum();
        let texels = output.color.iter().map(|c| [c[0], c[1], c[2]]).collect();
        Ok((RgbImage::new(128, 128, texels)?, time))
    };
    let (reference, time) = render(Technique::Reference, samples, Shadowing::Smith)?;
    println!("{scene} on {}: reference with {samples} samples, {time:.0} ms", gpu.device_name());
    println!("{:<11} {:>7} {:>10} {:>8} {:>9} {:>9}", "technique", "samples", "shadowing", "FLIP", "rel. RMSE", "ms");
    for shadowing in [Shadowing::Smith, Shadowing::None] {
        for technique in [Technique::Leadr, Technique::NormalMip] {
            for samples in [1, 64] {
                let (image, time) = render(technique, samples, shadowing)?;
                let error = compare(&reference, &image, exposure, Tonemap::Filmic)?;
                let shadowing = shadowing.name();
                println!(
                    "{:<11} {samples:>7} {shadowing:>10} {:>8.4} {:>9.4} {time:>9.0}",
                    technique.name(),
                    error.flip,
                    error.rrmse
                );
            }
        }
    }
    Ok(())
}
