//! Measures temporal jumps of pixels when the camera moves away slowly, in steps of 0.05 % of the distance. Only pixels inside a surface
//! count. The measurement covers the rules of LEADR's integrals, and edge samples.
//!
//! `cargo run --release --example 13_slow_zoom [plane|sphere [METRES]]`

use std::error::Error;

use leadr::gpu::GpuOptions;
use leadr::open_gpu;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::settings::{Probes, Quadrature, RenderSettings, ShadingOptions, Technique};
use leadr::scenes::stage::{Lights, ReliefOptions, Stage, plane_stage, sphere_stage};
use leadr::scenes::studio::studio;
use leadr_tools::metrics::Mask;

const SIZE: u32 = 64;
const STEPS: i32 = 100;
const STEP: f32 = 1.0005;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (stage, metres) = match arguments.next().as_deref() {
        None | Some("plane") => (plane_stage as fn(ReliefOptions) -> Stage, 6.0),
        Some("sphere") => (sphere_stage as fn(ReliefOptions) -> Stage, 10.0),
        Some(other) => return Err(format!("{other} is neither plane nor sphere").into()),
    };
    let metres = arguments.next().map_or(Ok(metres), |text| text.parse::<f32>())?;
    let gpu = open_gpu(&GpuOptions::default())?;
    let sky = Sky::default();
    println!("one sample, smooth geometry, from {metres} m in {STEPS} steps of {STEP}; shares of the mean radiance");
    println!("{:<7} {:<22} {:>9} {:>9} {:>9} {:>9}", "light", "rule", "step", "second", "99.9 %", "rms");
    let surroundings = [
        ("sky", Environment::from_sky(&gpu, Environment::FACE_SIZE, &sky)?, Some(sky)),
        ("studio", Environment::from_equirect(&gpu, Environment::FACE_SIZE, &studio())?, None),
    ];
    for (light, environment, sky) in surroundings {
        let mut stage = stage(ReliefOptions::default());
        let mut renderer = Renderer::new(&gpu, std::mem::take(&mut stage.objects), environment)?;
        let lights = Lights { sky, ..Lights::default() };
        for (rule, quadrature, edge_samples) in [
            ("5x5", Quadrature::Grid(5), 1),
            ("32x32", Quadrature::Grid(32), 1),
            ("9 probes", Quadrature::VisibleSlopes(Probes::Nine), 1),
            ("16 probes", Quadrature::VisibleSlopes(Probes::Sixteen), 1),
            ("16, 16 edge samples", Quadrature::VisibleSlopes(Probes::Sixteen), 16),
        ] {
            let settings = RenderSettings {
                size: (SIZE, SIZE),
                displacement: false,
                shading: Technique::Leadr.with(ShadingOptions { quadrature, edge_samples, ..Default::default() }),
                ..Default::default()
            };
            let frames = (0..=STEPS).map(|k| {
                let camera = stage.views.mid.at_distance(metres * STEP.powi(k));
                Ok(renderer.render(&stage.state(0.0, &camera, &lights), &settings)?.color)
            });
            let frames = frames.collect::<Result<Vec<_>, Box<dyn Error>>>()?;
            let Jerks { step, second, most, rms } = jerks(&frames)?;
            println!("{light:<7} {rule:<22} {step:>9.4} {second:>9.4} {most:>9.4} {rms:>9.5}");
        }
    }
    Ok(())
}

/// The changes of the pixels' luminance, relative to the mean luminance.
struct Jerks {
    /// The largest change from one frame to the next.
    step: f64,
    /// The largest second difference.
    second: f64,
    /// The 99.9 % quantile of the second differences.
    most: f64,
    /// The RMS of the second differences.
    rms: f64,
}

fn jerks(frames: &[Vec<[f32; 4]>]) -> Result<Jerks, Box<dyn Error>> {
    let (mut step, mut sum) = (0.0f64, 0.0);
    let mut seconds = Vec::new();
    for three in frames.windows(3) {
        let coverage: Vec<f32> = three[2].iter().map(|c| c[3]).collect();
        let inside = Mask::covered(SIZE, SIZE, &coverage, 0.999)?.eroded(4);
        for i in (0..coverage.len()).filter(|&i| inside.inside[i]) {
            let [a, b, c] = [0, 1, 2].map(|k| three[k][i][..3].iter().map(|&v| f64::from(v)).sum::<f64>() / 3.0);
            step = step.max((c - b).abs());
            seconds.push((c - 2.0 * b + a).abs());
            sum += b;
        }
    }
    if seconds.is_empty() {
        return Err("no pixel lies inside the surface; use a shorter distance".into());
    }
    seconds.sort_by(f64::total_cmp);
    let (count, mean) = (seconds.len(), sum / seconds.len() as f64);
    let square: f64 = seconds.iter().map(|s| s * s).sum();
    Ok(Jerks {
        step: step / mean,
        second: seconds[count - 1] / mean,
        most: seconds[count * 999 / 1000] / mean,
        rms: (square / count as f64).sqrt() / mean,
    })
}
