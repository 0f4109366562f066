//! Fits measured materials to facets by power iteration, and renders displaced spheres with these materials at several
//! distances.

mod on_geometry;
mod several;

use std::path::{Path, PathBuf};

use glam::DVec2;
use serde::Serialize;

use self::on_geometry::{OnGeometry, on_geometry};
use self::several::{SeveralRow, several};
use crate::extraction_study::{Extraction, anisotropic, printed, round};
use crate::report::configuration::Configuration;
use crate::report::section::Section;
use crate::report::shared::shared;
use crate::report::studio::{Studio, fault};
use crate::report::subject::{Subject, framed_from};
use crate::report::truth::Truth;
use crate::report::verdict::{SILHOUETTE, Shot, judge, without_relief_noise};
use leadr_maps::material::{Encoding, Input, Material, Raster, Samples, Texture};
use leadr_maps::shown::shown_path;
use leadr_maps::{HeightMap, MapFault, RgbImage, procedural};
use leadr_measured::Measured;
use leadr_reflectance::extraction::fit::{Extraction as Method, Fit, FitOptions, fit};
use leadr_reflectance::extraction::lobes::{LobeErrors, lobe_errors};
use leadr_reflectance::extraction::samples::samples;
use leadr_reflectance::facets::gaussian_mixture::MOST_LOBES;
use leadr_reflectance::facets::tabulated::Tabulated;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_render::settings::{RenderSettings, Technique, Terms};
use leadr_scenes::dressed::sphere_stage;
use leadr_scenes::stage::SPHERE_REPEAT;
use leadr_tools::error::LabError;
use leadr_tools::fit::mean_difference::{MOST_DELTA_E, MeanDifference};
use leadr_tools::fit::models::{Models, NAMES};
use leadr_tools::fit::specimen::{Lacquer, Satin, as_thesis, dressed};
use leadr_tools::fit::spheres::{contact_sheet, sphere_error, spheres};
use leadr_tools::html::{Cell, Html, Plot, Scale, Table, number};
use leadr_tools::metrics::Mask;
use leadr_tools::metrics::compare::{bias_over, rrmse_over};

const INTRO: &str = "Facets of known slopes recovered by power iteration (the thesis' Table 4.I and Figure 4.5); spheres of measured \
    materials and their fits (Figures 4.2 to 4.4); the fits with 1 to 8 Gaussian lobes (section 5.3); and the isotropic materials on \
    displaced spheres (Figures 5.4 and 5.5). On the displaced spheres, one sample of LEADR with the fit's lobes is compared inside the \
    outline with the supersampled reference, which uses the table of the fit. Also compared: the thesis' fit, with its Fresnel table and \
    one Beckmann lobe, the lobes about mipmapped normals, and Blinn-Phong. These pictures and the truth have no shadows between bumps. \
    One far truth has all shadows and is also compared with the program's defaults. Narrow lobes reveal the random facets of a pixel, so \
    each far sphere averages several similar reliefs. The goal's error excludes the remaining randomness. Last, one fit's slopes are \
    scaled by a roughness texture, and a model has one fit per material, with and without its roughness textures (Figure 4.6). The \
    CPU draws this model with the measured BRDFs themselves and with their fits, which are compared with each other and with the \
    renderer's pictures. The lacquer and the anisotropic satin are generated; measured files are drawn if the folder data/brdf of \
    LEADR_SHARED contains them.";

/// The roughnesses of Table 4.I, each with its largest error in the thesis.
const TABLE_4_I: [(f64, f64); 4] = [(0.01, 0.03), (0.02, 0.004), (0.05, 0.002), (0.15, 0.0005)];
/// The roughnesses of the anisotropic slopes in the timings.
const ANISOTROPIC: DVec2 = DVec2::new(0.1, 0.3);
/// The largest acceptable error at a distance.
const GOAL: f64 = 0.03;
/// The metres per unit of height, for bumps with slope deviation .25 and for grooves of 4 mm.
const DEPTHS: [(&str, f32); 2] = [("rugged", 0.25 * SPHERE_REPEAT), ("scratched", 0.004)];
/// The width of the bumps, as a fraction of a repeat.
const FEATURE: f32 = 0.006;
#[derive(Clone, Copy)]
struct Viewpoint {
    name: &'static str,
    /// The number of truth pixels per picture pixel along an axis, which is also the distance relative to the middle view.
    /// The near view has 1.
    block: u32,
    /// Whether bumps shadow each other in the truth. By default, the compared pictures have the same shadows.
    shadowed: bool,
    /// The number of samples per truth pixel, over all reliefs.
    samples: u32,
    /// The number of reliefs that are averaged.
    reliefs: u32,
}

