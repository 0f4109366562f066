//! The sink for each kind of output.

use super::frame_sink::Sink;
use super::{sheet, stills, webp, y4m};
use crate::app::capture::args::CaptureConfig;
use crate::app::capture::pattern::{FileKind, MovingKind};
use leadr_tools::command::error::AppError;

/// The sink that `config` asks for. Files of several frames are begun here, so that a folder that refuses them is found
/// before anything is drawn.
pub fn open(config: &CaptureConfig) -> Result<Box<dyn Sink>, AppError> {
    match config.output.kind {
        FileKind::Still(kind) => Ok(Box::new(stills::Stills::new(config, kind))),
        FileKind::Moving(MovingKind::Webp) => webp::open(config),
        FileKind::Moving(MovingKind::Y4m) => y4m::open(config),
        FileKind::Sheet { sheet } => sheet::open(config, sheet),
    }
}
