//! Why a scene cannot be made.

use std::path::Path;

use leadr_gpu::{GpuError, binary};
use leadr_maps::MapError;
use leadr_models::ModelError;

/// A scene that cannot be made or put on the device. Each message is one sentence.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Tiles of the T-rex must be powers of two from 8 to 128 texels.
    #[error("tiles of {0} texels cannot be baked; choose 8, 16, 32, 64 or 128")]
    Tile(u32),
    /// An input file is missing, damaged, too large or of another kind.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A model that cannot be read.
    #[error(transparent)]
    ModelFile(#[from] ModelError),
    /// A model that cannot be shown: why, and what to do.
    #[error("{0}")]
    Model(String),
    /// The machine has too little memory left to make it.
    #[error(
        "making {what} takes some {} of this machine's memory, and {} are left: take {remedy}",
        binary(*needs), binary(*left)
    )]
    Memory {
        /// What is made.
        what: String,
        /// Bytes that it takes.
        needs: u64,
        /// Bytes that are left.
        left: u64,
        /// What would take less.
        remedy: &'static str,
    },
    /// The device failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

impl SceneError {
    /// The same told of the model's file.
    #[must_use]
    pub fn of_file(self, file: &Path) -> Self {
        match self {
            Self::Model(fault) => Self::Model(format!("{}: {fault}", file.display())),
            other => other,
        }
    }
}
