//! How a command can fail.

use thiserror::Error;

use crate::error::LabError;
use leadr_gpu::GpuError;
use leadr_maps::MapError;
use leadr_scenes::error::SceneError;

/// A failed command. Each message is one sentence: what failed, why, and how to put it right.
#[derive(Debug, Error)]
pub enum AppError {
    /// The command line asks for something that makes no sense; exit code 2.
    #[error("{0}")]
    Usage(String),
    /// The work failed (input, device, disk) or a result is over its threshold; exit code 1.
    #[error("{0}")]
    Failed(String),
}

impl AppError {
    /// The process's exit code for this error.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Failed(_) => 1,
        }
    }

    /// A failure to read or write `path`: `cannot {verb} 'path': reason`.
    pub fn io(verb: &str, path: &std::path::Path, reason: impl std::fmt::Display) -> Self {
        Self::Failed(format!("cannot {verb} '{}': {reason}", path.display()))
    }
}

impl From<MapError> for AppError {
    fn from(error: MapError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<GpuError> for AppError {
    fn from(error: GpuError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<SceneError> for AppError {
    fn from(error: SceneError) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<LabError> for AppError {
    fn from(error: LabError) -> Self {
        Self::Failed(error.to_string())
    }
}
