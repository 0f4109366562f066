//! The error of a failed measurement.

use std::fmt::Display;
use std::path::Path;

use thiserror::Error;

use leadr_gpu::GpuError;
use leadr_maps::MapError;
use leadr_maps::shown::shown_path;
use leadr_scenes::error::SceneError;

/// A failed measurement, with a message of one sentence that gives the failure and the reason.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct LabError(pub String);

impl LabError {
    /// Creates the error for a failure to read or write `path`: `cannot {verb} 'path': reason`.
    pub fn io(verb: &str, path: &Path, reason: impl Display) -> Self {
        Self(format!("cannot {verb} '{}': {reason}", shown_path(path)))
    }

    /// Creates the error for a result that cannot be serialised as JSON.
    pub fn json(reason: &serde_json::Error) -> Self {
        Self(format!("cannot write JSON: {reason}"))
    }
}

impl From<MapError> for LabError {
    fn from(error: MapError) -> Self {
        Self(error.to_string())
    }
}

impl From<GpuError> for LabError {
    fn from(error: GpuError) -> Self {
        Self(error.to_string())
    }
}

impl From<SceneError> for LabError {
    fn from(error: SceneError) -> Self {
        Self(error.to_string())
    }
}
