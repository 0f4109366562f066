//! What can be wrong with a model, each in one sentence that names the place in the file and ends with the remedy.

use std::path::PathBuf;

use leadr_maps::MapFault;

/// A fault together with the file it was found in. Displays as one line: `FILE: what is wrong; what would be right`.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", file.display())]
pub struct ModelError {
    /// The model that was being read.
    pub file: PathBuf,
    /// What is wrong with it.
    #[source]
    pub fault: ModelFault,
}

/// What is wrong with a model, without the file's name.
#[derive(Debug, thiserror::Error)]
pub enum ModelFault {
    /// The operating system refused; `doing` is a verb phrase such as "cannot be opened".
    #[error("{doing} ({source}); check the path and the permissions")]
    Io {
        /// What failed.
        doing: &'static str,
        /// The system's reason.
        #[source]
        source: std::io::Error,
    },
    /// A directory, pipe or device where the model was expected.
    #[error("is not a regular file; give the path of a .glb or .gltf file")]
    NotAFile,
    /// The first bytes are neither those of a GLB nor of a JSON object.
    #[error("is not a glTF model; give a .glb or .gltf file (version 2.0)")]
    Unrecognised,
    /// The container or the JSON text cannot be read.
    #[error("is damaged: {what}; export or download it again")]
    Damaged {
        /// What contradicts.
        what: String,
    },
    /// A part of the model breaks a rule of glTF in a way that leaves no sound reading.
    #[error("{place}: {what}; correct it with a glTF validator's help, or export the model again")]
    Invalid {
        /// The part, such as `mesh 2, primitive 0`.
        place: String,
        /// The rule and how it is broken.
        what: String,
    },
    /// A valid model that asks for something this reader does not have.
    #[error("cannot be used: {what}; {remedy}")]
    Unsupported {
        /// What it asks for.
        what: String,
        /// What would be supported instead.
        remedy: String,
    },
    /// Over a documented limit of [`crate::limits`], or a claim that the file is too short to fill.
    #[error("is too large: {what}; split or simplify the model")]
    TooLarge {
        /// The claim and the limit.
        what: String,
    },
    /// A file that the model refers to is not where it should be, or may not be read.
    #[error("{place}: the file {uri:?} {what}; put it into the model's folder, or pack the model into one .glb")]
    Missing {
        /// The part that refers to it.
        place: String,
        /// Its name as the model spells it.
        uri: String,
        /// Why it cannot be had.
        what: String,
    },
    /// An image of the model cannot be decoded.
    #[error("{place}: {fault}")]
    Image {
        /// The image, with its name if it has one.
        place: String,
        /// What is wrong with it.
        #[source]
        fault: MapFault,
    },
}

impl ModelFault {
    /// A contradiction in the bytes.
    pub(super) fn damaged(what: impl Into<String>) -> Self {
        Self::Damaged { what: what.into() }
    }

    /// A valid model that is not read here, and what would be.
    pub(super) fn unsupported(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Unsupported { what: what.into(), remedy: remedy.into() }
    }

    /// A claim beyond a limit.
    pub(super) fn too_large(what: impl Into<String>) -> Self {
        Self::TooLarge { what: what.into() }
    }

    /// A broken rule.
    pub(super) fn invalid(place: impl std::fmt::Display, what: impl Into<String>) -> Self {
        Self::Invalid { place: place.to_string(), what: what.into() }
    }
}

/// A foreign string as it may stand in a one-line message: no control characters, and not long.
pub(super) fn shown(text: &str) -> String {
    const LONGEST: usize = 60;
    let mut shown: String = text.chars().take(LONGEST).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(LONGEST).is_some() {
        shown.push('…');
    }
    shown
}