/// The views of the spheres. Far pictures are 14 pixels wide, so a pixel of the sphere covers about 3,600 texels of relief.
const VIEWPOINTS: [Viewpoint; 3] = [
    Viewpoint { name: "near", block: 1, shadowed: false, samples: 64, reliefs: 1 },
    Viewpoint { name: "far", block: 14, shadowed: false, samples: 64, reliefs: 8 },
    Viewpoint { name: "far, shadowed", block: 14, shadowed: true, samples: 32, reliefs: 8 },
];

struct Specimen {
    name: String,
    material: Box<dyn Brdf + Sync>,
    fit: Fit,
}

impl Specimen {
    fn is_isotropic(&self) -> bool {
        matches!(self.fit.slice.facets.distribution, Tabulated::Radial(_))
    }
}

#[derive(Serialize)]
struct SphereRow {
    material: String,
    isotropic: bool,
    form: &'static str,
    rrmse: f64,
    delta_e: f64,
}

#[derive(Serialize)]
struct LobeRow {
    material: String,
    lobes: usize,
    /// The divergence of the lobes from the slopes of the table.
    slopes: f64,
    rrmse: f64,
    cube_root: f64,
}

#[derive(Serialize)]
struct DisplacedRow {
    material: String,
    relief: &'static str,
    place: &'static str,
    form: &'static str,
    /// The error of the mean over all reliefs.
    rrmse: f64,
    bias: f64,
    noise: f64,
    /// The mean error of single reliefs.
    rrmse_of_one: f64,
    /// The error of the filter ([`without_relief_noise`]).
    rrmse_of_filter: f64,
}

#[derive(Serialize)]
struct Data {
    table: Vec<(f64, f64)>,
    round: Vec<Extraction>,
    brushed: Vec<Extraction>,
    spheres: Vec<SphereRow>,
    lobes: Vec<LobeRow>,
    displaced: Vec<DisplacedRow>,
    several: Vec<SeveralRow>,
    on_geometry: OnGeometry,
}

/// Returns the materials, the isotropic ones first.
fn specimens() -> Result<Vec<Specimen>, LabError> {
    let fitted = |name: &str, material: Box<dyn Brdf + Sync>, isotropic: bool| {
        let fit = fit(&*material, isotropic, &FitOptions::default(), &mut |_| ())
            .ok_or_else(|| LabError(format!("{name} has no backscattering")))?;
        Ok::<_, LabError>(Specimen { name: name.to_owned(), material, fit })
    };
    let mut all = vec![fitted("lacquer", Box::<Lacquer>::default(), true)?];
    let files = shared("brdf").map_or_else(|| Ok(Vec::new()), |folder| measured_files(&folder))?;
    for file in files {
        let measured = Measured::load(&file)?;
        // A sphere needs all directions.
        if measured.is_backscattering() {
            continue;
        }
        let stem = file.file_stem().map(|stem| stem.to_string_lossy().replace('_', "-")).unwrap_or_default();
        let isotropic = measured.is_isotropic();
        all.push(fitted(&stem, Box::new(measured), isotropic)?);
    }
    all.push(fitted("satin", Box::<Satin>::default(), false)?);
    all.sort_by_key(|specimen| !specimen.is_isotropic());
    Ok(all)
}

/// The endings of the files that [`Measured`] reads.
const ENDINGS: [&str; 5] = ["binary", "bsdf", "bin", "csv", "pfm"];

