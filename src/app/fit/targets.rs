//! The files that `leadr fit` writes, checked before any work.

use std::path::{Path, PathBuf};

use super::args::FitArgs;
use leadr_maps::limits::read_file;
use leadr_maps::shown::shown_path;
use leadr_measured::export::Export;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::{begin, extension, keep_inputs};
use leadr_tools::html::address;

/// The files to write.
#[derive(Debug, Default)]
pub struct Targets {
    pub picture: Option<PathBuf>,
    pub page: Option<PathBuf>,
    pub delta_e: Option<PathBuf>,
    /// All files, in the order of the report.
    pub all: Vec<PathBuf>,
}

impl Targets {
    /// Checks the files of one material.
    pub fn of_file(arguments: &FitArgs) -> Result<Self, AppError> {
        let mut targets = Self::new(arguments)?;
        targets.add(arguments.output.as_deref(), "json", &[arguments.input.as_path()])?;
        targets.add_pictures(arguments, &[arguments.input.as_path()])?;
        for (file, ending) in [(&arguments.mitsuba, "xml"), (&arguments.pbrt, "pbrt")] {
            targets.add(file.as_deref(), ending, &[arguments.input.as_path()])?;
        }
        if let Some(file) = &arguments.export {
            let Some(ending) = extension(file).filter(|_| Export::of(file).is_some()) else {
                let (shown, names) = (shown_path(file), Export::NAMES);
                return Err(AppError::Usage(format!("'{shown}' has no format of --export: end the name in {names}")));
            };
            targets.add(Some(file), &ending, &[arguments.input.as_path()])?;
        }
        Ok(targets)
    }

    /// Checks the files of a folder of materials. `fits` are the files of the single fits.
    pub fn of_folder(arguments: &FitArgs, inputs: &[&Path], fits: &[PathBuf]) -> Result<Self, AppError> {
        let exports = [(&arguments.mitsuba, "--mitsuba"), (&arguments.pbrt, "--pbrt"), (&arguments.export, "--export")];
        for (given, flag) in exports {
            if given.is_some() {
                return Err(AppError::Usage(format!("{flag} exports one material: give a file instead of a folder")));
            }
        }
        if let Some(csv) = arguments.csv.as_deref().filter(|csv| is_inside(csv, &arguments.input)) {
            return Err(AppError::Usage(format!(
                "the next run would read '{}' as a measurement: name a --csv outside of the folder",
                shown_path(csv)
            )));
        }
        let mut targets = Self::new(arguments)?;
        for fit in fits {
            targets.add(Some(fit), "json", inputs)?;
        }
        targets.add_pictures(arguments, inputs)?;
        Ok(targets)
    }

    /// Whether spheres are drawn.
    pub fn draws(&self) -> bool {
        self.picture.is_some() || self.delta_e.is_some()
    }

    fn new(arguments: &FitArgs) -> Result<Self, AppError> {
        let picture =
            arguments.picture.clone().or_else(|| arguments.page.as_ref().map(|page| page.with_extension("png")));
        let is_foreign =
            |picture: &&PathBuf| arguments.picture.is_none() && picture.exists() && !is_picture_of(arguments, picture);
        if let Some(picture) = picture.as_ref().filter(is_foreign) {
            let shown = shown_path(picture);
            return Err(AppError::Usage(format!(
                "the picture of --page would replace '{shown}': remove it, or name the picture with --picture '{shown}'"
            )));
        }
        let folder = |file: &PathBuf| file.parent().map(Path::to_path_buf);
        for (other, flag) in [(&picture, "--picture"), (&arguments.delta_e, "--delta-e")] {
            if let (Some(page), Some(other)) = (&arguments.page, other)
                && folder(page) != folder(other)
            {
                return Err(AppError::Usage(format!(
                    "--page links to its pictures: name a {flag} in the folder of the page"
                )));
            }
        }
        Ok(Self { picture, page: arguments.page.clone(), delta_e: arguments.delta_e.clone(), all: Vec::new() })
    }

    fn add_pictures(&mut self, arguments: &FitArgs, inputs: &[&Path]) -> Result<(), AppError> {
        for (file, ending) in [
            (self.picture.clone(), "png"),
            (self.delta_e.clone(), "png"),
            (self.page.clone(), "html"),
            (arguments.csv.clone(), "csv"),
        ] {
            self.add(file.as_deref(), ending, inputs)?;
        }
        Ok(())
    }

    fn add(&mut self, file: Option<&Path>, ending: &str, inputs: &[&Path]) -> Result<(), AppError> {
        let Some(file) = file else { return Ok(()) };
        if extension(file).as_deref() != Some(ending) {
            return Err(AppError::Usage(format!("'{}' must end in .{ending}", shown_path(file))));
        }
        if self.all.iter().any(|other| other == file) {
            return Err(AppError::Usage(format!("'{}' is named twice: name two files", shown_path(file))));
        }
        keep_inputs([file], inputs.iter().copied())?;
        drop(begin(file)?);
        self.all.push(file.to_owned());
        Ok(())
    }
}

/// Whether a file lies directly in a folder.
fn is_inside(file: &Path, folder: &Path) -> bool {
    let parent = file.parent().map(|parent| if parent.as_os_str().is_empty() { Path::new(".") } else { parent });
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    parent.and_then(real).is_some_and(|parent| Some(parent) == real(folder))
}

/// Whether the page of an earlier run shows this picture.
fn is_picture_of(arguments: &FitArgs, picture: &Path) -> bool {
    let page = arguments.page.as_ref().and_then(|page| read_file(page).ok()).unwrap_or_default();
    let shown = format!("<img src=\"{}\"", address(picture.file_name().unwrap_or_default().as_encoded_bytes()));
    page.windows(shown.len()).any(|part| part == shown.as_bytes())
}
