//! `leadr fit`: fits a microfacet model to a measured material.

pub mod args;
mod coat;
mod export;
mod report;

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::json;

use self::args::FitArgs;
use self::export::{Renderer, Simple, identifier};
use self::report::{ExportReport, FitReport, Seconds, SphereReport};
use leadr_maps::limits::read_file;
use leadr_maps::new_file::write_atomic;
use leadr_maps::save::save_png;
use leadr_maps::shown::shown_path;
use leadr_maps::tonemap::Tonemap;
use leadr_measured::Measured;
use leadr_measured::fit_file::FitFile;
use leadr_reflectance::extraction::fit::{Extraction, Fit, FitOptions, Step, fit};
use leadr_reflectance::extraction::roughness::ggx_roughness;
use leadr_reflectance::extraction::samples::samples;
use leadr_reflectance::facets::ellipse::ellipse_from_roughness;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_scenes::file_kind::FileKind;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::{begin, extension, keep_inputs};
use leadr_tools::command::output::Output;
use leadr_tools::fit::lobe_plot::lobe_plot;
use leadr_tools::fit::spheres::{contact_sheet, sphere_error, spheres};
use leadr_tools::html::{Figure, Html, PageSection, Table, address, page};

/// The width of a sphere in pixels, and the number of spheres in the picture.
const SPHERE: u32 = 128;
const SHOWN: usize = 6;
/// The light directions of the plots, in degrees from the normal.
const LIT_FROM: [f64; 3] = [15.0, 45.0, 75.0];

/// Fits a material and writes the requested files.
pub fn run(arguments: &FitArgs, output: &Output) -> Result<(), AppError> {
    let picture = arguments.picture.clone().or_else(|| arguments.page.as_ref().map(|page| page.with_extension("png")));
    let targets = targets(arguments, picture.as_deref())?;
    let start = Instant::now();
    FileKind::check("leadr fit", &arguments.input, &[])?;
    let measured = Measured::load(&arguments.input)?;
    let isotropic = measured.is_isotropic();
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
    let found = timed_fit(&measured, isotropic, &options, output, &mut seconds);
    let found = found.ok_or_else(|| {
        let file = shown_path(&arguments.input);
        AppError::Failed(format!("{file}: the material reflects nothing back towards the light: give another one"))
    })?;
    let mut report =
        FitReport::new(arguments.input.clone(), measured.description(), isotropic, &options, &found, seconds);
    if let Some(picture) = &picture {
        let start = Instant::now();
        report.spheres = draw(&measured, &found, picture, output)?;
        report.seconds.picture = start.elapsed().as_secs_f64();
    }
    if let Some(file) = &arguments.page {
        write_atomic(file, html(&measured, &found, &report, picture.as_deref()).as_bytes())?;
    }
    let stem = arguments.input.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    if arguments.mitsuba.is_some() || arguments.pbrt.is_some() {
        // The diffuse base is exported separately, so this is the roughness of the fitted slopes.
        let roughness = ggx_roughness(&found.fitted.facets.distribution);
        // A table of backscattering does not cover other directions, so the fit replaces it.
        let known: &dyn Brdf = if measured.is_backscattering() { &found.fitted } else { &measured };
        let (samples, ellipse) = (samples(known, isotropic), ellipse_from_roughness(roughness));
        for (file, renderer) in [(&arguments.mitsuba, Renderer::Mitsuba), (&arguments.pbrt, Renderer::Pbrt)] {
            let Some(file) = file else { continue };
            let (simple, wrong) = Simple::nearest(&samples, ellipse, renderer);
            write_atomic(file, simple.text(&identifier(&stem)).as_bytes())?;
            report.exports.push(ExportReport { renderer, misfit: wrong.into() });
        }
    }
    if let Some(file) = &arguments.output {
        let mut kept = FitFile { brdf: found.fitted.clone(), lobes: found.lobes.clone() }.to_json();
        kept["source"] = json!(arguments.input.file_name().map(|name| name.to_string_lossy()));
        kept["database"] = json!(report.database);
        kept["beckmann"] = json!(report.beckmann);
        kept["ggx"] = json!(report.ggx);
        write_atomic(file, format!("{kept:#}\n").as_bytes())?;
    }
    report.files = targets;
    output.result(&report)
}

/// Whether the page of an earlier run shows this picture.
fn is_picture_of(arguments: &FitArgs, picture: &Path) -> bool {
    let page = arguments.page.as_ref().and_then(|page| read_file(page).ok()).unwrap_or_default();
    let shown = format!("<img src=\"{}\"", address(picture.file_name().unwrap_or_default().as_encoded_bytes()));
    page.windows(shown.len()).any(|part| part == shown.as_bytes())
}

