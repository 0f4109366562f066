//! Writes one file per frame.

use std::path::Path;

use super::comparison::TechniqueErrors;
use super::{Earlier, Sink};
use crate::app::capture::args::CaptureConfig;
use crate::app::capture::frame_source::Frame;
use crate::app::capture::pattern::StillKind;
use crate::app::capture::save;
use leadr_maps::origin::Origin;
use leadr_tools::command::error::AppError;

/// Writes each frame to a separate file.
pub struct Stills<'a> {
    pub config: &'a CaptureConfig,
    pub kind: StillKind,
}

impl Sink for Stills<'_> {
    fn earlier(&self, file: &Path, origin: &Origin) -> Earlier {
        if !self.config.resume {
            return Earlier::Nothing;
        }
        match save::origin_if_whole(file, self.kind, self.config.scene.size) {
            None => Earlier::Nothing,
            Some(Some(old)) if old.fingerprint == origin.fingerprint => Earlier::Same,
            Some(_) => Earlier::Outdated,
        }
    }

    fn put(&mut self, file: &Path, frame: &Frame, origin: &Origin) -> Result<(), AppError> {
        save::save(file, self.kind, frame, &self.config.scene.picture, origin)
    }

    fn finish(self: Box<Self>) -> Result<Vec<TechniqueErrors>, AppError> {
        Ok(Vec::new())
    }
}
