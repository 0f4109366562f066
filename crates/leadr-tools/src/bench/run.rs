//! Runs the bench: uploads the scenes and measures their rows.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::Instant;

use super::forward::ForwardPass;
use super::report::BenchReport;
use super::rounds::{self, Frame, Tick};
use super::rows::{Measured, Row};
use super::scene::Table;
use super::{bases, maps, ocean, quad, scale, scene};
use crate::bench::full_screen::full_screen_stage;
use crate::command::output::Output;
use crate::error::LabError;
use leadr_gpu::Gpu;
use leadr_render::frame::{KeptTargets, Renderer};
use leadr_render::light::environment::Environment;
use leadr_render::light::sky::Sky;
use leadr_render::scene::{FrameState, Object};
use leadr_render::settings::{RenderSettings, Technique};
use leadr_scenes::config::SceneConfig;
use leadr_scenes::daylight;
use leadr_scenes::set::{Inputs, set};
use leadr_scenes::stage::Lights;
use leadr_scenes::view::Size;

/// What the bench measures.
#[derive(Clone, Debug)]
pub struct BenchConfig {
    /// The quad of the paper's tables, if selected.
    pub quad: Option<Quad>,
    /// The size of the quad for the comparison with a plain forward pass, if selected.
    pub forward: Option<Size>,
    /// The scenes to measure.
    pub scenes: Vec<SceneConfig>,
    /// The tables to measure. A scene skips tables that it does not support.
    pub tables: Vec<Table>,
    /// The picture sizes of [`Table::Views`].
    pub view_sizes: Vec<Size>,
    /// The only technique to measure in scenes, if given.
    pub technique: Option<Technique>,
    /// The number of rounds. Rows whose frames take over a second skip some rounds.
    pub rounds: u32,
}

/// The paper's tables over a full-screen quad. The LEADR map has one texel per pixel.
#[derive(Clone, Copy, Debug)]
pub struct Quad {
    /// The size of the quad and of its map.
    pub size: Size,
    /// Whether to measure only the rows that goals compare.
    pub goals_only: bool,
}

/// Runs the bench. `open` opens the device, after the input files have been checked.
///
/// # Errors
/// Fails if an input file is invalid, or the device cannot be opened or fails.
pub fn bench(
    config: &BenchConfig,
    open: impl FnOnce() -> Result<Arc<Gpu>, LabError>,
    output: &Output,
) -> Result<BenchReport, LabError> {
    let start = Instant::now();
    // Files are read first, so their errors are reported without opening a device.
    let inputs = config.scenes.iter().map(Inputs::load).collect::<Result<Vec<_>, _>>()?;
    let gpu = open()?;
    let mut measured = Vec::new();
    let mut measure = |subjects, forward| -> Result<(), LabError> {
        measured.extend(measure(subjects, forward, config.rounds as usize, output)?);
        Ok(())
    };
    if let Some(quad) = &config.quad {
        let FullScreen { renderer, state, .. } = FullScreen::new(quad.size, &gpu)?;
        let mut rows = quad::rows(&state, quad.size);
        if quad.goals_only {
            rows.retain(quad::in_a_goal);
        }
        measure(vec![(renderer, rows)], None)?;
    }
    if let Some(size) = config.forward {
        let mut quad = FullScreen::new(size, &gpu)?;
        let rows = quad::against_forward(&quad.state, size);
        let forward = quad.forward(size, &rows[0].settings)?;
        measure(vec![(quad.renderer, rows)], Some(forward))?;
    }
    for (scene, inputs) in config.scenes.iter().zip(inputs) {
        let one_set = |table: &Table| !matches!(table, Table::Maps | Table::Bases | Table::Waves | Table::Scale);
        if config.tables.iter().any(one_set) {
            measure(vec![one_scene(config, scene, inputs, &gpu, output)?], None)?;
        }
        let wants = |table: Table| config.tables.contains(&table) && table.is_of(scene.scene);
        if wants(Table::Maps) {
            measure(maps::maps(scene, &gpu, config.technique, output)?, None)?;
        }
        if wants(Table::Bases) {
            measure(bases::bases(scene, &gpu, config.technique, output)?, None)?;
        }
        if wants(Table::Waves) {
            measure(ocean::seas(scene, &gpu, config.technique, output)?, None)?;
        }
        if wants(Table::Scale) {
            measure(scale::scale(scene, &gpu, config.technique, output)?, None)?;
        }
    }
    if let Some(message) = gpu.validation_messages().first() {
        return Err(LabError(format!("Vulkan validation: {message}")));
    }
    Ok(BenchReport::new(&gpu, measured, config.rounds, start.elapsed().as_secs_f64()))
}

/// Returns the renderer of a scene, and the rows of all tables that this renderer can draw.
fn one_scene(
    config: &BenchConfig,
    scene: &SceneConfig,
    inputs: Inputs,
    gpu: &Arc<Gpu>,
    output: &Output,
) -> Result<(Renderer, Vec<Row>), LabError> {
    let set = set(scene, inputs, gpu, None, &output.set_up())?;
    let (state, only) = ((set.animation)(0.0), config.technique);
    let rows = config.tables.iter().flat_map(|table| match table {
        Table::Views => scene::views(scene, &config.view_sizes, |view, size| set.state_from(0.0, view, size), only),
        Table::Techniques => scene::techniques(scene, &state, only),
        Table::Distance => scene::distances(scene, &state, only),
        Table::Resolution => scene::resolutions(scene, &state, only),
        Table::Triangles => scene::triangles(scene, &state, only),
        Table::Lights => scene::lights(scene, &state, only),
        Table::Maps | Table::Bases | Table::Waves | Table::Scale => Vec::new(),
    });
    let rows = rows.collect();
    Ok((set.renderer, rows))
}

