//! A file for each frame.

use std::path::Path;

use super::frame_sink::{Earlier, Sink};
use crate::app::capture::args::CaptureConfig;
use crate::app::capture::frame_source::Frame;
use crate::app::capture::pattern::StillKind;
use crate::app::capture::save::{self, Tone};
use leadr_maps::origin::Origin;
use leadr_scenes::view::Size;
use leadr_tools::command::error::AppError;

/// Writes every frame to a file of its own.
pub struct Stills {
    kind: StillKind,
    size: Size,
    tone: Tone,
    resume: bool,
}

impl Stills {
    /// Files of this kind, as `config` asks for.
    pub fn new(config: &CaptureConfig, kind: StillKind) -> Self {
        let (size, tone) = (config.scene.size, Tone::of(&config.scene));
        Self { kind, size, tone, resume: config.resume }
    }
}

impl Sink for Stills {
    fn earlier(&self, file: &Path, origin: &Origin) -> Earlier {
        if !self.resume {
            return Earlier::Nothing;
        }
        match save::origin_if_whole(file, self.kind, self.size) {
            None => Earlier::Nothing,
            Some(Some(old)) if old.fingerprint == origin.fingerprint => Earlier::Same,
            Some(_) => Earlier::Outdated,
        }
    }

    fn put(&mut self, file: &Path, frame: &Frame, origin: &Origin) -> Result<(), AppError> {
        save::save(file, self.kind, frame, self.tone, origin)
    }

    fn finish(self: Box<Self>) -> Result<(), AppError> {
        Ok(())
    }
}
