//! `leadr bench`: the time of every pass on the device, of rows that are measured turn and turn about.

pub mod goals;
pub mod ocean;
pub mod report;
pub mod rounds;
pub mod rows;
pub mod soak;
pub mod stats;

use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use indicatif::ProgressBar;

use super::cli::{BenchArgs, SceneArgs};
use super::config::SceneConfig;
use super::error::AppError;
use super::output::Output;
use super::stage::{self, Inputs};
use super::values::{SceneKind, Size};
use super::waves::WaveArgs;
use crate::gpu::{Gpu, GpuOptions};
use crate::render::frame::{PassTime, Renderer};
use crate::render::light::environment::{Environment, FACE_SIZE};
use crate::render::light::sky::Sky;
use crate::render::settings::Technique;
use crate::scenes::daylight;
use crate::scenes::full_screen::full_screen_stage;
use crate::scenes::stage::Lights;
use ocean::Variant;
use report::BenchReport;
use rounds::{Series, Subject, Tick};
use rows::Row;
use soak::SoakReport;

/// Size of the full-screen quad and its map in the paper.
const PAPER_SIZE: Size = Size { width: 1024, height: 1024 };
/// Size of the scenes' pictures.
const SCENE_SIZE: Size = Size { width: 512, height: 512 };

/// Rows with their times.
pub struct Measured {
    /// What was measured.
    pub row: Row,
    /// The times.
    pub series: Series,
}

/// The commit this program was built from; `-dirty` and `-dev` mark what may differ from it.
pub const COMMIT: &str = env!("LEADR_COMMIT");

/// Measures what the arguments ask for.
///
/// # Errors
/// If an input file or the device is not what it should be, or the device fails.
pub fn bench(arguments: &BenchArgs, output: &Output) -> Result<BenchReport, AppError> {
    let start = Instant::now();
    let scenes = scenes(arguments)?;
    // Files first: their faults are found in no time and need no device.
    let scenes = scenes
        .into_iter()
        .map(|config| Inputs::load(&config).map(|inputs| (config, inputs)))
        .collect::<Result<Vec<_>, _>>()?;
    let gpu = open(arguments)?;
    let rounds = arguments.frames as usize;
    let mut measured = Vec::new();
    if quad_wanted(arguments) {
        let size = arguments.size.unwrap_or(PAPER_SIZE);
        let mut stage = full_screen_stage((size.width, size.height));
        let sky = Sky::default();
        let environment = Environment::from_sky(&gpu, FACE_SIZE, &sky)?;
        let renderer = Renderer::new(&gpu, std::mem::take(&mut stage.objects), environment)?;
        let state = stage.state(0.0, &stage.views.mid, &Lights::under(&sky));
        let mut rows = rows::quad(&state, size);
        if arguments.goals {
            rows.retain(rows::in_a_goal);
        }
        measure(vec![(renderer, rows)], rounds, output, &mut measured)?;
    }
    for (config, inputs) in scenes {
        let set = stage::set(&config, inputs, &gpu, output)?;
        let rows = rows::scene(&config, &(set.animation)(0.0), arguments.technique);
        measure(vec![(set.renderer, rows)], rounds, output, &mut measured)?;
        if config.kind == SceneKind::Ocean {
            measure(seas(&config, &gpu, arguments.technique, output)?, rounds, output, &mut measured)?;
        }
    }
    if let Some(message) = gpu.validation_messages().first() {
        return Err(AppError::Failed(format!("validation: {message}")));
    }
    Ok(BenchReport::new(&gpu, measured, arguments.frames, start.elapsed().as_secs_f64()))
}

/// Draws as many frames of the sea as the arguments ask for.
///
/// # Errors
/// As [`soak::soak`]; wrong usage for a scene that is no sea.
pub fn soak(arguments: &BenchArgs, frames: u32, output: &Output) -> Result<SoakReport, AppError> {
    let configs = scenes(arguments)?;
    let [config] = configs.as_slice() else { return Err(AppError::Usage("--soak is for one scene".into())) };
    if ![SceneKind::Ocean, SceneKind::Shore].contains(&config.kind) {
        return Err(AppError::Usage("--soak is for --scene ocean or shore".into()));
    }
    soak::soak(config, &open(arguments)?, frames, arguments.technique, output)
}

fn open(arguments: &BenchArgs) -> Result<Arc<Gpu>, AppError> {
    let device = &arguments.device;
    let options = GpuOptions { device: device.device.clone(), validation: device.validation, ..Default::default() };
    Ok(Gpu::new(&options)?)
}

