//! The error of a failed command.

use thiserror::Error;

use crate::error::LabError;
use leadr_gpu::GpuError;
use leadr_maps::MapError;
use leadr_maps::shown::shown_path;
use leadr_scenes::error::SceneError;

/// A failed command. Each error message is one sentence with the failure, its reason and the remedy.
#[derive(Debug, Error)]
pub enum AppError {
    /// Wrong usage, because the command line is invalid or contradictory. The exit code is 2.
    #[error("{0}")]
    Usage(String),
    /// The work failed (input, device, disk), or a result exceeds its threshold. The exit code is 1.
    #[error("{0}")]
    Failed(String),
    /// An error of a file reader or writer, with exit code 1.
    #[error(transparent)]
    Map(#[from] MapError),
    /// An error of the device, with exit code 1.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// An error of a scene, with exit code 1.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// An error of a measurement, with exit code 1.
    #[error(transparent)]
    Lab(#[from] LabError),
}

impl AppError {
    /// Returns the exit code of the process for this error.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            _ => 1,
        }
    }

    /// Creates the error for a failure to read or write `path`: `cannot {verb} 'path': reason`.
    pub fn io(verb: &str, path: &std::path::Path, reason: impl std::fmt::Display) -> Self {
        Self::Failed(format!("cannot {verb} '{}': {reason}", shown_path(path)))
    }
}
