//! A scene over maps of different sizes: the same surface, from the same place, of more and more texels.

use std::sync::Arc;

use super::rows::Row;
use super::scene;
use crate::gpu::Gpu;
use crate::lab::error::LabError;
use crate::lab::progress::Progress;
use crate::maps::procedural;
use crate::render::frame::Renderer;
use crate::render::settings::Technique;
use crate::scenes::config::SceneConfig;
use crate::scenes::registry::Choice;
use crate::scenes::set::{Inputs, set};
use crate::scenes::stage::GENERATED_HEIGHT;

/// Texels along the tiles of an atlas: of the T-rex, maps of about 1k to 8k.
const TILES: [u32; 4] = [16, 32, 64, 128];
/// Texels along a map of heights.
const SIDES: [u32; 4] = [1024, 2048, 4096, 8192];

/// Renderers of the scene over maps of each size, each with its rows. All of them stay alive, so that they can be drawn in turn.
///
/// # Errors
/// Files, memory or a device that fail.
pub fn maps(
    config: &SceneConfig,
    gpu: &Arc<Gpu>,
    only: Option<Technique>,
    progress: &dyn Progress,
) -> Result<Vec<(Renderer, Vec<Row>)>, LabError> {
    let mut subjects = Vec::new();
    let mut first = None;
    let tiled = config.scene.offers(Choice::AtlasTile);
    for size in if tiled { TILES } else { SIDES } {
        let mut inputs = Inputs::load(config)?;
        let config = if tiled {
            SceneConfig { atlas_tile: size, ..config.clone() }
        } else {
            inputs.height_map = Some(procedural::rock(size, size, 1));
            SceneConfig { height_scale: GENERATED_HEIGHT * config.height_scale, ..config.clone() }
        };
        let set = set(&config, inputs, gpu, None, &progress.share(config.scene.making))?;
        let Some(texels) = set.map_size else { continue };
        let rows = scene::maps(&config, &(set.animation)(0.0), [texels, *first.get_or_insert(texels)], only);
        subjects.push((set.renderer, rows));
    }
    Ok(subjects)
}
