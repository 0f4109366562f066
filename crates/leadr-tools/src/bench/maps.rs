//! The table of map sizes, with the same surface and view for each size.

use std::sync::Arc;

use super::rows::Row;
use super::scene;
use crate::command::output::Output;
use crate::error::LabError;
use leadr_gpu::{Gpu, GpuError};
use leadr_maps::procedural;
use leadr_render::frame::Renderer;
use leadr_render::settings::Technique;
use leadr_scenes::config::SceneConfig;
use leadr_scenes::error::SceneError;
use leadr_scenes::registry::Choice;
use leadr_scenes::set::{Inputs, Set, set};
use leadr_scenes::stage::{GENERATED_HEIGHT, USUAL_RELIEF};

/// The numbers of texels along an atlas tile, which give T-rex maps of about 1k to 8k texels.
const TILES: [u32; 4] = [16, 32, 64, 128];
/// The numbers of texels along a height map.
const SIDES: [u32; 4] = [1024, 2048, 4096, 8192];

/// Returns renderers of the scene, one for each map size, with their rows. All renderers stay alive, because rounds are
/// interleaved. Sizes that do not fit into device memory are skipped with a message. The largest and the smallest size are
/// created first, because goals compare these two sizes.
///
/// # Errors
/// Fails if files cannot be read, memory runs out, or the device fails.
pub fn maps(
    config: &SceneConfig,
    gpu: &Arc<Gpu>,
    only: Option<Technique>,
    output: &Output,
) -> Result<Vec<(Renderer, Vec<Row>)>, LabError> {
    let mut sets = Vec::new();
    let tiled = config.scene.offers(Choice::AtlasTile);
    let [a, b, c, d] = if tiled { TILES } else { SIDES };
    for size in [d, a, c, b] {
        let mut inputs = Inputs::load(config)?;
        let config = if tiled {
            SceneConfig { atlas_tile: size, ..config.clone() }
        } else {
            inputs.height_map = Some(procedural::rock(size, size, 1));
            SceneConfig { height: config.height.or(Some(GENERATED_HEIGHT * USUAL_RELIEF)), ..config.clone() }
        };
        match set(&config, inputs, gpu, None, &output.set_up()) {
            Ok(set) => sets.extend(set.map_size.map(|texels| (texels, config, set))),
            Err(SceneError::Gpu(error @ (GpuError::TooLarge { .. } | GpuError::InOnePiece { .. }))) => {
                output.say(&format!("maps of {size} texels are skipped: {error}"))
            }
            Err(error) => return Err(error.into()),
        }
    }
    sets.sort_by_key(|(texels, ..)| *texels);
    let first = sets.first().map(|(texels, ..)| *texels);
    let subject = |(texels, config, set): ((u32, u32), SceneConfig, Set)| {
        let rows = scene::maps(&config, &(set.animation)(0.0), [texels, first.unwrap_or(texels)], only);
        (set.renderer, rows)
    };
    Ok(sets.into_iter().map(subject).collect())
}
