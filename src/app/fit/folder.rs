//! `leadr fit FOLDER`: fits every measured material of a folder.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::args::FitArgs;
use super::fitted::{Fitted, SPHERE};
use super::page::of_folder;
use super::report::{FitReport, csv};
use super::targets::Targets;
use leadr_maps::folders::matching;
use leadr_maps::new_file::write_atomic;
use leadr_maps::save::{save_png, save_png_srgb8};
use leadr_maps::shown::shown_path;
use leadr_maps::tonemap::Tonemap;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::extension;
use leadr_tools::command::output::Output;
use leadr_tools::fit::mean_difference::MeanDifference;
use leadr_tools::fit::models::NAMES;
use leadr_tools::fit::spheres::{contact_sheet, stacked};

/// The extensions of measured materials.
const ENDINGS: [&str; 5] = ["binary", "bsdf", "bin", "csv", "pfm"];

/// The fits of a folder.
#[derive(Debug, Serialize)]
pub struct FolderReport {
    command: &'static str,
    input: PathBuf,
    /// The fits, in the order of their file names.
    pub materials: Vec<FitReport>,
    /// The files that have no fit.
    pub failed: Vec<FailedFile>,
    /// The mean errors of the spheres. The list is empty if no spheres were drawn.
    pub means: Vec<MeanReport>,
    files: Vec<PathBuf>,
}

/// A file without a fit.
#[derive(Debug, Serialize)]
pub struct FailedFile {
    pub file: PathBuf,
    pub fault: String,
}

/// The mean errors of a model over its materials.
#[derive(Debug, Serialize)]
pub struct MeanReport {
    pub model: &'static str,
    materials: usize,
    pub rrmse: f64,
    #[serde(rename = "delta_e_2000")]
    pub delta_e: f64,
}

pub fn run(arguments: &FitArgs, output: &Output) -> Result<(), AppError> {
    let inputs = measured_files(&arguments.input)?;
    let fits = fit_files(arguments, &inputs)?;
    let paths: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
    let targets = Targets::of_folder(arguments, &paths, &fits)?;
    let mut report = FolderReport {
        command: "fit",
        input: arguments.input.clone(),
        materials: Vec::new(),
        failed: Vec::new(),
        means: Vec::new(),
        files: Vec::new(),
    };
    let (mut rows, mut mean) = (Vec::new(), MeanDifference::new(SPHERE));
    let bar = output.bar(inputs.len(), "fitting materials");
    for (i, input) in inputs.iter().enumerate() {
        bar.message(&format!("fitting {}", shown_path(input)));
        match Fitted::new(input, arguments, &mut |_| ()) {
            Ok(mut fitted) => {
                if targets.draws() {
                    let drawn = fitted.draw();
                    for ((name, _), sphere) in drawn.models.named().iter().zip(&drawn.spheres[1..]) {
                        mean.add(name, &drawn.spheres[0], sphere);
                    }
                    rows.push(contact_sheet(&drawn.spheres));
                }
                if let Some(file) = fits.get(i) {
                    write_atomic(file, fitted.text().as_bytes())?;
                    fitted.report.files.push(file.clone());
                    report.files.push(file.clone());
                }
                report.materials.push(fitted.report);
            }
            Err(fault) => {
                bar.suspended(|| tracing::warn!("{fault}"));
                report.failed.push(FailedFile { file: input.clone(), fault: fault.to_string() });
            }
        }
        bar.step();
    }
    drop(bar);
    report.means = means(&report.materials);
    if !report.materials.is_empty() {
        if let Some(picture) = &targets.picture {
            save_png(picture, &stacked(&rows), 1.0, Tonemap::Clamp)?;
        }
        if let Some(file) = &targets.delta_e {
            save_png_srgb8(file, &mean.image())?;
        }
        if let (Some(file), Some(picture)) = (&targets.page, &targets.picture) {
            write_atomic(file, of_folder(&report, picture, targets.delta_e.as_deref()).as_bytes())?;
        }
        if let Some(file) = &arguments.csv {
            write_atomic(file, csv(&report.materials, &report.failed).as_bytes())?;
        }
        report.files.extend(targets.all.into_iter().filter(|file| !fits.contains(file)));
        output.result(&report)?;
    }
    match report.failed.len() {
        0 => Ok(()),
        failed => Err(AppError::Failed(format!(
            "{failed} of {} files could not be fitted: see the lines above",
            inputs.len()
        ))),
    }
}

/// Returns the measured materials of a folder, sorted by name.
fn measured_files(folder: &Path) -> Result<Vec<PathBuf>, AppError> {
    let is_measured = |path: &Path| extension(path).is_some_and(|ending| ENDINGS.contains(&ending.as_str()));
    let files = matching(folder, is_measured).map_err(|fault| fault.in_file(folder))?;
    if files.is_empty() {
        return Err(AppError::Failed(format!(
            "{}: no file ends in .binary, .bsdf, .bin, .csv or .pfm: give a folder of measured materials",
            shown_path(folder)
        )));
    }
    Ok(files)
}

/// Returns the file of each fit in the folder `--output`, or nothing without `--output`. Inputs of one stem keep their extensions.
fn fit_files(arguments: &FitArgs, inputs: &[PathBuf]) -> Result<Vec<PathBuf>, AppError> {
    let Some(folder) = &arguments.output else { return Ok(Vec::new()) };
    if extension(folder).as_deref() == Some("json") {
        return Err(AppError::Usage(format!(
            "'{}' is one file: name a folder for the fits of a folder",
            shown_path(folder)
        )));
    }
    let mut stems = BTreeMap::new();
    for input in inputs {
        *stems.entry(input.file_stem()).or_insert(0) += 1;
    }
    let name = |input: &PathBuf| {
        let unique = stems.get(&input.file_stem()) == Some(&1);
        let name = if unique { input.file_stem() } else { input.file_name() }.unwrap_or_default();
        let mut name = name.to_owned();
        name.push(".json");
        folder.join(name)
    };
    Ok(inputs.iter().map(name).collect())
}

/// Returns the mean errors of the spheres for each model that has some.
fn means(materials: &[FitReport]) -> Vec<MeanReport> {
    let mean = |model: &'static str| {
        let spheres = materials.iter().flat_map(|material| &material.spheres).filter(|sphere| sphere.material == model);
        let errors: Vec<_> = spheres.map(|sphere| sphere.error).collect();
        let count = errors.len() as f64;
        (!errors.is_empty()).then(|| MeanReport {
            model,
            materials: errors.len(),
            rrmse: errors.iter().map(|error| error.rrmse).sum::<f64>() / count,
            delta_e: errors.iter().map(|error| error.delta_e).sum::<f64>() / count,
        })
    };
    NAMES.into_iter().filter_map(mean).collect()
}

impl fmt::Display for FolderReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = self.materials.len() + self.failed.len();
        write!(f, "{}: {} of {all} files fitted", shown_path(&self.input), self.materials.len())?;
        for material in &self.materials {
            write!(f, "\n  {}", material.line())?;
        }
        for MeanReport { model, materials, rrmse, delta_e } in &self.means {
            write!(f, "\n  mean sphere of {materials}, {model}: relative RMSE {rrmse:.4}, ΔE₀₀ {delta_e:.2}")?;
        }
        for file in &self.files {
            write!(f, "\n  {}", shown_path(file))?;
        }
        Ok(())
    }
}
