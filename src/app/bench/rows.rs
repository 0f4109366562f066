//! What is measured: the rows of every table, and the goals over them.

use super::goals::{Bound, Goal, Place};
use super::rounds::{PIXELS, TOTAL};
use crate::app::config::SceneConfig;
use crate::app::renderer_source::render_settings;
use crate::app::values::{self, Size};
use crate::render::scene::FrameState;
use crate::render::settings::{RenderSettings, ShadingSettings, Technique};
use crate::render::tessellation::TessellationSettings;

/// One thing that is drawn again and again.
#[derive(Clone, Debug)]
pub struct Row {
    /// The table it stands in.
    pub table: String,
    /// Its name there.
    pub name: String,
    /// Where slope samples lie: `grid` or `visible`; none for techniques without.
    pub rule: Option<&'static str>,
    /// Slope samples of a pixel.
    pub samples: u32,
    /// Masking and shadowing.
    pub visibility: &'static str,
    /// Metres to the camera's target, where that differs between rows.
    pub distance: Option<f32>,
    /// The row of the table that this one is compared with.
    pub base: Option<String>,
    /// The time that is compared.
    pub compared: &'static str,
    /// The paper's time on its GPU.
    pub paper_ms: Option<f64>,
    /// The scene.
    pub state: FrameState,
    /// How it is drawn.
    pub settings: RenderSettings,
}

/// Tables of time against the number of samples.
pub const FIGURE_11: [&str; 1] = ["figure 11: specular environment"];

/// The goals that times can meet.
pub const GOALS: [Goal; 1] = [Goal {
    name: "sphere: 64 reference samples against LEADR",
    of: Place { table: "sphere", row: "reference", pass: "geometry+filter+shade+accumulate", times: 64 },
    to: Place { table: "sphere", row: "leadr", pass: TOTAL, times: 1 },
    bound: Bound::AtLeast(50.0),
}];

/// The tables of the full-screen quad.
#[must_use]
pub fn quad(state: &FrameState, size: Size) -> Vec<Row> {
    let settings = |shading| RenderSettings {
        size: (size.width, size.height),
        shading,
        tessellation: TessellationSettings { max_factor: 1.0, cull: false, ..Default::default() },
        shadows: false,
        ..Default::default()
    };
    (1..=5)
        .map(|n| Row {
            table: FIGURE_11[0].to_owned(),
            name: format!("leadr {n}x{n}"),
            rule: Some("grid"),
            samples: n * n,
            visibility: "masking",
            distance: None,
            base: Some("leadr 1x1".to_owned()),
            compared: PIXELS,
            paper_ms: None,
            state: state.clone(),
            settings: settings(ShadingSettings { grid: n, ..Default::default() }),
        })
        .collect()
}

/// Rows of a scene.
#[must_use]
pub fn scene(config: &SceneConfig, state: &FrameState, technique: Option<values::Technique>) -> Vec<Row> {
    let _ = (state, technique, Technique::Leadr);
    let _ = render_settings(config);
    Vec::new()
}