/// Returns the measured materials of a folder and of the folders inside it.
fn measured_files(folder: &Path) -> Result<Vec<PathBuf>, LabError> {
    let entries = std::fs::read_dir(folder).map_err(|e| LabError(format!("{}: {e}", shown_path(folder))))?;
    let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() {
            files.extend(measured_files(&path)?);
        } else if path.extension().is_some_and(|ending| ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known)))
        {
            files.push(path);
        }
    }
    Ok(files)
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let (mut html, mut findings) = (Html::new(), Vec::new());
    let table = known(studio, &mut html, &mut findings)?;
    let (round, brushed) = timings(studio, &mut html, &mut findings);
    let all = specimens()?;
    let isotropic = &all[..all.iter().take_while(|specimen| specimen.is_isotropic()).count()];
    let spheres = compared(studio, &all, &mut html, &mut findings)?;
    let lobes = lobes(&all, &mut html, &mut findings);
    let displaced = displaced(studio, isotropic, &mut html, &mut findings)?;
    roughened(studio, &isotropic[0], &mut html, &mut findings)?;
    let several = several(studio, isotropic, &mut html, &mut findings)?;
    let on_geometry = on_geometry(studio, isotropic, &mut html, &mut findings)?;
    Section::new(
        INTRO,
        findings,
        &html,
        &Data { table, round, brushed, spheres, lobes, displaced, several, on_geometry },
    )
}

/// Writes Table 4.I.
fn known(studio: &Studio, html: &mut Html, findings: &mut Vec<String>) -> Result<Vec<(f64, f64)>, LabError> {
    let angles = studio.pick(90, 360);
    let mut table = Table::new(
        format!("Beckmann slopes recovered from {angles} angles: largest relative error of the backscattering"),
        ["α", "here", "as printed (Listing 4.1)", "thesis, 360 angles"],
    );
    let mut errors = Vec::new();
    for (alpha, thesis) in TABLE_4_I {
        let found = round(alpha, angles).ok_or_else(|| LabError("power iteration found no slopes".to_owned()))?;
        table.row([alpha, found.error, printed(alpha, angles), thesis].map(Cell::from));
        errors.push((alpha, found.error));
    }
    html.table(&table);
    let worst = errors.iter().map(|(_, error)| *error).fold(0.0, f64::max);
    findings.push(format!("Known slopes are recovered to {}; the thesis has up to 0.03.", number(worst)));
    Ok(errors)
}

/// Plots Figure 4.5.
fn timings(studio: &Studio, html: &mut Html, findings: &mut Vec<String>) -> (Vec<Extraction>, Vec<Extraction>) {
    let counts: &[usize] = studio.pick(&[16, 90], &[16, 24, 32, 48, 64, 90, 128, 180, 256, 360]);
    let of_round: Vec<Extraction> = counts.iter().filter_map(|&n| round(0.05, n)).collect();
    let counts: &[usize] = studio.pick(&[16, 90], &[16, 24, 32, 48, 64, 90]);
    let of_anisotropic: Vec<Extraction> = counts.iter().filter_map(|&n| anisotropic(ANISOTROPIC, n, n)).collect();
    let angles = ("angles at which the material is evaluated", Scale::Log);
    let mut time = Plot::new("Time of the extraction with the Fresnel term", angles, ("milliseconds", Scale::Log));
    let mut error =
        Plot::new("Accuracy of the extraction", angles, ("largest relative error of the backscattering", Scale::Log));
    for (name, rows) in [("round, α .05", &of_round), ("anisotropic, α .1 and .3, as many azimuths", &of_anisotropic)]
    {
        let points = |of: fn(&Extraction) -> f64| rows.iter().map(|row| (row.angles as f64, of(row))).collect();
        time.line(name, points(|row| 1e3 * row.seconds));
        error.line(name, points(|row| row.error.max(1e-9)));
    }
    html.plot(&time);
    html.plot(&error);
    let seconds = |rows: &[Extraction]| {
        rows.iter().find(|row| row.angles == 90).map_or_else(|| "–".to_owned(), |row| number(row.seconds))
    };
    findings.push(format!(
        "Extraction with the Fresnel term, 90 angles: {} s (thesis < 1 s); 90x90: {} s (< 20 s).",
        seconds(&of_round),
        seconds(&of_anisotropic)
    ));
    (of_round, of_anisotropic)
}

