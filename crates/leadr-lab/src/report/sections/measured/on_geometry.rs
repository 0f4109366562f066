//! Draws a model with the measured BRDFs themselves and with their fits (thesis Figure 4.6 a and b). One integrator on the CPU draws both,
//! so their difference is the error of the fits.

use std::fmt::{self, Display, Formatter};

use serde::Serialize;

use super::Specimen;
use super::several::fitted_snail;
use crate::report::configuration::Configuration;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::verdict::Shot;
use crate::report::visible_surface::{Drawn, VisibleSurface};
use leadr_maps::RgbImage;
use leadr_maps::material::Material;
use leadr_maps::tonemap::Tonemap;
use leadr_render::scene::Object;
use leadr_render::settings::Technique;
use leadr_scenes::model::{ModelChoice, stage};
use leadr_tools::error::LabError;
use leadr_tools::fit::mean_difference::MOST_DELTA_E;
use leadr_tools::html::{Cell, Html, Table, number};
use leadr_tools::metrics::Mask;
use leadr_tools::metrics::compare::{magma, rrmse_over};
use leadr_tools::metrics::delta_e::delta_e_map;

/// The number of surface points per pixel along an axis.
const POINTS: u32 = 3;

/// The difference of two pictures inside the outline of the model.
#[derive(Clone, Copy, Serialize)]
struct Difference {
    rrmse: f64,
    delta_e: f64,
}

impl Display for Difference {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "relative RMSE {}, mean ΔE₀₀ {}", number(self.rrmse), number(self.delta_e))
    }
}

/// The differences between the pictures of the model.
#[derive(Serialize)]
pub struct OnGeometry {
    /// The noise of the CPU's pictures. Their directions are equal, so it affects their difference little.
    noise: f64,
    fits_from_measured: Difference,
    leadr_from_measured: Difference,
    leadr_from_fits: Difference,
}

/// The pictures of the model.
struct Pictures {
    measured: RgbImage,
    fits: RgbImage,
    leadr: RgbImage,
    /// The pixels inside the outline of the model.
    inside: Mask,
    noise: f64,
}

/// Draws the snail with one material of `all` on each part, and compares the pictures.
pub fn on_geometry(
    studio: &mut Studio,
    all: &[Specimen],
    html: &mut Html,
    findings: &mut Vec<String>,
) -> Result<OnGeometry, LabError> {
    let Pictures { measured, fits, leadr, inside, noise } = pictures(studio, all)?;
    let mut compared = |name: &str, reference, test| compare(studio, name, reference, test, &inside);
    let (fits_from_measured, fits_map) = compared("fits-from-measured", &measured, &fits)?;
    let (leadr_from_measured, leadr_map) = compared("leadr-from-measured", &measured, &leadr)?;
    let (leadr_from_fits, leadr_fits_map) = compared("leadr-from-fits", &fits, &leadr)?;
    let mut shown = |name: &str, image| {
        studio.picture(&format!("measured-geometry-{name}"), image, 1.0, name, Vec::new()).map(Cell::Figure)
    };
    let mut table = Table::new(
        format!(
            "A model without normal maps, with the measured BRDFs and with their fits (thesis Figure 4.6, a and b). The CPU draws the \
             first two pictures with equal directions; their noise is {}. Differences inside the outline, as ΔE₀₀ of the pixels as \
             shown, from 0 (black) to {MOST_DELTA_E} (yellow)",
            number(noise)
        ),
        ["", "picture", "difference from the measured BRDFs", "", "difference from the CPU's fits", ""],
    );
    let cell = |difference: Difference| Cell::from(difference.to_string());
    table.row([Cell::from("measured BRDFs, CPU"), shown("measured", &measured)?]);
    table.row([Cell::from("fits, CPU"), shown("fits", &fits)?, fits_map, cell(fits_from_measured)]);
    table.row([
        Cell::from("fits, one sample of LEADR"),
        shown("leadr", &leadr)?,
        leadr_map,
        cell(leadr_from_measured),
        leadr_fits_map,
        cell(leadr_from_fits),
    ]);
    html.table(&table);
    findings.push(format!(
        "A smooth model with fits differs from the model with the measured BRDFs: {fits_from_measured}; the noise of both is {}.",
        number(noise)
    ));
    findings.push(format!(
        "One sample of LEADR with these fits differs from the measured BRDFs: {leadr_from_measured}; from the CPU's picture of the fits: \
         {leadr_from_fits}."
    ));
    Ok(OnGeometry { noise, fits_from_measured, leadr_from_measured, leadr_from_fits })
}

