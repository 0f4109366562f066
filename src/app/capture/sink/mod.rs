//! Writers of the frames of a capture: one file per frame, or one file for all frames.

mod sheet;
mod stills;
mod webp;
mod y4m;

#[cfg(test)]
mod tests;

use std::path::Path;

use super::args::CaptureConfig;
use super::frame_source::Frame;
use super::pattern::{FileKind, MovingKind};
use leadr_maps::origin::Origin;
use leadr_tools::command::error::AppError;

/// The state of the file that an earlier run wrote for a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Earlier {
    /// No complete file of the right size, or no `--resume`.
    Nothing,
    /// A complete frame with another fingerprint, or without one.
    Outdated,
    /// A complete frame with the same fingerprint.
    Same,
}

/// Writes the frames of a capture, each before the next is drawn. A sink that is dropped before [`finish`](Sink::finish) leaves no
/// partial file.
pub trait Sink {
    /// Compares an existing `file` with `origin`, the origin of the frame to draw.
    fn earlier(&self, _file: &Path, _origin: &Origin) -> Earlier {
        Earlier::Nothing
    }

    /// Writes the next frame, of this origin. `file` is the path of its file, or of the file of all frames.
    fn put(&mut self, file: &Path, frame: &Frame, origin: &Origin) -> Result<(), AppError>;

    /// Completes the file of all frames.
    fn finish(self: Box<Self>) -> Result<(), AppError>;
}

/// Opens the sink for `config`. Files of several frames are created here, so an unwritable folder is reported before anything is drawn.
pub fn open(config: &CaptureConfig) -> Result<Box<dyn Sink + '_>, AppError> {
    Ok(match config.output.kind {
        FileKind::Still(kind) => Box::new(stills::Stills { config, kind }),
        FileKind::Moving(MovingKind::Webp) => Box::new(webp::Webp::begin(config)?),
        FileKind::Moving(MovingKind::Y4m) => Box::new(y4m::Y4m::begin(config)?),
        FileKind::Sheet { sheet } => Box::new(sheet::ContactSheet::begin(config, sheet)?),
    })
}