/// Renders Figures 4.2 to 4.4.
fn compared(
    studio: &mut Studio,
    all: &[Specimen],
    html: &mut Html,
    findings: &mut Vec<String>,
) -> Result<Vec<SphereRow>, LabError> {
    let size = studio.pick(48, 128);
    let (mut rows, mut mean) = (Vec::new(), MeanDifference::new(size));
    let pictures = format!("measured, {}", NAMES.join(", "));
    let mut table = Table::new(
        "Spheres: relative RMSE, and mean ΔE₀₀ of the pixels as shown (thesis Figures 4.3 and 4.4). GGX and Beckmann have the Fresnel \
         term of algorithm 2",
        ["material", &pictures].into_iter().chain(NAMES),
    );
    for specimen in all {
        let (isotropic, Specimen { name, material, fit }) = (specimen.is_isotropic(), specimen);
        // The thesis draws GGX and Beckmann with the Fresnel term of its own extraction.
        let of_thesis = Fit { extraction: Method::Thesis, ..fit.clone() };
        let models = Models::new(&of_thesis, &samples(&**material, isotropic));
        let named = models.named();
        let mut materials: Vec<&(dyn Brdf + Sync)> = vec![&**material];
        materials.extend(named.iter().map(|(_, model)| *model));
        let images = spheres(&materials, &models.ggx, size);
        let figure = studio.picture(&format!("measured-{name}"), &contact_sheet(&images), 1.0, name, Vec::new())?;
        let mut cells = vec![Cell::from(name.as_str()), Cell::Figure(figure)];
        cells.resize(2 + NAMES.len(), Cell::from("–"));
        for (&(form, _), image) in named.iter().zip(&images[1..]) {
            let error = sphere_error(&images[0], image);
            if isotropic {
                mean.add(form, &images[0], image);
            }
            let column = NAMES.iter().position(|name| *name == form).unwrap_or_default();
            cells[2 + column] = Cell::from(format!("{}, ΔE {}", number(error.rrmse), number(error.delta_e)));
            rows.push(SphereRow {
                material: name.clone(),
                isotropic,
                form,
                rrmse: error.rrmse,
                delta_e: error.delta_e,
            });
        }
        table.row(cells);
    }
    html.table(&table);
    let caption = format!(
        "Mean ΔE₀₀ over {} isotropic materials, from 0 (black) to {MOST_DELTA_E} (yellow), thesis Figure 4.2: {}",
        all.iter().filter(|specimen| specimen.is_isotropic()).count(),
        NAMES.join(", ")
    );
    let figure = studio.codes("measured-delta-e", &mean.image(), "colour differences", vec![caption])?;
    html.figures(&[figure]);
    for form in NAMES {
        let of: Vec<&SphereRow> = rows.iter().filter(|row| row.form == form && row.isotropic).collect();
        let mean = |value: fn(&SphereRow) -> f64| of.iter().map(|row| value(row)).sum::<f64>() / of.len().max(1) as f64;
        findings.push(format!(
            "Isotropic spheres, {form}: mean relative RMSE {}, mean ΔE₀₀ {}.",
            number(mean(|row| row.rrmse)),
            number(mean(|row| row.delta_e))
        ));
    }
    for Specimen { name, .. } in all.iter().filter(|specimen| !specimen.is_isotropic()) {
        let of = rows.iter().filter(|row| row.material == *name);
        let errors: Vec<String> = of.map(|row| format!("{} {}", row.form, number(row.rrmse))).collect();
        findings.push(format!("Sphere of {name}, anisotropic: relative RMSE {}.", errors.join(", ")));
    }
    Ok(rows)
}

