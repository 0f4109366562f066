//! Errors that occur when a scene is built.

use std::path::Path;

use leadr_gpu::{GpuError, binary};
use leadr_maps::MapError;
use leadr_maps::shown::shown_path;
use leadr_models::ModelError;

/// A failure to build or upload a scene. Each message is a single sentence.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The tile size of the T-rex is not a power of two from 8 to 128 texels.
    #[error("tiles of {0} texels cannot be baked; choose 8, 16, 32, 64 or 128")]
    Tile(u32),
    /// An input file is missing, damaged, too large or of the wrong type.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The model file cannot be read.
    #[error(transparent)]
    ModelFile(#[from] ModelError),
    /// The model cannot be shown; the message gives the reason and a remedy.
    #[error("{0}")]
    Model(String),
    /// The machine has too little free memory.
    #[error(
        "making {what} needs about {} of this machine's memory, but {} are free: use {remedy}",
        binary(*needs), binary(*left)
    )]
    Memory {
        /// The name of the object that needs memory.
        what: String,
        /// The required memory in bytes.
        needs: u64,
        /// The free memory in bytes.
        left: u64,
        /// A configuration that needs less memory.
        remedy: &'static str,
    },
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl SceneError {
    /// Adds the model's file name to the message.
    #[must_use]
    pub fn of_file(self, file: &Path) -> Self {
        match self {
            Self::Model(fault) => Self::Model(format!("{}: {fault}", shown_path(file))),
            other => other,
        }
    }
}
