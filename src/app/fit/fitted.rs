//! The fit of one measured file, with its report and its spheres.

use std::path::Path;
use std::time::Instant;

use serde_json::json;

use super::args::FitArgs;
use super::report::{FitReport, LobeErrorReport, Seconds, SphereReport, published_reports};
use leadr_maps::RgbImage;
use leadr_maps::shown::shown_path;
use leadr_measured::Measured;
use leadr_measured::fit_file::FitFile;
use leadr_reflectance::extraction::fit::{Extraction, Fit, FitOptions, Step, fit};
use leadr_reflectance::extraction::lobes::lobe_errors;
use leadr_reflectance::extraction::samples::{Sample, samples};
use leadr_reflectance::facets::gaussian_mixture::MOST_LOBES;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_tools::command::error::AppError;
use leadr_tools::fit::models::Models;
use leadr_tools::fit::spheres::{sphere_error, spheres};

/// The width of a sphere in pixels.
pub const SPHERE: u32 = 128;

/// A measured material and its fit.
pub struct Fitted {
    pub measured: Measured,
    pub fit: Fit,
    pub report: FitReport,
    json: serde_json::Value,
}

/// The spheres of a material and of its models.
pub struct Drawn {
    pub models: Models,
    /// The sphere of the measured material, followed by the spheres of [`Models::named`].
    pub spheres: Vec<RgbImage>,
}

impl Fitted {
    /// Reads and fits a file. `watch` is called at the start of each step.
    pub fn new(input: &Path, arguments: &FitArgs, watch: &mut dyn FnMut(Step)) -> Result<Self, AppError> {
        let start = Instant::now();
        let measured = Measured::load(input)?;
        let mut seconds = Seconds { reading: start.elapsed().as_secs_f64(), ..Seconds::default() };
        let options = FitOptions {
            hiding: arguments.masking,
            angles: arguments.angles as usize,
            azimuths: arguments.azimuths as usize,
            lobes: arguments.lobes as usize,
            // A table of backscattering has no directions to refine over.
            extraction: match arguments.extraction() {
                Extraction::Refined if measured.is_backscattering() => Extraction::Slice,
                extraction => extraction,
            },
        };
        let fit = timed_fit(&measured, &options, watch, &mut seconds).ok_or_else(|| {
            let file = shown_path(input);
            AppError::Failed(format!("{file}: the material reflects nothing back towards the light: give another one"))
        })?;
        let json = FitFile { brdf: fit.fitted.clone(), lobes: fit.lobes.clone() }.to_json();
        let report = FitReport::new(input.to_owned(), &measured, &options, &fit, seconds);
        let mut all = Self { measured, fit, report, json };
        let name = input.file_name().map(|name| name.to_string_lossy());
        for (field, value) in [
            ("source", json!(name)),
            ("database", json!(all.report.database)),
            ("extraction", json!(all.report.extraction)),
            ("beckmann", json!(all.report.beckmann)),
            ("ggx", json!(all.report.ggx)),
        ] {
            all.json[field] = value;
        }
        all.report.bytes.file = all.text().len() as u64;
        if arguments.lobe_errors {
            let samples = all.samples();
            let of = |count| LobeErrorReport::new(count, &lobe_errors(&all.fit.fitted, &samples, count));
            all.report.lobe_errors = (1..=MOST_LOBES).map(of).collect();
        }
        Ok(all)
    }

    /// Returns the content of the material's file.
    pub fn text(&self) -> String {
        format!("{:#}\n", self.json)
    }

    /// Returns samples of the measured material. A table of backscattering does not cover other directions, so its fit replaces it.
    pub fn samples(&self) -> Vec<Sample> {
        let known: &dyn Brdf = if self.measured.is_backscattering() { &self.fit.fitted } else { &self.measured };
        samples(known, self.measured.is_isotropic())
    }

    /// Draws the spheres, and adds their errors to the report.
    pub fn draw(&mut self) -> Drawn {
        let start = Instant::now();
        let models = Models::new(&self.fit, &self.samples());
        let named = models.named();
        let mut materials: Vec<&(dyn Brdf + Sync)> = vec![&self.measured];
        materials.extend(named.iter().map(|(_, model)| *model));
        let spheres = spheres(&materials, &models.ggx, SPHERE);
        let errors = spheres[1..].iter().map(|image| sphere_error(&spheres[0], image));
        self.report.spheres =
            named.iter().zip(errors).map(|(&(material, _), error)| SphereReport { material, error }).collect();
        self.report.published = published_reports(&models, &self.samples());
        self.report.seconds.picture = start.elapsed().as_secs_f64();
        Drawn { models, spheres }
    }
}

fn timed_fit(
    measured: &Measured,
    options: &FitOptions,
    watch: &mut dyn FnMut(Step),
    seconds: &mut Seconds,
) -> Option<Fit> {
    let mut begun = Vec::new();
    let found = fit(measured, measured.is_isotropic(), options, &mut |step| {
        begun.push((step, Instant::now()));
        watch(step);
    });
    let ends = begun.iter().skip(1).map(|(_, next)| *next).chain([Instant::now()]);
    for ((step, start), end) in begun.iter().zip(ends) {
        let part = match step {
            Step::Slopes => &mut seconds.slopes,
            Step::Fresnel => &mut seconds.fresnel,
            Step::Refinement => &mut seconds.refinement,
            Step::Lobes => &mut seconds.lobes,
        };
        *part += (end - *start).as_secs_f64();
    }
    found
}