/// Tabulates the errors of the fits with 1 to 8 Gaussian lobes (thesis 5.3).
fn lobes(all: &[Specimen], html: &mut Html, findings: &mut Vec<String>) -> Vec<LobeRow> {
    let mut rows = Vec::new();
    for specimen in all {
        let Specimen { name, material, fit } = specimen;
        let samples = samples(&**material, specimen.is_isotropic());
        let head = ["lobes", "divergence of the slopes", "relative RMSE", "of cube roots"];
        let mut table =
            Table::new(format!("{name}: the fit with Gaussian lobes in place of its table, over all directions"), head);
        for lobes in 1..=MOST_LOBES {
            let LobeErrors { slopes, misfit, .. } = lobe_errors(&fit.fitted, &samples, lobes);
            let numbers = [slopes, misfit.rrmse, misfit.perceptual].map(Cell::from);
            table.row([Cell::from(lobes.to_string())].into_iter().chain(numbers));
            rows.push(LobeRow {
                material: name.clone(),
                lobes,
                slopes,
                rrmse: misfit.rrmse,
                cube_root: misfit.perceptual,
            });
        }
        table.row([
            Cell::from("table"),
            Cell::from(0.0),
            Cell::from(fit.misfit.rrmse),
            Cell::from(fit.misfit.perceptual),
        ]);
        html.table(&table);
        let of = |lobes: usize| {
            let row = rows.iter().find(|row| row.material == *name && row.lobes == lobes);
            row.map_or_else(String::new, |row| number(row.rrmse))
        };
        findings.push(format!(
            "{name}: with 1, 4 and 8 lobes, the relative RMSE over all directions is {}, {} and {}; with the table, {}.",
            of(1),
            of(4),
            of(8),
            number(fit.misfit.rrmse)
        ));
    }
    rows
}

/// Returns a relief for one repeat of the sphere. The texels resolve the bumps, but a distant pixel covers hundreds of
/// bumps.
fn relief_of(studio: &Studio, kind: &str, seed: u32) -> HeightMap {
    let side = studio.pick(256, 1024);
    match kind {
        "rugged" => procedural::gaussian(side, side, 5 + seed, 1.0, FEATURE),
        _ => procedural::scratches(side, side, 3 + seed, 400),
    }
}

/// The techniques that are compared with the truth. Each uses the lobes of the fit, or the one lobe of the thesis.
const FORMS: [(&str, Technique, bool); 4] = [
    ("LEADR, lobes of the fit", Technique::Leadr, true),
    ("LEADR, the thesis' fit with one Beckmann lobe", Technique::Leadr, false),
    ("mips of normals", Technique::NormalMip, true),
    ("Blinn-Phong", Technique::BlinnPhong, true),
];

/// A truth, and the pictures that are compared with it.
struct Compared {
    truth: Shot,
    forms: Vec<Shot>,
}

impl Compared {
    /// Returns the mean of several comparisons with independent truths.
    fn mean(all: &[Self]) -> Result<Self, MapFault> {
        let truth = Shot::mean_of_truths(&all.iter().map(|one| one.truth.clone()).collect::<Vec<_>>())?;
        let form = |i: usize| Shot::mean(&all.iter().map(|one| one.forms[i].clone()).collect::<Vec<_>>());
        Ok(Self { truth, forms: (0..FORMS.len()).map(form).collect::<Result<_, _>>()? })
    }

    /// Returns the relative RMSE and bias of each form. The antialiased outline is excluded.
    fn errors(&self, far: bool) -> Result<Vec<(f64, f64)>, MapFault> {
        let RgbImage { width, height, .. } = self.truth.image;
        let filled = Mask::covered(width, height, &self.truth.coverage, 0.999)?;
        let mask = filled.eroded(if far { 1 } else { SILHOUETTE });
        let of = |shot: &Shot| {
            Ok((rrmse_over(&self.truth.image, &shot.image, &mask)?, bias_over(&self.truth.image, &shot.image, &mask)?))
        };
        self.forms.iter().map(of).collect()
    }
}

/// Renders a sphere with one relief in a view.
fn shown_at(
    studio: &Studio,
    viewpoint: Viewpoint,
    samples: u32,
    seed: u64,
    of_lobes: &mut Subject,
    of_one: &mut Subject,
) -> Result<Compared, LabError> {
    let views = of_lobes.stage.views;
    // Pixels of far pictures are means of blocks.
    let far = viewpoint.block > 1;
    let camera = if far { framed_from(&views.mid, viewpoint.block as f32) } else { views.near };
    let side = if far { studio.pick(8, 14) } else { studio.pick(112, 196) };
    let state = of_lobes.seen_by(&camera);
    let size = side * viewpoint.block;
    let truth = if viewpoint.shadowed { Truth::Shadowed } else { Truth::Displacement };
    let settings = RenderSettings { shadows: false, ..truth.settings((size, size), samples, seed) };
    let truth =
        studio.shoot_truth(&mut of_lobes.renderer, &state, &settings)?.of_blocks(viewpoint.block).map_err(fault)?;
    let mut forms = Vec::new();
    for (_, technique, lobes) in FORMS {
        let config = if viewpoint.shadowed {
            Configuration { shading: technique.with(Default::default()), ..Configuration::of(technique) }
        } else {
            Configuration::of(technique).with(Terms::ALL, Shadowing::None)
        };
        let settings = RenderSettings { shadows: false, ..config.settings((side, side), 1) };
        let subject = if lobes { &mut *of_lobes } else { &mut *of_one };
        forms.push(studio.shoot(&mut subject.renderer, &state, &settings)?);
    }
    Ok(Compared { truth, forms })
}

