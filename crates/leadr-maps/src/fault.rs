//! What can be wrong with a file, each in one sentence that ends with the remedy.

use std::path::{Path, PathBuf};

/// A fault together with the file it was found in. Displays as one line: `FILE: what is wrong; what would be right`.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", file.display())]
pub struct MapError {
    /// The file that was being read or written (or the name given to the bytes).
    pub file: PathBuf,
    /// What is wrong with it.
    #[source]
    pub fault: MapFault,
}

/// What is wrong with a map, without the file's name.
#[derive(Debug, thiserror::Error)]
pub enum MapFault {
    /// The operating system refused; `doing` is a verb phrase such as "cannot be opened".
    #[error("{doing} ({source}); check the path, the permissions and the free space")]
    Io {
        /// What failed.
        doing: &'static str,
        /// The system's reason.
        #[source]
        source: std::io::Error,
    },
    /// A directory, pipe or device where a file was expected.
    #[error("is not a regular file; give the path of an image file")]
    NotAFile,
    /// The first bytes match no format that is accepted here.
    #[error("is not an image this program reads here; expected {expected}")]
    Unrecognised {
        /// The accepted formats, in words.
        expected: &'static str,
    },
    /// The bytes contradict the format.
    #[error("is damaged: {what}; export or download it again")]
    Damaged {
        /// What contradicts.
        what: String,
    },
    /// A valid file that this reader does not support.
    #[error("cannot be used: {what}; {remedy}")]
    Unsupported {
        /// What is not supported.
        what: String,
        /// What would be supported instead.
        remedy: String,
    },
    /// Over a documented limit of [`crate::limits`], or a claim that the file is too short to fill.
    #[error("is too large: {what}; scale the image down or save it with less compression")]
    TooLarge {
        /// The claim and the limit.
        what: String,
    },
    /// Zero width or height.
    #[error("is empty ({width} x {height} texels); at least 1 x 1 is needed")]
    Empty {
        /// Width in texels.
        width: u64,
        /// Height in texels.
        height: u64,
    },
    /// A texel whose value (NaN, infinite or out of range) would spoil every later sum.
    #[error("holds {value} in channel {channel} at x = {x}, y = {y} (from the top left); {remedy}")]
    BadTexel {
        /// Channel name: `height`, `R`, `G` or `B`.
        channel: &'static str,
        /// Column from the left, from 0.
        x: u32,
        /// Row from the top, from 0.
        y: u32,
        /// The value found.
        value: f32,
        /// The accepted range, in words.
        remedy: &'static str,
    },
    /// Two images that must agree in size do not; also a buffer whose length is not width x height.
    #[error("{what}; both must have the same size")]
    SizeMismatch {
        /// The two sizes, in words.
        what: String,
    },
}

impl MapFault {
    /// Names the file in which the fault was found.
    pub fn in_file(self, file: impl AsRef<Path>) -> MapError {
        MapError { file: file.as_ref().to_path_buf(), fault: self }
    }

    /// A contradiction in the bytes.
    pub fn damaged(what: impl Into<String>) -> Self {
        Self::Damaged { what: what.into() }
    }

    /// A valid file that is not read here, and what would be.
    pub fn unsupported(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Unsupported { what: what.into(), remedy: remedy.into() }
    }

    /// A claim beyond a limit.
    pub fn too_large(what: impl Into<String>) -> Self {
        Self::TooLarge { what: what.into() }
    }

    /// A value in the texel at an index of an image `width` across.
    pub(crate) fn bad_texel(index: usize, width: u32, channel: &'static str, value: f32, remedy: &'static str) -> Self {
        let [x, y] = [index % width as usize, index / width as usize].map(|place| place as u32);
        Self::BadTexel { channel, x, y, value, remedy }
    }

    /// What the operating system refused, from its reason; `doing` as in [`Self::Io`].
    pub fn io(doing: &'static str) -> impl Fn(std::io::Error) -> Self + Copy {
        move |source| Self::Io { doing, source }
    }
}

/// A foreign error message without line breaks.
pub(crate) fn one_line(message: &dyn std::fmt::Display) -> String {
    message.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