/// The uploaded quad of the paper's tables.
pub struct FullScreen {
    /// The renderer of the quad.
    pub renderer: Renderer,
    /// The quad as a copy of the renderer's object.
    pub object: Object,
    /// The state of the scene.
    pub state: FrameState,
}

impl FullScreen {
    /// Creates a quad of this size, with one map texel per pixel.
    ///
    /// # Errors
    /// Fails if memory runs out or the device fails.
    pub fn new(size: Size, gpu: &Arc<Gpu>) -> Result<Self, LabError> {
        let mut stage = full_screen_stage((size.width, size.height));
        let object = stage.objects[0].clone();
        let sky = Sky::default();
        let environment = Environment::from_sky(gpu, Environment::FACE_SIZE, &sky)?;
        let renderer = Renderer::new(gpu, stage.take_scene(), environment)?;
        let state = stage.state(0.0, &stage.views.mid, &Lights::under(&sky));
        Ok(Self { renderer, object, state })
    }

    /// Creates a plain forward pass over the quad in the same light.
    ///
    /// # Errors
    /// Fails like [`new`](Self::new).
    pub fn forward(&mut self, size: Size, settings: &RenderSettings) -> Result<ForwardPass, LabError> {
        // Drawing a frame computes the SH coefficients of the environment.
        self.renderer.measure(&self.state, settings, 0, 1)?;
        let radiance_sh = self.renderer.radiance_sh()?;
        let (gpu, face_size) = (self.renderer.gpu(), self.renderer.environment().face_size());
        Ok(ForwardPass::new(gpu, &self.object, &self.state, face_size, &radiance_sh, (size.width, size.height))?)
    }
}

/// The renderers, and the rows with the indices of their renderers.
struct Bench {
    renderers: Vec<Renderer>,
    rows: Vec<(usize, Row)>,
    /// The render targets by renderer and size, which are kept so that rows of different sizes do not recreate them.
    targets: HashMap<(usize, (u32, u32)), KeptTargets>,
    /// The forward pass for rows that the renderer does not draw.
    forward: Option<ForwardPass>,
}

impl Bench {
    fn frame(&mut self, row: usize, round: usize, repeats: u32) -> Result<Frame, LabError> {
        let (index_of_renderer, row) = &self.rows[row];
        let renderer = &mut self.renderers[*index_of_renderer];
        if let (Some(kind), Some(pass)) = (row.forward, &self.forward) {
            let time = pass.measure(kind, renderer.environment().cube(), repeats)?;
            return Ok(Frame { passes: vec![time], ..Default::default() });
        }
        let targets = self.targets.entry((*index_of_renderer, row.settings.size)).or_default();
        // A row with several samples draws another sample in every round.
        let index = round as u32 % row.settings.samples.max(1);
        let mut state = row.state.clone();
        daylight::pass(&mut state, row.sun_hours * (round + 1) as f64);
        renderer.swap_targets(targets);
        let cost = renderer.cost(&state, &row.settings, index, repeats)?;
        let cpu = match repeats {
            _ if !row.is_of_a_frame() => None,
            1 => Some(cost.cpu),
            // The sun must move only once per round, so the row has no second draw for the CPU time.
            _ if row.sun_hours != 0.0 => None,
            _ => Some(renderer.cost(&state, &row.settings, index, 1)?.cpu),
        };
        renderer.swap_targets(targets);
        if row.sun_hours != 0.0
            && let Some(sky) = &row.state.sky
        {
            // The sun is moved back here, so that the next row's time does not include this work.
            renderer.show_sky(sky)?;
        }
        Ok(Frame { passes: cost.passes, cpu, triangles: cost.triangles, patches: cost.patches })
    }
}

/// Measures all rows of the renderers and of a plain forward pass in interleaved rounds.
fn measure(
    subjects: Vec<(Renderer, Vec<Row>)>,
    forward: Option<ForwardPass>,
    rounds: usize,
    output: &Output,
) -> Result<Vec<Measured>, LabError> {
    let mut bench = Bench { renderers: Vec::new(), rows: Vec::new(), targets: HashMap::new(), forward };
    for (index, (renderer, rows)) in subjects.into_iter().enumerate() {
        renderer.gpu().wait_idle()?;
        bench.renderers.push(renderer);
        bench.rows.extend(rows.into_iter().map(|row| (index, row)));
    }
    let names: Vec<String> = bench.rows.iter().map(|(_, row)| format!("{}: {}", row.table, row.name)).collect();
    let bar = output.bar(names.len(), "compiling shaders");
    let mut tick = |tick: Tick| match tick {
        Tick::Warm(row) => {
            bar.message(&format!("warming up, {}", names[row]));
            bar.step();
        }
        Tick::Begin(frames) => bar.restart(frames),
        Tick::Frame(row) => {
            bar.message(&names[row]);
            bar.step();
        }
    };
    let mut draw = |row, round, repeats| bench.frame(row, round, repeats);
    let series = rounds::measure(&mut draw, names.len(), rounds, &mut tick)?;
    Ok(bench.rows.into_iter().zip(series).map(|((_, row), series)| Measured { row, series }).collect())
}