/// Renders Figures 5.4 and 5.5.
fn displaced(
    studio: &mut Studio,
    all: &[Specimen],
    html: &mut Html,
    findings: &mut Vec<String>,
) -> Result<Vec<DisplacedRow>, LabError> {
    let mut rows: Vec<DisplacedRow> = Vec::new();
    let most_reliefs = studio.pick(2, u32::MAX);
    let reliefs = |viewpoint: &Viewpoint| viewpoint.reliefs.min(most_reliefs);
    let most = VIEWPOINTS.iter().map(reliefs).max().unwrap_or(1);
    studio.steps(most as usize * all.len() * DEPTHS.len());
    for Specimen { name, fit, .. } in all {
        for (relief, depth) in DEPTHS {
            let mut shown: [Vec<Compared>; VIEWPOINTS.len()] = Default::default();
            for number in 0..most {
                let map = relief_of(studio, relief, number);
                let material = dressed(fit, name, map, depth);
                let tile = studio.pick(16, 32);
                let mut of_lobes = Subject::under_the_sky(studio, sphere_stage(&material, None, tile), 0.0)?;
                let mut of_one =
                    Subject::under_the_sky(studio, sphere_stage(&as_thesis(&material, fit), None, tile), 0.0)?;
                for (viewpoint, shown) in
                    VIEWPOINTS.into_iter().zip(&mut shown).filter(|(viewpoint, _)| number < reliefs(viewpoint))
                {
                    let samples = (studio.pick(4, viewpoint.samples) / reliefs(&viewpoint)).max(2);
                    let seed = 1 + u64::from(number);
                    shown.push(shown_at(studio, viewpoint, samples, seed, &mut of_lobes, &mut of_one)?);
                }
                studio.step();
            }
            for (viewpoint, shown) in VIEWPOINTS.into_iter().zip(&shown) {
                let far = viewpoint.block > 1;
                let mean = Compared::mean(shown).map_err(fault)?;
                let singles: Vec<_> =
                    shown.iter().map(|one| one.errors(far)).collect::<Result<_, _>>().map_err(fault)?;
                let truth = &mean.truth;
                let mut table = Table::new(
                    format!(
                        "{name}, {relief}, {}: {} pixels, {} reliefs; truth of {} samples in total, its noise {}",
                        viewpoint.name,
                        truth.image.width,
                        shown.len(),
                        truth.samples,
                        number(truth.noise)
                    ),
                    ["", "picture", "rRMSE", "without grain", "bias", "rRMSE of single reliefs"],
                );
                let file =
                    |what: &str| format!("measured-{name}-{relief}-{}-{what}", viewpoint.name.replace(", ", "-"));
                let figure = studio.picture(&file("truth"), &truth.image, 1.0, "truth", Vec::new())?;
                table.row([Cell::from("truth"), Cell::Figure(figure.enlarged(viewpoint.block))]);
                for (i, (rrmse, bias)) in mean.errors(far).map_err(fault)?.into_iter().enumerate() {
                    let form = FORMS[i].0;
                    let ones: Vec<f64> = singles.iter().map(|errors| errors[i].0).collect();
                    let rrmse_of_one = ones.iter().sum::<f64>() / ones.len() as f64;
                    let rrmse_of_filter = without_relief_noise(rrmse, &ones);
                    let figure = studio.picture(&file(&i.to_string()), &mean.forms[i].image, 1.0, form, Vec::new())?;
                    table.row([
                        Cell::from(form),
                        Cell::Figure(figure.enlarged(viewpoint.block)),
                        Cell::from(rrmse),
                        Cell::from(rrmse_of_filter),
                        Cell::from(bias),
                        Cell::from(rrmse_of_one),
                    ]);
                    rows.push(DisplacedRow {
                        material: name.clone(),
                        relief,
                        place: viewpoint.name,
                        form,
                        rrmse,
                        bias,
                        noise: truth.noise,
                        rrmse_of_one,
                        rrmse_of_filter,
                    });
                }
                html.table(&table);
            }
        }
    }
    for Viewpoint { name: place, block, .. } in VIEWPOINTS.into_iter().rev() {
        for row in rows.iter().filter(|row| row.place == place && row.form.contains("lobes of")) {
            let same = |other: &&DisplacedRow| {
                other.material == row.material && other.relief == row.relief && other.place == place
            };
            let others: Vec<String> = rows
                .iter()
                .filter(same)
                .filter(|other| other.form != row.form)
                .map(|other| format!("{} with {}", number(other.rrmse), other.form))
                .collect();
            findings.push(format!(
                "{}, {}, {}: the error of one sample is {}{}, for a single relief {}; {}. The truth's noise is {}.",
                row.material,
                row.relief,
                place,
                number(row.rrmse),
                if block > 1 {
                    format!(", without grain {} (goal {GOAL})", number(row.rrmse_of_filter))
                } else {
                    String::new()
                },
                number(row.rrmse_of_one),
                others.join(", "),
                number(row.noise)
            ));
        }
    }
    Ok(rows)
}

