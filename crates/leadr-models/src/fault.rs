//! Faults of models. Each fault has a one-line message with the location in the file and the remedy.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use leadr_maps::MapFault;
pub(super) use leadr_maps::shown::shown;
use leadr_maps::shown::shown_path;

/// A fault together with its file. The message is one line: `FILE: what is wrong; remedy`.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", shown_path(file))]
pub struct ModelError {
    /// The model file.
    pub file: PathBuf,
    /// The fault.
    #[source]
    pub fault: ModelFault,
}

/// A fault of a model, without the file name.
#[derive(Debug, thiserror::Error)]
pub enum ModelFault {
    /// The operating system reported an error. `doing` is a verb phrase such as "cannot be opened".
    #[error("{doing} ({source}); check the path and the permissions")]
    Io {
        /// The failed operation.
        doing: &'static str,
        /// The error of the operating system.
        #[source]
        source: std::io::Error,
    },
    /// The path is a directory, pipe or device instead of a model file.
    #[error("is not a regular file; give the path of a .glb or .gltf file")]
    NotAFile,
    /// The first bytes are neither a GLB header nor a JSON object.
    #[error("is not a glTF model; give a .glb or .gltf file (version 2.0)")]
    Unrecognised,
    /// The container or the JSON text cannot be read.
    #[error("is damaged: {what}; export or download it again")]
    Damaged {
        /// A description of the violation.
        what: String,
    },
    /// A part of the model violates a rule of glTF beyond repair.
    #[error("{location}: {what}; correct it with the help of a glTF validator, or export the model again")]
    Invalid {
        /// The location of the invalid part, such as `mesh 2, primitive 0`.
        location: String,
        /// The rule, and how the model violates the rule.
        what: String,
    },
    /// The model is valid but needs an unsupported feature.
    #[error("cannot be used: {what}; {remedy}")]
    Unsupported {
        /// The unsupported feature.
        what: String,
        /// A supported alternative to the feature.
        remedy: String,
    },
    /// The model exceeds a limit of [`crate::limits`], or declares more data than the file can contain.
    #[error("is too large: {what}; split or simplify the model")]
    TooLarge {
        /// The declared size and the limit.
        what: String,
    },
    /// A file of the model is missing or may not be read.
    #[error("{location}: the file \"{uri}\" {what}; put it into the model's folder, or pack the model into one .glb")]
    Missing {
        /// The location of the part that refers to the file.
        location: String,
        /// The name of the file as written in the model.
        uri: String,
        /// The reason why the file cannot be read.
        what: String,
    },
    /// A file of the model is behind a link out of its folder.
    #[error("{location}: {fault}")]
    Outside {
        /// The part that refers to the file, and the file.
        location: String,
        /// The link and the remedy.
        #[source]
        fault: MapFault,
    },
    /// An image of the model cannot be decoded.
    #[error("{location}: {fault}")]
    Image {
        /// The location of the image, with its name if it has one.
        location: String,
        /// The fault of the image file.
        #[source]
        fault: MapFault,
    },
}

impl ModelFault {
    pub(super) fn damaged(what: impl Into<String>) -> Self {
        Self::Damaged { what: what.into() }
    }

    pub(super) fn unsupported(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Unsupported { what: what.into(), remedy: remedy.into() }
    }

    pub(super) fn too_large(what: impl Into<String>) -> Self {
        Self::TooLarge { what: what.into() }
    }

    pub(super) fn invalid(location: impl std::fmt::Display, what: impl Into<String>) -> Self {
        Self::Invalid { location: location.to_string(), what: what.into() }
    }
}

/// The fault of a part that other parts may use. It is reported by each part that uses it.
#[derive(Debug)]
pub(super) struct Broken {
    /// The fault, until it is reported first.
    first: Mutex<Option<Box<ModelFault>>>,
    location: String,
    what: String,
}

impl Broken {
    pub(super) fn new(fault: ModelFault) -> Self {
        let (location, what) = match &fault {
            ModelFault::Invalid { location, what } => (location.clone(), what.clone()),
            ModelFault::Missing { location, .. } | ModelFault::Outside { location, .. } => {
                (location.clone(), "cannot be read".into())
            }
            _ => ("the model".into(), "has parts that cannot be read".into()),
        };
        Self { first: Mutex::new(Some(Box::new(fault))), location, what }
    }

    pub(super) fn fault(&self) -> ModelFault {
        let first = self.first.lock().unwrap_or_else(PoisonError::into_inner).take();
        first.map_or_else(|| ModelFault::invalid(&self.location, self.what.clone()), |fault| *fault)
    }
}
