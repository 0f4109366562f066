//! Files of materials for other programs, such as BRDF Explorer, Mitsuba and pbrt.

use std::path::Path;

use super::{has_extension, merl, rgl_write, slice};
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_reflectance::materials::fitted::FittedBrdf;

/// A format of exported materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Export {
    /// A `.binary` file with all angles of the MERL database.
    Merl,
    /// A `.pfm` file with the slice at `φ_d = 90°`.
    Slice,
    /// A `.bsdf` file in the format of the RGL database, with RGB and spectra.
    Rgl,
}

impl Export {
    /// The names of the formats, for error messages.
    pub const NAMES: &str = ".binary (MERL), .pfm (the slice at φ_d = 90°) or .bsdf (RGL)";

    /// Returns the format of a file name, or `None` for other extensions.
    pub fn of(file: &Path) -> Option<Self> {
        [("binary", Self::Merl), ("pfm", Self::Slice), ("bsdf", Self::Rgl)]
            .into_iter()
            .find_map(|(extension, format)| has_extension(file, extension).then_some(format))
    }

    /// Returns the content of a file with any isotropic material, or `None` for an RGL file, which needs the slopes of its facets.
    pub fn bytes_of_any(self, brdf: &impl Brdf) -> Option<Vec<u8>> {
        match self {
            Self::Merl => Some(merl::write(brdf)),
            Self::Slice => Some(slice::write(brdf)),
            Self::Rgl => None,
        }
    }

    /// Returns the content of a file. Only an RGL file holds an anisotropic material and its `description`.
    pub fn bytes<D: SlopeDistribution>(self, brdf: &FittedBrdf<D>, isotropic: bool, description: &str) -> Vec<u8> {
        self.bytes_of_any(brdf).unwrap_or_else(|| rgl_write::write(brdf, isotropic, description))
    }
}
