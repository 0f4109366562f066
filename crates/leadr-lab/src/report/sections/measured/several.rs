//! Draws a model with one fit per material (thesis Figure 4.6).

use std::path::Path;

use serde::Serialize;

use super::Specimen;
use crate::report::configuration::Configuration;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::judge;
use leadr_maps::material::Input;
use leadr_measured::fit_file::FitFile;
use leadr_models::{LoadOptions, Model};
use leadr_render::settings::Technique;
use leadr_scenes::fitted::apply_fit;
use leadr_scenes::model::{ModelChoice, stage};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};

/// The snail of the demo, whose skin and shell have roughness textures.
const SNAIL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/snail.glb");

/// The errors of one picture of the model.
#[derive(Serialize)]
pub struct SeveralRow {
    roughness: &'static str,
    /// The name of each material of the model and of its fit.
    fits: Vec<(String, String)>,
    /// The bytes of all fits in the renderer.
    bytes: usize,
    rrmse: f64,
    flip: f64,
    noise: f64,
}

/// Returns the snail with a fit for each material, and the specimen of each material. Without `textured`, the roughness is that of the
/// fits.
pub fn fitted_snail(all: &[Specimen], textured: bool) -> Result<(Model, Vec<&Specimen>), LabError> {
    let mut model =
        Model::load(Path::new(SNAIL), LoadOptions::default()).map_err(|error| LabError(error.to_string()))?;
    // The snail has a skin, a shell and eyes. The lacquer, which comes first, is for the eyes.
    let specimens: Vec<&Specimen> = all.iter().rev().cycle().take(model.materials.len()).collect();
    for (material, Specimen { fit, .. }) in model.materials.iter_mut().zip(&specimens) {
        if !textured {
            material.roughness = Input::constant(1.0);
        }
        apply_fit(&FitFile { brdf: fit.fitted.clone(), lobes: fit.lobes.clone() }, material);
    }
    Ok((model, specimens))
}

/// Renders the model with the roughness of the fits, and with its own roughness textures.
pub fn several(
    studio: &mut Studio,
    all: &[Specimen],
    html: &mut Html,
    findings: &mut Vec<String>,
) -> Result<Vec<SeveralRow>, LabError> {
    let (size, samples) = (studio.pick(48, 320), studio.pick(16, 64));
    let mut rows = Vec::new();
    for (roughness, textured) in [("roughness of the fits", false), ("roughness textures of the model", true)] {
        let (model, specimens) = fitted_snail(all, textured)?;
        let fits: Vec<(String, String)> = model
            .materials
            .iter()
            .zip(specimens)
            .map(|(material, specimen)| (material.name.clone(), specimen.name.clone()))
            .collect();
        let tables = model.materials.iter().filter_map(|material| material.fit.as_ref());
        let bytes = tables.map(|table| size_of_val(table.words())).sum();
        let stage = ModelChoice::new(model, None).and_then(stage).map_err(|error| LabError(error.to_string()))?;
        let mut subject = Subject::under_the_sky(studio, stage, 0.0)?;
        let state = subject.seen_by(&subject.stage.views.near);
        let truth = Truth::Displacement.settings((size, size), samples, 1);
        let truth = studio.shoot_truth(&mut subject.renderer, &state, &truth)?;
        let settings = Configuration::of(Technique::Leadr).settings((size, size), 1);
        let shot = studio.shoot(&mut subject.renderer, &state, &settings)?;
        let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
        let of: Vec<String> = fits.iter().map(|(material, fit)| format!("{material}: {fit}")).collect();
        let mut table = Table::new(
            format!("A model with several fits (thesis Figure 4.6), {roughness}; {}", of.join(", ")),
            ["", "picture", "rRMSE", "FLIP"],
        );
        let file = format!("measured-model-{}", if textured { "textured" } else { "plain" });
        let figure = studio.picture(&format!("{file}-truth"), &truth.image, 1.0, "truth", Vec::new())?;
        table.row([Cell::from(format!("truth of {samples} samples")), Cell::Figure(figure)]);
        let figure = studio.picture(&file, &shot.image, 1.0, "LEADR", Vec::new())?;
        table.row([
            Cell::from("LEADR, one sample"),
            Cell::Figure(figure),
            Cell::from(verdict.object.rrmse),
            Cell::from(verdict.object.flip),
        ]);
        html.table(&table);
        findings.push(format!(
            "A model with {} fits of {bytes} bytes together, {roughness}: the error of one sample is {}; the truth's noise is {}.",
            fits.len(),
            number(verdict.object.rrmse),
            number(truth.noise)
        ));
        let (rrmse, flip, noise) = (verdict.object.rrmse, verdict.object.flip, truth.noise);
        rows.push(SeveralRow { roughness, fits, bytes, rrmse, flip, noise });
    }
    Ok(rows)
}
