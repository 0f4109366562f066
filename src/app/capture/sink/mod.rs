//! Writes the frames of a capture to one file per frame, or to one file for all frames.

pub mod comparison;
mod labels;
mod sheet;
mod stills;
mod webp;
mod y4m;

#[cfg(test)]
mod tests;

use std::path::Path;

use self::comparison::TechniqueErrors;
use super::args::CaptureConfig;
use super::frame_source::Frame;
use super::pattern::{FileKind, MovingKind};
use leadr_maps::origin::Origin;
use leadr_tools::command::error::AppError;

/// The state of the file that an earlier run wrote for a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Earlier {
    /// There is no complete file of the right size, or `--resume` is not set.
    Nothing,
    /// The file is complete, but its fingerprint differs or is missing.
    Outdated,
    /// The file is complete and has the same fingerprint.
    Same,
}

/// Writes the frames of a capture. A frame is written before the next frame is drawn. If a sink is dropped before [`finish`](Sink::finish),
/// no partial file remains.
pub trait Sink {
    /// Compares an existing `file` with `origin`, the origin of the frame that will be drawn.
    fn earlier(&self, _file: &Path, _origin: &Origin) -> Earlier {
        Earlier::Nothing
    }

    /// Writes the next frame with its origin. `file` is the path of its file, or of the file for all frames.
    fn put(&mut self, file: &Path, frame: &Frame, origin: &Origin) -> Result<(), AppError>;

    /// Completes the file for all frames. Returns the measured differences of techniques, if the file compares them.
    fn finish(self: Box<Self>) -> Result<Vec<TechniqueErrors>, AppError>;
}

/// Opens the sink for `config`. Files for several frames are created immediately, so that an unwritable folder is reported before anything
/// is drawn.
pub fn open(config: &CaptureConfig) -> Result<Box<dyn Sink + '_>, AppError> {
    Ok(match config.output.kind {
        FileKind::Still(kind) => Box::new(stills::Stills { config, kind }),
        FileKind::Moving(MovingKind::Webp) => Box::new(webp::Webp::begin(config)?),
        FileKind::Moving(MovingKind::Y4m) => Box::new(y4m::Y4m::begin(config)?),
        FileKind::Comparison => Box::new(comparison::ComparisonSheet::begin(config)?),
        FileKind::Sheet { sheet } => Box::new(sheet::ContactSheet::begin(config, sheet)?),
    })
}
