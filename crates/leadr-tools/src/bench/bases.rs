//! The table of base materials, with the same relief and view for each material.

use std::sync::Arc;

use super::rows::Row;
use super::scene;
use crate::command::output::Output;
use crate::error::LabError;
use crate::fit::specimen::{Lacquer, as_beckmann, dressed};
use leadr_gpu::Gpu;
use leadr_maps::procedural;
use leadr_render::frame::Renderer;
use leadr_render::settings::Technique;
use leadr_scenes::config::SceneConfig;
use leadr_scenes::set::{Inputs, set};

/// The number of texels along a side of the relief, and the depth of the relief in metres.
const SIDE: u32 = 1024;
const DEPTH: f32 = 0.09;
/// The name of the row with which all others are compared.
const ONE_LOBE: &str = "one Beckmann lobe";

/// Returns renderers with their rows, for one Beckmann lobe, a GGX base of the same roughness, and the lobes of a measured
/// material. `only` is a technique that replaces LEADR.
///
/// # Errors
/// Fails if memory runs out or the device fails.
pub fn bases(
    config: &SceneConfig,
    gpu: &Arc<Gpu>,
    only: Option<Technique>,
    output: &Output,
) -> Result<Vec<(Renderer, Vec<Row>)>, LabError> {
    let fit = Lacquer::fit().ok_or_else(|| LabError("the lacquer has no fit".to_owned()))?;
    let measured = dressed(&fit, "lacquer", procedural::rock(SIDE, SIDE, 1), DEPTH);
    let technique = only.unwrap_or(Technique::Leadr);
    let mut rows_of = [vec![(ONE_LOBE.to_owned(), technique)], vec![]];
    if only.is_none() {
        rows_of[0].push(("GGX".to_owned(), Technique::LeadrGgx));
    }
    rows_of[1].push((format!("measured, {} lobes", fit.lobes.len()), technique));
    let mut subjects = Vec::new();
    for (material, rows) in [as_beckmann(&measured, &fit), measured].into_iter().zip(rows_of) {
        let inputs = Inputs { material: Some(material), ..Inputs::load(config)? };
        let set = set(config, inputs, gpu, None, &output.set_up())?;
        let state = (set.animation)(0.0);
        let rows = rows.into_iter().map(|(name, technique)| {
            let names = [format!("{} by base", config.scene.name), name, ONE_LOBE.to_owned()];
            scene::row(config, technique, state.clone(), names)
        });
        subjects.push((set.renderer, rows.collect()));
    }
    Ok(subjects)
}
