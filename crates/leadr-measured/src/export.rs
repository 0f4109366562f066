//! Files of isotropic materials for other programs, such as BRDF Explorer.

use std::path::Path;

use super::{has_extension, merl, slice};
use leadr_reflectance::materials::brdf::Brdf;

/// A format of exported materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Export {
    /// A `.binary` file with all angles of the MERL database.
    Merl,
    /// A `.pfm` file with the slice at `φ_d = 90°`.
    Slice,
}

impl Export {
    /// The names of the formats, for error messages.
    pub const NAMES: &str = ".binary (MERL) or .pfm (the slice at φ_d = 90°)";

    /// Returns the format of a file name, or `None` for other extensions.
    pub fn of(file: &Path) -> Option<Self> {
        [("binary", Self::Merl), ("pfm", Self::Slice)]
            .into_iter()
            .find_map(|(extension, format)| has_extension(file, extension).then_some(format))
    }

    /// Returns the content of a file of an isotropic `brdf`.
    pub fn bytes(self, brdf: &dyn Brdf) -> Vec<u8> {
        match self {
            Self::Merl => merl::write(brdf),
            Self::Slice => slice::write(brdf),
        }
    }
}