/// Renders Figure 4.6.
fn roughened(
    studio: &mut Studio,
    specimen: &Specimen,
    html: &mut Html,
    findings: &mut Vec<String>,
) -> Result<(), LabError> {
    let side = studio.pick(128, 512);
    let pattern = procedural::fbm(side, side, 9, 6, 4, 0.5);
    // The factors range from half to twice the roughness.
    let texels = pattern.texels.iter().map(|h| (2.5 * h).clamp(-1.0, 1.0).exp2()).map(|factor| 0.5 * factor).collect();
    let raster = Raster::new(side, side, 1, Samples::F32(texels)).map_err(fault)?;
    let flat = HeightMap::new(2, 2, vec![0.5; 4]).map_err(fault)?;
    let plain = Material { relief: None, ..dressed(&specimen.fit, &specimen.name, flat, 0.0) };
    let roughness = Input {
        factor: 2.0 * plain.roughness.factor,
        texture: Some(Texture::new(raster, "roughness", Encoding::Linear)),
        channel: 0,
    };
    let material = Material { roughness, ..plain };
    let mut subject = Subject::under_the_sky(studio, sphere_stage(&material, None, studio.pick(16, 64)), 0.0)?;
    let size = studio.pick(48, 256);
    let state = subject.seen_by(&subject.stage.views.mid);
    let samples = studio.pick(16, 64);
    let truth =
        studio.shoot_truth(&mut subject.renderer, &state, &Truth::Displacement.settings((size, size), samples, 1))?;
    let shot =
        studio.shoot(&mut subject.renderer, &state, &Configuration::of(Technique::Leadr).settings((size, size), 1))?;
    let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
    let mut table = Table::new(
        format!("{}, its slopes scaled by a roughness texture; truth of {samples} samples", specimen.name),
        ["", "picture", "rRMSE", "FLIP"],
    );
    let figure = studio.picture("measured-roughened-truth", &truth.image, 1.0, "truth", Vec::new())?;
    table.row([Cell::from("truth"), Cell::Figure(figure)]);
    let figure = studio.picture("measured-roughened-leadr", &shot.image, 1.0, "LEADR", Vec::new())?;
    table.row([
        Cell::from("LEADR, one sample"),
        Cell::Figure(figure),
        Cell::from(verdict.object.rrmse),
        Cell::from(verdict.object.flip),
    ]);
    html.table(&table);
    findings.push(format!(
        "With slopes scaled by a texture, the error of one sample is {}; the truth's noise is {}.",
        number(verdict.object.rrmse),
        number(truth.noise)
    ));
    Ok(())
}
