//! Where the frames of a capture go: a file for each, or one file of all of them.

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

/// What an earlier run left of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Earlier {
    /// Nothing that is whole and of the right size, or nobody asked.
    Nothing,
    /// A whole frame that was made otherwise, or does not say how.
    Outdated,
    /// The very frame, whole.
    Same,
}

/// Takes the frames of a capture one after the other and writes each before the next is drawn. Dropped before it is
/// finished, it leaves no file that is not whole.
pub trait Sink {
    /// What an earlier run left in the place of `file`, the frame that comes from `origin`.
    fn earlier(&self, _file: &Path, _origin: &Origin) -> Earlier {
        Earlier::Nothing
    }

    /// Takes the next frame, which comes from `origin`; `file` is the one that holds it.
    fn put(&mut self, file: &Path, frame: &Frame, origin: &Origin) -> Result<(), AppError>;

    /// All frames are there.
    fn finish(self: Box<Self>) -> Result<(), AppError>;
}

/// The sink that `config` asks for. Files of several frames are begun here, so that a folder that refuses them is found
/// before anything is drawn.
pub fn open(config: &CaptureConfig) -> Result<Box<dyn Sink + '_>, AppError> {
    Ok(match config.output.kind {
        FileKind::Still(kind) => Box::new(stills::Stills { config, kind }),
        FileKind::Moving(MovingKind::Webp) => Box::new(webp::Webp::begin(config)?),
        FileKind::Moving(MovingKind::Y4m) => Box::new(y4m::Y4m::begin(config)?),
        FileKind::Sheet { sheet } => Box::new(sheet::ContactSheet::begin(config, sheet)?),
    })
}
