//! `leadr compare`: measures the difference between two pictures, with thresholds for scripts.

pub mod args;

use std::fmt;
use std::path::{Path, PathBuf};

use serde::Serialize;

use self::args::CompareArgs;
use leadr_maps::save::encode_png_srgb8;
use leadr_maps::tonemap::Tonemap;
use leadr_maps::{load_color, load_environment};
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::{begin, extension};
use leadr_tools::command::output::Output;
use leadr_tools::metrics::compare::compare;

/// The measured difference between two pictures.
#[derive(Debug, Serialize)]
pub struct CompareReport {
    command: &'static str,
    reference: PathBuf,
    test: PathBuf,
    size: [u32; 2],
    /// Mean FLIP error, 0 to 1.
    flip: f64,
    /// Relative root mean square error of the linear values; null (infinite) if only the reference is black.
    rrmse: f64,
    /// Maximum absolute difference of a linear channel.
    max_abs: f64,
    error_image: Option<PathBuf>,
}

impl fmt::Display for CompareReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "FLIP     {}", digits(self.flip))?;
        writeln!(f, "rRMSE    {}", digits(self.rrmse))?;
        write!(f, "max abs  {}", digits(self.max_abs))?;
        match &self.error_image {
            Some(file) => write!(f, "\n{}", file.display()),
            None => Ok(()),
        }
    }
}

/// Formats a number with six decimals, or with three significant digits below 1e-3.
fn digits(value: f64) -> String {
    if (f64::MIN_POSITIVE..1e-3).contains(&value) { format!("{value:.2e}") } else { format!("{value:.6}") }
}

/// Whether a picture is an EXR with radiance, not a PNG with display codes.
fn is_exr(path: &Path) -> Result<bool, AppError> {
    match extension(path).as_deref() {
        Some("png") => Ok(false),
        Some("exr") => Ok(true),
        _ => Err(AppError::Usage(format!(
            "'{}' is neither a .png nor an .exr: give a picture in one of these formats",
            path.display()
        ))),
    }
}

/// Compares two pictures, prints the result, writes the error image, and checks the result against the thresholds.
pub fn run(arguments: &CompareArgs, output: &Output) -> Result<(), AppError> {
    let is_radiance = is_exr(&arguments.reference)?;
    if is_exr(&arguments.test)? != is_radiance {
        return Err(AppError::Usage(
            "a PNG holds display codes and an EXR holds radiance: give two files of the same format".into(),
        ));
    }
    if let Some(path) = &arguments.error_image
        && extension(path).as_deref() != Some("png")
    {
        return Err(AppError::Usage(format!("the error image '{}' must end in .png", path.display())));
    }
    let error_image = arguments.error_image.as_deref().map(begin).transpose()?;
    let load = |path: &Path| if is_radiance { load_environment(path) } else { load_color(path) };
    let (reference, test) = (load(&arguments.reference)?, load(&arguments.test)?);
    // FLIP compares a PNG unchanged, and an EXR as `capture` would display it.
    let (exposure, tonemap) =
        if is_radiance { (arguments.exposure.exp2(), Tonemap::default()) } else { (1.0, Tonemap::Clamp) };
    let measured = compare(&reference, &test, exposure, tonemap).map_err(|f| f.in_file(&arguments.test))?;
    if let Some(file) = error_image {
        let png = encode_png_srgb8(&measured.error_image()).map_err(|fault| fault.in_file(file.target()))?;
        file.write(&png)?;
    }
    output.result(&CompareReport {
        command: "compare",
        reference: arguments.reference.clone(),
        test: arguments.test.clone(),
        size: [measured.width, measured.height],
        flip: measured.flip,
        rrmse: measured.rrmse,
        max_abs: measured.max_abs,
        error_image: arguments.error_image.clone(),
    })?;
    check_threshold("FLIP", measured.flip, arguments.max_flip)?;
    check_threshold("rRMSE", measured.rrmse, arguments.max_rrmse)
}

fn check_threshold(name: &str, value: f64, threshold: Option<f64>) -> Result<(), AppError> {
    match threshold {
        // NaN is above every threshold.
        Some(most) if value.is_nan() || value > most => {
            Err(AppError::Failed(format!("{name} is {}, over {most}", digits(value))))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_printed_as_written() {
        let small = "0.00001".parse().ok();
        assert!(check_threshold("FLIP", 0.00001, small).is_ok() && check_threshold("FLIP", 0.0, small).is_ok());
        let message = check_threshold("FLIP", 0.0000123, small).unwrap_err().to_string();
        assert_eq!(message, "FLIP is 1.23e-5, over 0.00001");
        assert!(check_threshold("FLIP", f64::NAN, small).is_err());
        assert_eq!([0.0, 0.25, 1.5].map(digits), ["0.000000", "0.250000", "1.500000"]);
    }
}
