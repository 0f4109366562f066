//! The tables of the sea, which list pass times for several sizes of the transforms and of the picture.

use std::sync::Arc;

use super::rounds::TOTAL;
use super::rows::Row;
use super::scene;
use crate::command::output::Output;
use crate::error::LabError;
use leadr_gpu::Gpu;
use leadr_render::frame::Renderer;
use leadr_render::settings::Technique;
use leadr_scenes::config::SceneConfig;
use leadr_scenes::ocean::waves::Waves;
use leadr_scenes::set::{Inputs, set};
use leadr_scenes::view::Size;

/// The passes that compute the wave maps, which do not depend on the picture.
pub const WAVES: &str = "wave rows+wave columns+wave mips";

/// The measured sizes of the transforms, as numbers of samples along the edge of a tile.
const TRANSFORMS: [u32; 4] = [64, 128, 256, 512];

/// Returns renderers of the sea with their rows. The rows cover every size of the transforms, then pictures of half, one and
/// two times the side length. Maps and targets of all sizes stay alive.
///
/// # Errors
/// Fails if files cannot be read, memory runs out, or the device fails.
pub fn seas(
    config: &SceneConfig,
    gpu: &Arc<Gpu>,
    only: Option<Technique>,
    output: &Output,
) -> Result<Vec<(Renderer, Vec<Row>)>, LabError> {
    let sea = |config: SceneConfig, compared, [table, name, base]: [&str; 3]| -> Result<_, LabError> {
        let set = set(&config, Inputs::load(&config)?, gpu, None, &output.set_up())?;
        let names = [table, name, base].map(str::to_owned);
        let row = scene::row(&config, only.unwrap_or(Technique::Leadr), (set.animation)(0.0), names);
        Ok((set.renderer, vec![Row { compared, ..row }]))
    };
    let transforms = TRANSFORMS.into_iter().map(|fft| {
        let config = SceneConfig { waves: Waves { fft, ..config.waves }, ..config.clone() };
        sea(config, WAVES, ["ocean, transforms", &format!("fft {fft}"), "fft 256"])
    });
    let Size { width, height } = config.size;
    let pictures = [1, 2, 4].into_iter().map(|n| {
        let size = Size { width: (width * n / 2).max(1), height: (height * n / 2).max(1) };
        let names = ["ocean, pictures", &size.to_string(), &config.size.to_string()];
        sea(SceneConfig { size, ..config.clone() }, TOTAL, names)
    });
    transforms.chain(pictures).collect()
}
