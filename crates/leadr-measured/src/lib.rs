//! Evaluates measured materials on the CPU. The crate reads the files of reflectance databases, and evaluates them as a [`Brdf`].
//!
//! | file | database | content |
//! |---|---|---|
//! | `.binary` | MERL (Matusik et al. 2003) | isotropic, 90 × 90 × 180 half and difference angles ([`merl`]) |
//! | `.bsdf` | RGL (Dupuy and Jakob 2018) | isotropic or anisotropic, in coordinates adapted to the material's lobe ([`rgl`]) |
//! | `.bin` | UTIA (Filip and Vávra 2014) | anisotropic, every 15° and 7.5° ([`utia`]) |
//! | `.csv` | any program | backscattering, or half and difference angles ([`table`]) |
//! | `.pfm` | any program | a slice at a difference azimuth of 90° ([`mod@slice`]) |
//!
//! [`export`] writes any isotropic [`Brdf`] as `.binary` or `.pfm`.
//!
//! Directions follow the conventions of [`leadr_reflectance`]. Values are `f_r` in linear RGB per steradian, at least 0.

pub mod export;
pub mod fit_file;
pub mod merl;
pub mod rgl;
pub mod slice;
pub mod table;
pub mod utia;

mod bytes;
mod rgl_write;
mod values;

use std::path::Path;

use glam::DVec3;

use leadr_maps::{MapError, MapFault, limits};
use leadr_reflectance::materials::brdf::Brdf;

use self::merl::Merl;
use self::rgl::Rgl;
use self::table::Table;
use self::utia::Utia;

/// A measured material.
#[derive(Clone, Debug)]
pub enum Measured {
    /// A material of the MERL database.
    Merl(Merl),
    /// A material of the RGL database.
    Rgl(Rgl),
    /// A material of the UTIA database.
    Utia(Utia),
    /// A material in a text table.
    Table(Table),
}

/// The supported formats, for error messages.
const EXPECTED: &str = "a MERL .binary, an RGL .bsdf, a UTIA .bin, a .csv of angles and values, or a .pfm slice";

impl Measured {
    /// Reads a measured material from a file. Its content determines the format.
    ///
    /// # Errors
    /// Returns [`MapError`] if the file is missing, damaged, in an unsupported format, or has invalid reflectances.
    pub fn load(file: &Path) -> Result<Self, MapError> {
        Self::load_bytes(file).map_err(|fault| fault.in_file(file))
    }

    fn load_bytes(file: &Path) -> Result<Self, MapFault> {
        let bytes = limits::read_file(file)?;
        if rgl::is_rgl(&bytes) {
            Rgl::read(&bytes).map(Self::Rgl)
        } else if merl::is_merl(&bytes) {
            Merl::read(&bytes).map(Self::Merl)
        } else if bytes.len() == utia::BYTES {
            Utia::read(&bytes).map(Self::Utia)
        } else if slice::is_slice(&bytes) {
            slice::read(&bytes).map(Self::Table)
        } else if let Some(text) = std::str::from_utf8(&bytes).ok().filter(|_| has_extension(file, "csv")) {
            Table::read(text).map(Self::Table)
        } else {
            Err(unrecognised(file, &bytes))
        }
    }

    /// Whether the material is isotropic.
    pub fn is_isotropic(&self) -> bool {
        match self {
            Self::Merl(_) | Self::Table(_) => true,
            Self::Rgl(rgl) => rgl.is_isotropic(),
            Self::Utia(_) => false,
        }
    }

    /// Whether only backscattering was measured.
    pub fn is_backscattering(&self) -> bool {
        matches!(self, Self::Table(table) if table.is_backscattering())
    }

    /// Returns the name of the database and the description in the file.
    pub fn description(&self) -> String {
        match self {
            Self::Merl(_) => "MERL".to_owned(),
            Self::Rgl(rgl) => format!("RGL: {}", rgl.description()),
            Self::Utia(_) => "UTIA".to_owned(),
            Self::Table(_) => "table".to_owned(),
        }
    }
}

fn has_extension(file: &Path, wanted: &str) -> bool {
    file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted))
}

/// Returns the most specific fault that the file's name and length allow.
fn unrecognised(file: &Path, bytes: &[u8]) -> MapFault {
    let what = if has_extension(file, "binary") {
        merl::fault_of_start(bytes)
    } else if has_extension(file, "bin") {
        format!("it has {} bytes; UTIA files have {}", bytes.len(), utia::BYTES)
    } else if has_extension(file, "bsdf") {
        "it does not start with a tensor file header".to_owned()
    } else {
        "it is not a measured material".to_owned()
    };
    MapFault::unsupported(what, format!("give {EXPECTED}"))
}

impl Brdf for Measured {
    fn eval(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return DVec3::ZERO;
        }
        match self {
            Self::Merl(merl) => merl.value(wo, wi),
            Self::Rgl(rgl) => rgl.value(wo, wi),
            Self::Utia(utia) => utia.value(wo, wi),
            Self::Table(table) => table.value(wo, wi),
        }
    }

    fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
        self.eval(wo, wi) * wi.z.max(0.0)
    }
}
