//! `leadr compare`: measures the difference between two pictures. Scripts can set thresholds for the difference.

pub mod args;

use std::fmt;
use std::path::{Path, PathBuf};

use serde::Serialize;

use self::args::CompareArgs;
use leadr_maps::save::encode_png_srgb8;
use leadr_maps::shown::{shown, shown_path};
use leadr_maps::tonemap::Tonemap;
use leadr_maps::{MapFault, Picture, load_picture_layer};
use leadr_scenes::file_kind::{FileKind, IMAGE};
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::{begin, extension, keep_inputs};
use leadr_tools::command::output::Output;
use leadr_tools::metrics::compare::{Comparison, compare_over};
use leadr_tools::metrics::{Crop, Mask};

/// The measured difference between two pictures.
#[derive(Debug, Serialize)]
pub struct CompareReport {
    command: &'static str,
    reference: PathBuf,
    test: PathBuf,
    /// Size of the measured rectangle.
    size: [u32; 2],
    /// The rectangle that `--crop` selects: left, top, width, height.
    #[serde(skip_serializing_if = "Option::is_none")]
    crop: Option<Crop>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mask: Option<PathBuf>,
    /// The layer that `--layer` selects.
    #[serde(skip_serializing_if = "Option::is_none")]
    layer: Option<String>,
    /// Whether a picture has transparent pixels. The errors are then the larger ones over black and over white.
    transparent: bool,
    /// Number of measured pixels.
    pixels: usize,
    /// Mean FLIP error, 0 to 1.
    flip: f64,
    /// The relative root mean square error of the linear values. The error is null (infinite) if only the reference is black.
    rrmse: f64,
    /// The largest absolute difference of a linear channel.
    max_abs: f64,
    error_image: Option<PathBuf>,
}

impl fmt::Display for CompareReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "FLIP     {}", digits(self.flip))?;
        writeln!(f, "rRMSE    {}", digits(self.rrmse))?;
        write!(f, "max abs  {}", digits(self.max_abs))?;
        match &self.error_image {
            Some(file) => write!(f, "\n{}", shown_path(file)),
            None => Ok(()),
        }
    }
}

/// Formats a number with six decimals. Numbers below 1e-3 have three significant digits.
fn digits(value: f64) -> String {
    if (f64::MIN_POSITIVE..1e-3).contains(&value) { format!("{value:.2e}") } else { format!("{value:.6}") }
}

/// Whether a picture is an EXR file with radiance. The alternative is a PNG file with display codes.
fn is_exr(path: &Path) -> Result<bool, AppError> {
    match extension(path).as_deref() {
        Some("png") => Ok(false),
        Some("exr") => Ok(true),
        _ => Err(AppError::Usage(format!(
            "'{}' is neither a .png nor an .exr: give a picture in one of these formats",
            shown_path(path)
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
        return Err(AppError::Usage(format!("the error image '{}' must end in .png", shown_path(path))));
    }
    let inputs = [Some(&arguments.reference), Some(&arguments.test), arguments.mask.as_ref()];
    keep_inputs(arguments.error_image.as_deref(), inputs.into_iter().flatten().map(PathBuf::as_path))?;
    let error_image = arguments.error_image.as_deref().map(begin).transpose()?;
    let load = |path: &Path| -> Result<Picture, AppError> {
        FileKind::check("leadr compare", path, IMAGE)?;
        let picture = load_picture_layer(path, arguments.layer.as_deref())?;
        if picture.display_referred == is_radiance {
            let what = "its contents are of another format than its name";
            return Err(MapFault::unsupported(what, "name it after its format").in_file(path).into());
        }
        Ok(picture)
    };
    let (reference, test) = (load(&arguments.reference)?, load(&arguments.test)?);
    test.check_same_frame(&reference).map_err(|fault| fault.in_file(&arguments.test))?;
    let title = |layer: &str| {
        if layer.is_empty() { "the unnamed layer".into() } else { format!("the layer `{}`", shown(layer)) }
    };
    let [of_reference, of_test] = [&reference, &test].map(|picture| title(&picture.frame.layer));
    if of_reference != of_test {
        output.say(&format!("{of_reference} of the reference is compared with {of_test} of the test"));
    }
    let mask = load_mask(arguments)?;
    // FLIP compares a PNG unchanged, and an EXR as `capture` would display it.
    let (exposure, tonemap) =
        if is_radiance { (arguments.exposure.exp2(), Tonemap::default()) } else { (1.0, Tonemap::Clamp) };
    let over = |background: f32| -> Result<Comparison, AppError> {
        let cropped = |picture: &Picture, file: &Path| {
            let picture = picture.over(background);
            let picture = arguments.crop.map_or(Ok(picture.clone()), |crop| crop.picture(&picture));
            let checked = picture.and_then(|picture| picture.check_finite().map(|()| picture));
            checked.map_err(|fault| fault.in_file(file))
        };
        let (a, b) = (cropped(&reference, &arguments.reference)?, cropped(&test, &arguments.test)?);
        let whole = || Mask::all(a.width, a.height);
        let mask = mask.clone().unwrap_or_else(whole);
        let wrong_file = match &arguments.mask {
            Some(file) if (mask.width, mask.height) != (a.width, a.height) => file,
            _ => &arguments.test,
        };
        Ok(compare_over(&a, &b, exposure, tonemap, &mask).map_err(|fault| fault.in_file(wrong_file))?)
    };
    let transparent = reference.is_transparent() || test.is_transparent();
    let mut measured = over(0.0)?;
    if transparent {
        output.say(
            "transparent pixels: the pictures are compared over black and over white, and the larger errors count",
        );
        measured = measured.larger(over(1.0)?);
    }
    if let Some(file) = error_image {
        let png = encode_png_srgb8(&measured.error_image()).map_err(|fault| fault.in_file(file.target()))?;
        file.write(&png)?;
    }
    output.result(&CompareReport {
        command: "compare",
        reference: arguments.reference.clone(),
        test: arguments.test.clone(),
        size: [measured.width, measured.height],
        crop: arguments.crop,
        mask: arguments.mask.clone(),
        layer: arguments.layer.clone(),
        transparent,
        pixels: mask.as_ref().map_or(measured.flip_map.len(), Mask::count),
        flip: measured.flip,
        rrmse: measured.rrmse,
        max_abs: measured.max_abs,
        error_image: arguments.error_image.clone(),
    })?;
    check_threshold("FLIP", measured.flip, arguments.max_flip)?;
    check_threshold("rRMSE", measured.rrmse, arguments.max_rrmse)
}

/// Reads the mask and crops it.
fn load_mask(arguments: &CompareArgs) -> Result<Option<Mask>, AppError> {
    let Some(file) = &arguments.mask else { return Ok(None) };
    FileKind::check("--mask", file, IMAGE)?;
    let mask = Mask::load(file)?;
    let Some(crop) = arguments.crop else { return Ok(Some(mask)) };
    let mask = crop.mask(&mask).map_err(|fault| fault.in_file(file))?;
    if mask.count() == 0 {
        return Err(AppError::Failed(format!(
            "'{}' has no pixel over 0.5 inside --crop: move the crop, or leave --mask out",
            shown_path(file)
        )));
    }
    Ok(Some(mask))
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