/// Draws the snail. It has no normal maps, because a BRDF has no values for normals that face away from the eye.
fn pictures(studio: &Studio, all: &[Specimen]) -> Result<Pictures, LabError> {
    let (mut model, specimens) = fitted_snail(all, false)?;
    model.materials.iter_mut().for_each(|material| material.normal_map = None);
    let name = |material: &Material| format!("{} {}", model.name, material.name);
    let parts: Vec<(String, &Specimen)> = model.materials.iter().map(name).zip(specimens).collect();
    let stage = ModelChoice::new(model, None).and_then(stage).map_err(|error| LabError(error.to_string()))?;
    let drawn = |object: &Object| {
        let (_, Specimen { material, fit, .. }) = parts.iter().find(|(name, _)| *name == object.name)?;
        Some(Drawn { materials: [&**material, &fit.fitted], guide: fit.as_ggx() })
    };
    let objects: Vec<Option<Drawn<'_, 2>>> = stage.objects.iter().map(drawn).collect();
    let mut subject = Subject::under_the_sky(studio, stage, 0.0)?;
    let state = subject.seen_by(&subject.stage.views.near);
    let size = studio.pick(48, 320);
    let settings = Configuration::of(Technique::Leadr).settings((size, size), 1);
    let leadr = studio.shoot(&mut subject.renderer, &state, &settings)?.image;
    let surface = VisibleSurface::of(studio, &mut subject.renderer, &state, (POINTS * size, POINTS * size))?;
    let shots = surface.shaded(&objects, &state)?;
    let blocks = shots.iter().map(|shot| shot.of_blocks(POINTS)).collect::<Result<Vec<_>, _>>().map_err(fault)?;
    let [measured, fits] = [0, 1].map(|i| over(&blocks[i], &leadr));
    Ok(Pictures { inside: blocks[0].interior().map_err(fault)?, noise: blocks[0].noise, measured, fits, leadr })
}

/// Returns the covered part of a picture over the ground and the sky of another one.
fn over(shot: &Shot, background: &RgbImage) -> RgbImage {
    let texels = shot.image.texels.iter().zip(&background.texels).zip(&shot.coverage);
    let texels = texels.map(|((front, back), covered)| std::array::from_fn(|c| front[c] + (1.0 - covered) * back[c]));
    RgbImage { texels: texels.collect(), ..*background }
}

/// Compares two pictures over a mask, and returns a picture of ΔE₀₀.
fn compare(
    studio: &mut Studio,
    name: &str,
    reference: &RgbImage,
    test: &RgbImage,
    inside: &Mask,
) -> Result<(Difference, Cell), LabError> {
    let mut map = delta_e_map(reference, test, 1.0, Tonemap::Filmic).map_err(fault)?;
    map.iter_mut().zip(&inside.inside).filter(|(_, inside)| !**inside).for_each(|(delta, _)| *delta = 0.0);
    let delta_e = map.iter().sum::<f64>() / inside.count().max(1) as f64;
    let rrmse = rrmse_over(reference, test, inside).map_err(fault)?;
    let shown: Vec<f32> = map.iter().map(|delta| (delta / MOST_DELTA_E).min(1.0) as f32).collect();
    let codes = magma(reference.width, reference.height, &shown);
    let figure = studio.codes(&format!("measured-geometry-{name}"), &codes, "colour differences", Vec::new())?;
    Ok((Difference { rrmse, delta_e }, Cell::Figure(figure)))
}
