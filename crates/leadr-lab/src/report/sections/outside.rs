//! Compares LEADR with pictures from an independent renderer.

use serde::Serialize;

use crate::report::configuration::Configuration;
use crate::report::outside::panoramas::panorama;
use crate::report::outside::reliefs::relief;
use crate::report::outside::{OutsideCase, OutsideTruth, block_means, truths};
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use leadr_render::settings::{ShadingOptions, Technique};
use leadr_scenes::stage::{Lights, ReliefOptions, USUAL_RELIEF, plane_stage, sphere_stage};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number, percent};
use leadr_tools::metrics::compare::{bias_over, rrmse_over};

const INTRO: &str = "Smooth spheres, a flat plane and reliefs under panoramas: one sample of leadr at its default settings against \
    Mitsuba 3. Its pictures are stored as means of blocks of 2 × 2 or 3 × 3 pixels (scripts/external-truth renders them again). Light \
    comes from the environment only, specular and diffuse separately. The noise of the truth is per pixel; that of its blocks is two to \
    three times lower. Panoramas and height maps of the shared data are drawn if LEADR_SHARED contains them; the others are generated.";

/// The size of atlas tiles for the smooth sphere, whose maps are empty.
const TILE: u32 = 8;

#[derive(Clone, Debug, Serialize)]
struct Measured {
    name: String,
    rrmse: f64,
    bias: f64,
    /// The error of the paper's 5 × 5 grid, for specular cases.
    grid_rrmse: Option<f64>,
    noise: f64,
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let stored = truths()?;
    let quick = studio.quick;
    let wanted: Vec<OutsideTruth> = stored.into_iter().filter(|truth| !quick || is_quick(&truth.case)).collect();
    studio.steps(wanted.len());
    let (mut measured, mut missing) = (Vec::new(), 0);
    for truth in &wanted {
        match measure(studio, truth)? {
            Some(row) => measured.push(row),
            None => missing += 1,
        }
        studio.step();
    }
    let mut html = Html::new();
    for (group, title) in [("sphere", "Smooth spheres"), ("flat", "A flat plane"), ("plane", "Relief")] {
        let rows: Vec<&Measured> = measured.iter().filter(|m| m.name.starts_with(&format!("{group}/"))).collect();
        if rows.is_empty() {
            continue;
        }
        let mut table = Table::new(title, ["case", "rRMSE", "bias", "rRMSE, 5×5 grid", "noise of the truth"]);
        for row in rows {
            let grid = row.grid_rrmse.map_or(Cell::from("–"), Cell::from);
            table.row([Cell::from(row.name.as_str()), row.rrmse.into(), row.bias.into(), grid, row.noise.into()]);
        }
        html.table(&table);
    }
    Section::new(INTRO, findings(&measured, missing), &html, &measured)
}

/// Whether a quick report includes the case. A quick report has a few cases that need no shared data.
fn is_quick(case: &OutsideCase) -> bool {
    let ready = ["pixel", "tubes", "lamps", "checks"].contains(&case.panorama.as_str()) && case.relief == "studs";
    ready && (case.group() != "sphere" || case.alpha == 0.1 || case.terms == "diffuse") && !case.name.contains("/near/")
}

/// Renders a case and compares it with the truth. Returns `None` if the panorama or relief is missing.
fn measure(studio: &Studio, truth: &OutsideTruth) -> Result<Option<Measured>, LabError> {
    let OutsideTruth { case, image, mask } = truth;
    let (Some(light), Some(mut heights)) = (panorama(&case.panorama)?, relief(&case.relief)?) else { return Ok(None) };
    let mut camera = case.camera();
    if case.scene != "sphere" {
        // The truth has the first row of the map at y = 0, and height 0 at z = 0. Our plane has the mean of the map at z = 0.
        heights.texels = heights.texels.chunks_exact(heights.width as usize).rev().flatten().copied().collect();
        let lower = glam::Vec3::Z * heights.mean() * USUAL_RELIEF * case.scale;
        (camera.position, camera.target) = (camera.position - lower, camera.target - lower);
    }
    let relief = ReliefOptions { map: Some(heights), roughness: case.alpha, tile: TILE, ..ReliefOptions::default() };
    let stage = if case.scene == "sphere" { sphere_stage(relief) } else { plane_stage(relief) };
    let stage = stage.with_relief({
        let scale = case.scale;
        move |_| scale
    });
    let mut subject = Subject::in_panorama(studio, stage, &light, Lights::default())?;
    let state = subject.seen_by(&camera);
    let mut errors = |config: Configuration| -> Result<(f64, f64), LabError> {
        let shading = config.shading.adjusted(|options| ShadingOptions { terms: case.terms(), ..options });
        let settings = Configuration { shading, ..config }.settings(case.size.into(), 1);
        let shot = studio.shoot(&mut subject.renderer, &state, &settings)?;
        let seen = block_means(&shot.image, case.block).map_err(fault)?;
        let rrmse = rrmse_over(image, &seen, mask).map_err(fault)?;
        Ok((rrmse, bias_over(image, &seen, mask).map_err(fault)?))
    };
    let (rrmse, bias) = errors(Configuration::program_default())?;
    let grid = Configuration { shading: Technique::Leadr.with(paper_grid()), ..Configuration::grid(5) };
    let grid_rrmse = if case.terms == "specular" { Some(errors(grid)?.0) } else { None };
    Ok(Some(Measured { name: case.name.clone(), rrmse, bias, grid_rrmse, noise: case.noise }))
}

/// Returns options for the paper's grid with the program's own shadowing.
fn paper_grid() -> ShadingOptions {
    ShadingOptions { quadrature: leadr_render::settings::Quadrature::Grid(5), ..Default::default() }
}

fn findings(measured: &[Measured], missing: usize) -> Vec<String> {
    let mut findings = Vec::new();
    let groups = [
        ("sphere/", "specular", "specular smooth spheres"),
        ("sphere/", "diffuse", "diffuse smooth spheres"),
        ("flat/", "", "a flat plane"),
        ("/far/", "", "distant relief"),
        ("/oblique/", "", "relief at a grazing angle"),
        ("/mid/", "", "relief at mid distance"),
        ("/near/", "", "close relief"),
    ];
    for (part, terms, title) in groups {
        let rows: Vec<&Measured> =
            measured.iter().filter(|m| m.name.contains(part) && m.name.ends_with(terms)).collect();
        let Some(worst) = rows.iter().max_by(|a, b| a.rrmse.total_cmp(&b.rrmse)) else { continue };
        let mean = rows.iter().map(|m| m.rrmse).sum::<f64>() / rows.len() as f64;
        let graded: Vec<&&Measured> = rows.iter().filter(|m| m.grid_rrmse.is_some()).collect();
        let better = graded.iter().filter(|m| m.grid_rrmse.is_some_and(|grid| m.rrmse <= grid)).count();
        let grid = if graded.is_empty() {
            String::new()
        } else {
            format!(" More accurate than the paper's 5×5 grid in {better} of {} cases.", graded.len())
        };
        findings.push(format!(
            "{} cases of {title}: rRMSE {} on average, at worst {} ({}, bias {}, noise of the truth {}).{grid}",
            rows.len(),
            number(mean),
            number(worst.rrmse),
            worst.name,
            percent(worst.bias, true),
            percent(worst.noise, false),
        ));
    }
    if missing > 0 {
        findings.push(format!("{missing} cases were not drawn: their maps are not in LEADR_SHARED."));
    }
    findings
}
