//! Faults of files. Each fault has a one-line message that ends with the remedy.

use crate::shown::shown_path;
use std::path::{Path, PathBuf};

/// A fault together with its file. The message is one line: `FILE: what is wrong; remedy`.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", shown_path(file))]
pub struct MapError {
    /// The path of the file, or the name given to bytes in memory.
    pub file: PathBuf,
    /// The fault.
    #[source]
    pub fault: MapFault,
}

/// A fault of a map, without the file name.
#[derive(Debug, thiserror::Error)]
pub enum MapFault {
    /// The operating system reported an error. `doing` is a verb phrase such as "cannot be opened".
    #[error("{doing} ({source}); {}", advice(doing))]
    Io {
        /// The failed operation.
        doing: &'static str,
        /// The error of the operating system.
        #[source]
        source: std::io::Error,
    },
    /// The path is a directory, pipe or device instead of a file.
    #[error("is not a regular file; give the path of an image file")]
    NotAFile,
    /// A link in the folder of a model or a material leads to a file outside the folder.
    #[error("the link {link:?} leads out of its folder; add --follow-links if you trust it")]
    OutsideLink {
        /// The link, relative to the folder.
        link: PathBuf,
    },
    /// The first bytes match no accepted format.
    #[error("is not an image in a supported format; give {expected}")]
    Unrecognised {
        /// The accepted formats.
        expected: &'static str,
    },
    /// The file violates its format.
    #[error("is damaged: {what}; export or download it again")]
    Damaged {
        /// A description of the violation.
        what: String,
    },
    /// The file is valid but uses a feature that this reader does not support.
    #[error("cannot be used: {what}; {remedy}")]
    Unsupported {
        /// The unsupported feature.
        what: String,
        /// A supported alternative to the feature.
        remedy: String,
    },
    /// The file exceeds a limit of [`crate::limits`], or declares more data than it can contain.
    #[error("is too large: {what}; scale the image down or save it with less compression")]
    TooLarge {
        /// The declared size and the limit.
        what: String,
    },
    /// The width or height is zero.
    #[error("is empty ({width} x {height} texels); at least 1 x 1 is needed")]
    Empty {
        /// The width in texels.
        width: u64,
        /// The height in texels.
        height: u64,
    },
    /// A texel has a value that would invalidate later sums, because it is NaN, infinite or out of range.
    #[error("holds {value} in channel {channel} at x = {x}, y = {y} (from the top left); {remedy}")]
    BadTexel {
        /// The channel name: `height`, `R`, `G` or `B`.
        channel: &'static str,
        /// The column of the texel, counted from 0 at the left.
        x: u32,
        /// The row of the texel, counted from 0 at the top.
        y: u32,
        /// The invalid value.
        value: f32,
        /// The accepted range of values.
        remedy: &'static str,
    },
    /// Two images differ in size, or the length of a buffer is not width times height.
    #[error("{what}; both must have the same size")]
    SizeMismatch {
        /// The sizes of the two images, or of the buffer and the image.
        what: String,
    },
}

impl MapFault {
    /// Adds the file name to the fault.
    pub fn in_file(self, file: impl AsRef<Path>) -> MapError {
        MapError { file: file.as_ref().to_path_buf(), fault: self }
    }

    /// Creates the fault for a violation of the file format.
    pub fn damaged(what: impl Into<String>) -> Self {
        Self::Damaged { what: what.into() }
    }

    /// Creates the fault for an unsupported feature. `remedy` says what to use instead.
    pub fn unsupported(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Unsupported { what: what.into(), remedy: remedy.into() }
    }

    /// Creates the fault for a declared size above a limit.
    pub fn too_large(what: impl Into<String>) -> Self {
        Self::TooLarge { what: what.into() }
    }

    /// Creates the fault for an invalid value. `index` is the texel's index in an image that is `width` texels wide.
    pub(crate) fn bad_texel(index: usize, width: u32, channel: &'static str, value: f32, remedy: &'static str) -> Self {
        let [x, y] = [index % width as usize, index / width as usize].map(|coordinate| coordinate as u32);
        Self::BadTexel { channel, x, y, value, remedy }
    }

    /// Returns a conversion from errors of the operating system. `doing` is described at [`Self::Io`].
    pub fn io(doing: &'static str) -> impl Fn(std::io::Error) -> Self + Copy {
        move |source| Self::Io { doing, source }
    }
}

/// Returns what to check after a failed operation of [`MapFault::Io`].
fn advice(doing: &str) -> &'static str {
    match doing {
        "cannot be written" => "check the path, the permissions and the free space",
        _ => "check the path and the permissions",
    }
}

/// Returns the error message of another crate, without line breaks.
pub(crate) fn one_line(message: &dyn std::fmt::Display) -> String {
    message.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}
