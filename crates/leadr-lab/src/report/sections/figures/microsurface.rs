//! Draws thesis Figure 3.5: spheres with Gaussian microgeometry, supersampled and filtered.

use glam::{Vec2, Vec3};

use crate::report::case::Case;
use crate::report::configuration::Configuration;
use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::{Shot, judge};
use leadr_render::scene::Sun;
use leadr_render::settings::{RenderSettings, ShadingOptions, Terms};
use leadr_scenes::spheres::cell::{Facets, Lighting, ROTATION_PERIOD};
use leadr_scenes::spheres::surface::{Detail, Frequency, Surface};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Table, number};

/// The Beckmann roughness of the base material. If the base were smooth, few samples of the truth would hit a facet that
/// reflects the light.
const BASE: f32 = 0.35;
/// The camera distance of the close pictures, in sphere radii.
const CLOSE: f32 = 5.0;
/// The irradiance of the light on a plane that faces the light.
const IRRADIANCE: f32 = 3.0;

/// Returns a light that is `degrees` to the right of the viewer.
fn sun(degrees: f32) -> Sun {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Sun { direction: Vec3::new(sin, -cos, 0.0), irradiance: Vec3::splat(IRRADIANCE) }
}

/// Returns the mean over rotations of the sphere about its poles, with its noise. A single rotation would show only a few
/// bumps per pixel.
fn mean(
    studio: &Studio,
    subject: &mut Subject,
    turns: u32,
    (sigma, degrees): (f32, f32),
    settings: &RenderSettings,
) -> Result<Shot, LabError> {
    let camera = subject.stage.views.mid;
    let mut halves = [Vec::new(), Vec::new()];
    for turn in 0..turns {
        subject.set_time(f64::from(turn) / f64::from(turns) * ROTATION_PERIOD);
        let mut state = subject.seen_by(&camera);
        state.height_scale = sigma;
        state.sun = Some(sun(degrees));
        let settings = RenderSettings { seed: settings.seed + u64::from(turn), ..*settings };
        halves[turn as usize % 2].push(studio.shoot(&mut subject.renderer, &state, &settings)?);
    }
    let [a, b] = halves.map(|half| Shot::mean(&half).map_err(fault));
    Shot::mean_of(&a?, &b?).map_err(fault)
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Thesis Figure 3.5",
        "Displaced spheres of Gaussian slopes with specular facets of α = .35, in one light at the listed angle to the right of the \
        viewer: a close-up of the microsurface, the supersampled truth with the shadows of the bumps, and LEADR at one sample per pixel. \
        Both are means over rotations of the sphere, which keep its statistics.",
    );
    let side = studio.pick(40, 64);
    let (turns, samples) = studio.pick((4, 4), (16, 4));
    let sigmas: &[f32] = if studio.quick { &[0.3] } else { &[0.1, 0.3, 0.6] };
    let lights = [0.0, 60.0];
    let surface = Surface::bake(Vec2::ONE, Frequency::High, Detail { patches: 8, tile: 32 });
    let mut stage = surface.stage(1.0, Facets::Mirror);
    stage.set_roughness(BASE);
    let mut subject = Subject::in_panorama(studio, stage, &Lighting::Front.panorama(), Lighting::Front.lights())?;
    let config = Configuration::program_default();
    let of_specular = |settings: RenderSettings| RenderSettings {
        shading: settings.shading.adjusted(|options| ShadingOptions { terms: Terms::SPECULAR_LIGHTS, ..options }),
        ..settings
    };
    let truth_of = |size: u32, samples: u32| of_specular(Truth::Shadowed.settings((size, size), samples, 1));
    let mut table = Table::new(
        format!("Truth of {turns} × {samples} samples per pixel; errors inside the outline"),
        [
            "σ of the slopes, light",
            "microsurface",
            "truth",
            "LEADR",
            "FLIP errors",
            "rRMSE",
            "bias",
            "noise of the truth",
        ],
    );
    let mut errors: Vec<(f64, f64, String)> = Vec::new();
    for &sigma in sigmas {
        for degrees in lights {
            let mut near = subject.seen_by(&subject.stage.views.mid.at_distance(CLOSE));
            near.height_scale = sigma;
            near.sun = Some(sun(degrees));
            let close = studio.shoot(&mut subject.renderer, &near, &truth_of(side, studio.pick(1, 4)))?;
            let truth = mean(studio, &mut subject, turns, (sigma, degrees), &truth_of(side, samples))?;
            let shot =
                mean(studio, &mut subject, turns, (sigma, degrees), &of_specular(config.settings((side, side), 1)))?;
            // With this exposure, the sphere is mid-grey at every roughness.
            let exposure = (0.35 / truth.luminance(&truth.interior().map_err(fault)?).max(1e-3)) as f32;
            let verdict = judge(&truth, &shot, exposure).map_err(fault)?;
            let name = |what: &str| format!("figures-microsurface-{sigma}-{degrees}-{what}").replace('.', "_");
            let figures = [
                studio.picture(&name("close"), &close.image, exposure, "the microsurface", Vec::new())?,
                studio.picture(&name("truth"), &truth.image, exposure, "truth", Vec::new())?,
                studio.picture(&name("leadr"), &shot.image, exposure, &config.name, Vec::new())?,
                studio.error_picture(&name("errors"), &verdict, "FLIP errors", Vec::new())?,
            ];
            let what = format!("σ = {sigma}, {degrees}°");
            let error = verdict.interior;
            let numbers = [error.rrmse, error.bias, truth.noise].map(Cell::from);
            let cells = figures.iter().cloned().map(Cell::Figure).chain(numbers);
            table.row(std::iter::once(Cell::from(what.as_str())).chain(cells));
            page.check(format!("rRMSE inside, {what}"), error.rrmse);
            page.check(format!("noise of the truth, {what}"), truth.noise);
            let subject = format!("Gaussian specular facets, {what}");
            let mut case = Case::new("figures", subject, &config.name, Truth::Shadowed.name(), &verdict);
            case.figures = figures[1..].to_vec();
            studio.cases.push(case);
            errors.push((error.rrmse, truth.noise, what));
        }
    }
    page.html.table(&table);
    let listed: Vec<String> = errors
        .iter()
        .map(|(rrmse, noise, what)| format!("{} at {what} (noise {})", number(*rrmse), number(*noise)))
        .collect();
    page.find(&format!("the error of one filtered sample is {}.", listed.join(", ")));
    Ok(())
}
