//! `leadr compare`: the difference of two pictures, with thresholds for scripts.

pub mod args;

use std::fmt;
use std::path::{Path, PathBuf};

use serde::Serialize;

use self::args::CompareArgs;
use crate::app::error::AppError;
use crate::app::files::{extension, make_folder_of};
use crate::app::output::Output;
use crate::lab::metrics::compare::{Comparison, compare};
use crate::maps::tonemap::Tonemap;
use crate::maps::{self, RgbImage};

/// The measured difference of two pictures.
#[derive(Debug, Serialize)]
pub struct CompareReport {
    command: &'static str,
    reference: PathBuf,
    test: PathBuf,
    size: [u32; 2],
    /// Mean FLIP error, 0 to 1.
    flip: f64,
    /// Relative root mean square error of the linear values; null if only the reference is black.
    rrmse: f64,
    /// Largest absolute difference of a linear channel.
    max_abs: f64,
    error_image: Option<PathBuf>,
}

impl fmt::Display for CompareReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "FLIP     {:.6}", self.flip)?;
        writeln!(f, "rRMSE    {:.6}", self.rrmse)?;
        write!(f, "max abs  {:.6}", self.max_abs)?;
        match &self.error_image {
            Some(file) => write!(f, "\n{}", file.display()),
            None => Ok(()),
        }
    }
}

/// Whether a picture holds display codes or radiance.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Png,
    Exr,
}

impl Kind {
    fn of(path: &Path) -> Result<Self, AppError> {
        match extension(path).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(AppError::Usage(format!("'{}' is neither a .png nor an .exr picture", path.display()))),
        }
    }

    fn load(self, path: &Path) -> Result<RgbImage, AppError> {
        Ok(match self {
            Self::Png => maps::load_color(path)?,
            Self::Exr => maps::load_environment(path)?,
        })
    }
}

/// Compares two pictures, prints the result, writes the error image, and checks the result against the thresholds.
///
/// # Errors
/// [`AppError::Usage`] if the files are of different kinds; [`AppError::Failed`] if one is damaged, their sizes differ, the
/// error image cannot be written, or a measure is over its threshold.
pub fn run(arguments: &CompareArgs, output: &Output) -> Result<(), AppError> {
    let kind = Kind::of(&arguments.reference)?;
    if Kind::of(&arguments.test)? != kind {
        return Err(AppError::Usage(
            "the pictures are of different kinds: a PNG holds display codes, an EXR radiance".into(),
        ));
    }
    if let Some(path) = &arguments.error_image
        && extension(path).as_deref() != Some("png")
    {
        return Err(AppError::Usage(format!("the error image '{}' must end in .png", path.display())));
    }
    let (reference, test) = (kind.load(&arguments.reference)?, kind.load(&arguments.test)?);
    // FLIP sees a PNG as it is, and an EXR as `capture` would have displayed it.
    let (exposure, tonemap) = match kind {
        Kind::Png => (1.0, Tonemap::Clamp),
        Kind::Exr => (arguments.exposure.exp2(), Tonemap::default()),
    };
    let measured = compare(&reference, &test, exposure, tonemap).map_err(|f| f.in_file(&arguments.test))?;
    if let Some(path) = &arguments.error_image {
        make_folder_of(path)?;
        maps::save::save_png_srgb8(path, &measured.error_image())?;
    }
    output.result(&report(arguments, &measured))?;
    check_threshold("FLIP", measured.flip, arguments.max_flip)?;
    check_threshold("rRMSE", measured.rrmse, arguments.max_rrmse)
}

fn report(arguments: &CompareArgs, measured: &Comparison) -> CompareReport {
    CompareReport {
        command: "compare",
        reference: arguments.reference.clone(),
        test: arguments.test.clone(),
        size: [measured.width, measured.height],
        flip: measured.flip,
        rrmse: measured.rrmse,
        max_abs: measured.max_abs,
        error_image: arguments.error_image.clone(),
    }
}

fn check_threshold(name: &str, value: f64, threshold: Option<f32>) -> Result<(), AppError> {
    match threshold.map(f64::from) {
        // NaN is above every threshold.
        Some(most) if value.is_nan() || value > most => {
            Err(AppError::Failed(format!("{name} is {value:.6}, over {most}")))
        }
        _ => Ok(()),
    }
}