/// Returns the files to write, with checked extensions and writable folders.
fn targets(arguments: &FitArgs, picture: Option<&Path>) -> Result<Vec<PathBuf>, AppError> {
    let is_foreign =
        |picture: &&Path| arguments.picture.is_none() && picture.exists() && !is_picture_of(arguments, picture);
    if let Some(picture) = picture.filter(is_foreign) {
        let shown = shown_path(picture);
        return Err(AppError::Usage(format!(
            "the picture of --page would replace '{shown}': remove it, or name the picture with --picture '{shown}'"
        )));
    }
    let folder = |file: &Path| file.parent().map(Path::to_path_buf);
    if let (Some(page), Some(picture)) = (&arguments.page, picture)
        && folder(page) != folder(picture)
    {
        return Err(AppError::Usage("--page links to its picture: name a --picture in the folder of the page".into()));
    }
    let mut all = Vec::new();
    for (file, ending) in [
        (arguments.output.as_deref(), "json"),
        (picture, "png"),
        (arguments.page.as_deref(), "html"),
        (arguments.mitsuba.as_deref(), "xml"),
        (arguments.pbrt.as_deref(), "pbrt"),
    ] {
        let Some(file) = file else { continue };
        if extension(file).as_deref() != Some(ending) {
            return Err(AppError::Usage(format!("'{}' must end in .{ending}", shown_path(file))));
        }
        keep_inputs([file], [arguments.input.as_path()])?;
        drop(begin(file)?);
        all.push(file.to_owned());
    }
    Ok(all)
}

fn timed_fit(
    measured: &Measured,
    isotropic: bool,
    options: &FitOptions,
    output: &Output,
    seconds: &mut Seconds,
) -> Option<Fit> {
    let bar = output.bar(4, "fitting");
    let mut begun = Vec::new();
    let found = fit(measured, isotropic, options, &mut |step| {
        begun.push((step, Instant::now()));
        bar.message(match step {
            Step::Slopes => "fitting slopes",
            Step::Fresnel => "fitting the Fresnel term",
            Step::Refinement => "refining the fit over all directions",
            Step::Lobes => "fitting lobes",
        });
        bar.step();
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

fn draw(measured: &Measured, found: &Fit, file: &Path, output: &Output) -> Result<Vec<SphereReport>, AppError> {
    output.say("drawing spheres");
    let (ggx, beckmann) = (found.as_ggx(), found.as_beckmann());
    let curves: Vec<_> = found.curves.iter().flatten().filter_map(|curve| found.with_curve(curve)).collect();
    let mut materials: Vec<&(dyn Brdf + Sync)> =
        vec![measured, &found.fitted, &found.slice, &found.thesis, &ggx, &beckmann];
    materials.extend(curves.iter().map(|curve| curve as &(dyn Brdf + Sync)));
    let images = spheres(&materials, &ggx, SPHERE);
    save_png(file, &contact_sheet(&images[..SHOWN]), 1.0, Tonemap::Clamp)?;
    let names = ["fitted", "slice", "thesis", "GGX", "Beckmann", "shifted gamma", "ABC"];
    let errors = images[1..].iter().map(|image| sphere_error(&images[0], image));
    Ok(names.into_iter().zip(errors).map(|(material, error)| SphereReport { material, error }).collect())
}

fn html(measured: &Measured, found: &Fit, report: &FitReport, picture: Option<&Path>) -> String {
    let mut body = Html::new();
    if let Some(picture) = picture {
        body.figures(&[Figure {
            file: picture.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
            alt: "Spheres of the material and its fits".to_owned(),
            caption: vec!["Measured, fitted, slice, thesis, GGX, Beckmann".to_owned()],
            width: SHOWN as u32 * (SPHERE + 8) + 8,
            height: SPHERE + 16,
            scale: 1,
        }]);
    }
    let mut table = Table::new("Errors of the spheres against the measured one", ["material", "relative RMSE", "ΔE₀₀"]);
    for sphere in &report.spheres {
        table.row([sphere.material.into(), sphere.error.rrmse.into(), sphere.error.delta_e.into()]);
    }
    body.table(&table);
    let (ggx, beckmann) = (found.as_ggx(), found.as_beckmann());
    let materials: [(&str, &dyn Brdf); 6] = [
        ("measured", measured),
        ("fitted", &found.fitted),
        ("slice", &found.slice),
        ("thesis", &found.thesis),
        ("GGX", &ggx),
        ("Beckmann", &beckmann),
    ];
    body.plot(&lobe_plot(&materials, None));
    for degrees in LIT_FROM {
        body.plot(&lobe_plot(&materials, Some(degrees)));
    }
    let rgb = |c: [f64; 3]| format!("{:.4} {:.4} {:.4}", c[0], c[1], c[2]);
    let facts: Vec<(String, String)> = [
        ("material", report.database.clone()),
        ("Beckmann", report.beckmann.to_string()),
        ("GGX", report.ggx.to_string()),
        ("F0", rgb(report.f0)),
        ("diffuse", rgb(report.diffuse)),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec();
    page("Fitted material", &facts, &[PageSection { name: "fit", title: "Fit", html: &body }])
}
