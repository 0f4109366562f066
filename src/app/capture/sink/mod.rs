//! Where the frames of a capture go: a file for each, or one file of all of them.

mod animation;
mod apng;
mod delays;
mod gif;
mod palette;
pub mod sheet;
mod stills;
mod webp;
mod y4m;

use std::path::Path;

use super::args::CaptureConfig;
use super::frame_source::Frame;
use super::pattern::{FileKind, MovingKind};
use crate::app::error::AppError;

/// Takes the frames of a capture one after the other and writes each before the next is drawn. Dropped before it is
/// finished, it leaves no file that is not whole.
pub trait Sink {
    /// Whether `file` is there already, whole and of the right size, and is to be kept.
    fn keeps(&self, _file: &Path) -> bool {
        false
    }

    /// Takes the next frame; `file` is the one that holds it.
    ///
    /// # Errors
    /// If the frame cannot be encoded or written.
    fn put(&mut self, file: &Path, frame: &Frame) -> Result<(), AppError>;

    /// All frames are there.
    ///
    /// # Errors
    /// If the end of the file cannot be written, or the file not be put in its place.
    fn finish(self: Box<Self>) -> Result<(), AppError>;
}

/// The sink that `config` asks for. Files of several frames are begun here, so that a folder that refuses them is found
/// before anything is drawn.
///
/// # Errors
/// If a file cannot be begun.
pub fn open(config: &CaptureConfig) -> Result<Box<dyn Sink>, AppError> {
    match config.output.kind {
        FileKind::Still(kind) => Ok(Box::new(stills::Stills::new(config, kind))),
        FileKind::Moving(MovingKind::Webp) => animation::open::<webp::Webp>(config),
        FileKind::Moving(MovingKind::Apng) => animation::open::<apng::Apng>(config),
        FileKind::Moving(MovingKind::Gif) => animation::open::<gif::Gif>(config),
        FileKind::Moving(MovingKind::Y4m) => y4m::open(config),
        FileKind::Sheet { sheet } => sheet::open(config, sheet),
    }
}

#[cfg(test)]
mod tests;
