//! What takes the frames of a capture.

use std::path::Path;

use crate::app::capture::frame_source::Frame;
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
