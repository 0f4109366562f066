//! The pages and pictures of `leadr fit`.

use std::path::Path;

use super::fitted::{Drawn, Fitted, SPHERE};
use super::folder::FolderReport;
use leadr_reflectance::materials::brdf::Brdf;
use leadr_tools::fit::lobe_plot::lobe_plot;
use leadr_tools::fit::mean_difference::MOST_DELTA_E;
use leadr_tools::fit::models::NAMES;
use leadr_tools::fit::spheres::GAP;
use leadr_tools::html::{Cell, Figure, Html, PageSection, Table, page};

/// The light directions of the plots, in degrees from the normal.
const LIT_FROM: [f64; 3] = [15.0, 45.0, 75.0];

/// Returns the file name of a picture that a page shows.
fn file_name(picture: &Path) -> String {
    picture.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn sheet(picture: &Path, rows: u32, names: &[&str]) -> Figure {
    Figure {
        file: file_name(picture),
        alt: "Spheres of the material and its fits".to_owned(),
        caption: vec![format!("Measured, {}", names.join(", "))],
        width: (names.len() as u32 + 1) * (SPHERE + GAP) + GAP,
        height: rows * (SPHERE + 2 * GAP),
        scale: 1,
    }
}

fn differences(picture: &Path) -> Figure {
    Figure {
        file: file_name(picture),
        alt: "Colour differences of the spheres".to_owned(),
        caption: vec![format!("Mean ΔE₀₀ from 0 (black) to {MOST_DELTA_E} (yellow): {}", NAMES.join(", "))],
        width: NAMES.len() as u32 * SPHERE,
        height: SPHERE,
        scale: 1,
    }
}

/// Returns the page of one material.
pub fn of_material(fitted: &Fitted, drawn: &Drawn, picture: &Path, delta_e: Option<&Path>) -> String {
    let report = &fitted.report;
    let models = drawn.models.named();
    let mut body = Html::new();
    let names: Vec<&str> = models.iter().map(|(name, _)| *name).collect();
    let figures: Vec<Figure> = [sheet(picture, 1, &names)].into_iter().chain(delta_e.map(differences)).collect();
    body.figures(&figures);
    let mut table = Table::new("Errors of the spheres against the measured one", ["material", "relative RMSE", "ΔE₀₀"]);
    for sphere in &report.spheres {
        table.row([sphere.material.into(), sphere.error.rrmse.into(), sphere.error.delta_e.into()]);
    }
    body.table(&table);
    if !report.lobe_errors.is_empty() {
        let head = ["lobes", "divergence of the slopes", "relative RMSE", "of cube roots"];
        let mut table = Table::new("The fit with Gaussian lobes in place of its table, over all directions", head);
        for row in &report.lobe_errors {
            let numbers = [row.slopes, row.misfit.rrmse, row.misfit.cube_root_rrmse];
            table.row([Cell::from(row.lobes.to_string())].into_iter().chain(numbers.map(Cell::from)));
        }
        body.table(&table);
    }
    let mut materials: Vec<(&str, &dyn Brdf)> = vec![("measured", &fitted.measured)];
    materials.extend(models.iter().map(|(name, model)| (*name, *model as &dyn Brdf)));
    body.plot(&lobe_plot(&materials, None));
    for degrees in LIT_FROM {
        body.plot(&lobe_plot(&materials, Some(degrees)));
    }
    let rgb = |c: [f64; 3]| format!("{:.4} {:.4} {:.4}", c[0], c[1], c[2]);
    let facts: Vec<(String, String)> = [
        ("material", report.database.clone()),
        ("extraction", report.extraction.to_owned()),
        ("Beckmann", report.beckmann.to_string()),
        ("GGX", report.ggx.to_string()),
        ("F0", rgb(report.f0)),
        ("diffuse", rgb(report.diffuse)),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec();
    page("Fitted material", &facts, &[PageSection { name: "fit", title: "Fit", html: &body }])
}

/// Returns the page of a folder.
pub fn of_folder(report: &FolderReport, picture: &Path, delta_e: Option<&Path>) -> String {
    let mut body = Html::new();
    let figures: Vec<Figure> =
        [sheet(picture, report.materials.len() as u32, &NAMES)].into_iter().chain(delta_e.map(differences)).collect();
    body.figures(&figures);
    let head = ["material"].into_iter().chain(NAMES);
    let mut table =
        Table::new("Spheres against the measured one: relative RMSE, ΔE₀₀. One row per row of the picture", head);
    let cell = |rrmse: f64, delta_e: f64| Cell::from(format!("{rrmse:.3}, {delta_e:.2}"));
    for material in &report.materials {
        let of = |name: &str| {
            let sphere = material.spheres.iter().find(|sphere| sphere.material == name);
            sphere.map_or_else(|| Cell::from("–"), |sphere| cell(sphere.error.rrmse, sphere.error.delta_e))
        };
        table.row([Cell::from(file_name(&material.input))].into_iter().chain(NAMES.map(of)));
    }
    let of = |name: &str| {
        let mean = report.means.iter().find(|mean| mean.model == name);
        mean.map_or_else(|| Cell::from("–"), |mean| cell(mean.rrmse, mean.delta_e))
    };
    table.row([Cell::from("mean")].into_iter().chain(NAMES.map(of)));
    body.table(&table);
    let facts = [
        ("materials", report.materials.len().to_string()),
        ("not fitted", report.failed.iter().map(|failed| file_name(&failed.file)).collect::<Vec<_>>().join(", ")),
    ];
    let facts: Vec<(String, String)> = facts
        .into_iter()
        .filter(|(_, value)| !value.is_empty())
        .map(|(name, value)| (name.to_owned(), value))
        .collect();
    page("Fitted materials", &facts, &[PageSection { name: "fits", title: "Fits", html: &body }])
}
