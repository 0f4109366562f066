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
    /// The same, told by a file's reader or writer.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The same, told by the device.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The same, told by a scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The same, told by a measurement.
    #[error(transparent)]
    Lab(#[from] LabError),
}

impl AppError {
    /// The process's exit code for this error.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            _ => 1,
        }
    }

    /// A failure to read or write `path`: `cannot {verb} 'path': reason`.
    pub fn io(verb: &str, path: &std::path::Path, reason: impl std::fmt::Display) -> Self {
        Self::Failed(format!("cannot {verb} '{}': {reason}", path.display()))
    }
}