/// Renderers of the sea's own tables, each with its row: maps and targets of every size stay alive.
fn seas(
    config: &SceneConfig,
    gpu: &Arc<Gpu>,
    technique: Option<Technique>,
    output: &Output,
) -> Result<Vec<(Renderer, Vec<Row>)>, AppError> {
    let sea = |variant: Variant| -> Result<_, AppError> {
        let set = stage::set(&variant.config, Inputs::load(&variant.config)?, gpu, output)?;
        let row = rows::variant(variant, (set.animation)(0.0), technique);
        Ok((set.renderer, vec![row]))
    };
    ocean::variants(config).into_iter().map(sea).collect()
}

/// Whether the full-screen quad is measured: alone, along with the scenes, or not.
fn quad_wanted(arguments: &BenchArgs) -> bool {
    arguments.paper || (arguments.scene.is_none() && arguments.technique.is_none())
}

/// The scenes to measure.
fn scenes(arguments: &BenchArgs) -> Result<Vec<SceneConfig>, AppError> {
    let kinds = match arguments.scene {
        Some(kind) => vec![kind],
        None if arguments.paper && arguments.technique.is_none() => Vec::new(),
        None => vec![SceneKind::Sphere, SceneKind::Trex],
    };
    kinds.into_iter().map(|kind| scene_config(arguments, kind)).collect()
}

/// `leadr capture`'s defaults, with what the bench's flags say.
fn scene_config(arguments: &BenchArgs, kind: SceneKind) -> Result<SceneConfig, AppError> {
    /// The flags of scenes alone.
    #[derive(Parser)]
    struct Defaults {
        #[command(flatten)]
        scene: SceneArgs,
    }
    let defaults = Defaults::try_parse_from(["bench"]).map_err(|e| AppError::Failed(e.to_string()))?;
    let scene = SceneArgs {
        scene: kind,
        height_map: arguments.height_map.clone(),
        waves: WaveArgs { fft: arguments.fft, ..WaveArgs::default() },
        atlas_tile: arguments.atlas_tile,
        size: arguments.size.unwrap_or(SCENE_SIZE),
        samples: 1,
        edge_samples: arguments.edge_samples,
        device: arguments.device.clone(),
        ..defaults.scene
    };
    SceneConfig::resolve(&scene)
}

/// Renderers and the rows they draw, each with the index of its renderer.
struct Bench {
    renderers: Vec<Renderer>,
    rows: Vec<(usize, Row)>,
}

impl Subject for Bench {
    fn frame(&mut self, row: usize, round: usize, repeats: u32) -> Result<Vec<PassTime>, AppError> {
        let (renderer, row) = &self.rows[row];
        // Every round of a row of many samples draws another of them.
        let index = round as u32 % row.settings.samples.max(1);
        let mut state = row.state.clone();
        daylight::pass(&mut state, row.sun_hours * (round + 1) as f64);
        let times = self.renderers[*renderer].measure(&state, &row.settings, index, repeats)?;
        if row.sun_hours != 0.0
            && let Some(sky) = &row.state.sky
        {
            // The next row is not to pay for the sun's way back.
            self.renderers[*renderer].show_sky(sky)?;
        }
        Ok(times)
    }
}

/// Measures all rows of some renderers turn and turn about and appends them to `measured`.
fn measure(
    subjects: Vec<(Renderer, Vec<Row>)>,
    rounds: usize,
    output: &Output,
    measured: &mut Vec<Measured>,
) -> Result<(), AppError> {
    let mut bench = Bench { renderers: Vec::new(), rows: Vec::new() };
    for (index, (renderer, rows)) in subjects.into_iter().enumerate() {
        renderer.gpu().wait_idle()?;
        bench.renderers.push(renderer);
        bench.rows.extend(rows.into_iter().map(|row| (index, row)));
    }
    let names: Vec<String> = bench.rows.iter().map(|(_, row)| format!("{}: {}", row.table, row.name)).collect();
    let progress: ProgressBar = output.progress(names.len());
    let mut tick = |tick: Tick| match tick {
        Tick::Warm(row) => {
            progress.set_message(format!("warming up, {}", names[row]));
            progress.inc(1);
        }
        Tick::Begin(frames) => {
            progress.set_length(frames as u64);
            progress.set_position(0);
        }
        Tick::Frame(row) => {
            progress.set_message(names[row].clone());
            progress.inc(1);
        }
    };
    let count = bench.rows.len();
    let series = rounds::measure(&mut bench, count, rounds, &mut tick)?;
    progress.finish_and_clear();
    measured.extend(bench.rows.into_iter().zip(series).map(|((_, row), series)| Measured { row, series }));
    Ok(())
}
