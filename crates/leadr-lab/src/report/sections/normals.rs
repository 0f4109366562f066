//! Measures normal maps in combination with heights, and normal maps alone on smooth geometry.

use glam::{Vec2, Vec3};
use serde::Serialize;

use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::{Shot, judge};
use leadr_maps::{HeightMap, procedural};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::camera::Camera;
use leadr_render::scene::Object;
use leadr_render::settings::{RenderSettings, ShadingOptions, Technique, Terms};
use leadr_render::surfaces::displacement::HeightField;
use leadr_scenes::plane::{even, plane};
use leadr_scenes::spheres::cell::{Lighting, ROTATION_PERIOD};
use leadr_scenes::spheres::surface::{Detail, Frequency, Surface};
use leadr_scenes::stage::{Stage, Views};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};

const INTRO: &str = "First, heights at a quarter of the resolution with normals at full resolution, against full-resolution heights \
    alone: the case of most downloaded materials. Then spheres of Gaussian slopes as a normal map on smooth geometry, the top row of the \
    paper's Figure 8. Their truth is supersampled normal mapping; LEADR filters it with the normal map's facets, which do not hide each \
    other (thesis section 5.2 and Table 2.IV). Also shown: the displaced spheres of the middle row, and the displaced-surface model \
    applied to a normal map.";

/// The number of texels along a side of the full heights. The coarse heights have a quarter as many.
const FULL: u32 = 512;
const METRES: f32 = 2.0;
const DISTANCES: [f32; 3] = [1.5, 6.0, 24.0];

#[derive(Serialize)]
enum Entry {
    Both { distance: f32, rrmse: f64, flip: f64 },
    Sphere { light: &'static str, sigma: f32, normal_map: f64, displacement: f64, as_relief: f64 },
}

/// Returns heights of several octaves. The finest octaves are lost at a quarter of the resolution.
fn full_heights() -> HeightField {
    let octaves = [(48.0, 0.6), (16.0, 0.5), (3.0, 0.45)];
    let fields: Vec<_> = octaves
        .iter()
        .zip(1u32..)
        .map(|(&(bump, slope), seed)| procedural::gaussian(FULL, FULL, seed, slope, bump / FULL as f32))
        .collect();
    let texels = (0..(FULL * FULL) as usize).map(|i| fields.iter().map(|f| f.texels[i]).sum()).collect();
    HeightField::repeating(HeightMap { width: FULL, height: FULL, texels })
}

/// Returns mean heights of 4 × 4 texel squares, upsampled to the full size as in a renderer.
fn coarse_heights(full: &HeightField) -> HeightField {
    let n = FULL / 4;
    let square = |i: u32| {
        let (x, y) = (4 * (i % n), 4 * (i / n));
        (0..16).map(|k| full.map.texels[((y + k / 4) * FULL + x + k % 4) as usize]).sum::<f32>() / 16.0
    };
    let small = HeightField::repeating(HeightMap { width: n, height: n, texels: (0..n * n).map(square).collect() });
    let at = |i: u32| (Vec2::new((i % FULL) as f32, (i / FULL) as f32) + 0.5) / FULL as f32;
    let texels = (0..FULL * FULL).map(|i| small.bicubic(at(i))).collect();
    HeightField::repeating(HeightMap { width: FULL, height: FULL, texels })
}

/// Computes slopes by central differences, as in a full-resolution normal map.
fn slopes(full: &HeightField) -> Vec<[f32; 2]> {
    let at = |x: u32, y: u32| full.map.texels[((y % FULL) * FULL + x % FULL) as usize];
    let per = 0.5 * FULL as f32;
    (0..FULL * FULL)
        .map(|i| (i % FULL, i / FULL))
        .map(|(x, y)| [at(x + 1, y) - at(x + FULL - 1, y), at(x, y + 1) - at(x, y + FULL - 1)].map(|d| d * per))
        .collect()
}

fn ground(heights: HeightField, slopes: Option<Vec<[f32; 2]>>, camera: Camera) -> Stage {
    let mesh = plane(4.0, 16, METRES, [0.4, 0.35, 0.3, 0.3], even);
    let object = Object::new("plane", mesh).with_heights(heights, METRES * 0.3);
    let object = if let Some(slopes) = slopes { object.with_slopes(slopes) } else { object };
    Stage::still(vec![object], Views { near: camera, mid: camera, far: camera })
}

fn sigmas(studio: &Studio) -> &'static [f32] {
    studio.pick::<&[f32]>(&[0.2, 1.0], &[0.1, 0.2, 0.5, 1.0, 2.0])
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    studio.steps(DISTANCES.len() + LIGHTS.len() * sigmas(studio).len());
    let (mut html, mut entries, mut findings) = (Html::new(), Vec::new(), Vec::new());
    both(studio, &mut html, &mut entries, &mut findings)?;
    alone(studio, &mut html, &mut entries, &mut findings)?;
    Section::new(INTRO, findings, &html, &entries)
}

fn both(
    studio: &mut Studio,
    html: &mut Html,
    entries: &mut Vec<Entry>,
    findings: &mut Vec<String>,
) -> Result<(), LabError> {
    let size = studio.pick(64, 160);
    let full = full_heights();
    let camera = |distance: f32| Camera::looking_at(Vec3::new(0.3, -0.7, 0.5).normalize() * distance, Vec3::ZERO, 14.0);
    let alone = ground(full.clone(), None, camera(1.0));
    let both = ground(coarse_heights(&full), Some(slopes(&full)), camera(1.0));
    let (mut alone, mut both) =
        (Subject::under_the_sky(studio, alone, 0.0)?, Subject::under_the_sky(studio, both, 0.0)?);
    let mut table = Table::new(
        format!(
            "{} × {} heights with normals of {FULL} × {FULL}, against {FULL} × {FULL} heights alone",
            FULL / 4,
            FULL / 4
        ),
        ["distance", "heights alone", "height + normal", "rRMSE", "FLIP"],
    );
    for distance in DISTANCES {
        let camera = camera(distance);
        let settings = RenderSettings { size: (size, size), samples: 4, ..Default::default() };
        let state = alone.seen_by(&camera);
        let truth = studio.shoot(&mut alone.renderer, &state, &settings)?;
        let shot = studio.shoot(&mut both.renderer, &state, &settings)?;
        let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
        let (rrmse, flip) = (verdict.object.rrmse, verdict.object.flip);
        let name = |what: &str| format!("normals-{distance}-{what}").replace('.', "_");
        table.row([
            Cell::from(format!("{distance} m")),
            Cell::Figure(studio.picture(&name("heights"), &truth.image, 1.0, "heights alone", Vec::new())?),
            Cell::Figure(studio.picture(&name("both"), &shot.image, 1.0, "height + normal", Vec::new())?),
            Cell::from(rrmse),
            Cell::from(flip),
        ]);
        entries.push(Entry::Both { distance, rrmse, flip });
        studio.step();
        findings.push(format!(
            "Height + normal against heights of four times the resolution, {distance} m away: rRMSE {} (goal: at most .02 from the middle distance, 6 m, on).",
            number(rrmse)
        ));
    }
    html.table(&table);
    Ok(())
}

const LIGHTS: [(Lighting, Terms, &str); 3] = [
    (Lighting::Front, Terms::DIFFUSE_LIGHTS, "diffuse, light from the camera"),
    (Lighting::Irradiance, Terms::DIFFUSE_ENVIRONMENT, "diffuse, irradiance"),
    (Lighting::Environment, Terms::SPECULAR_ENVIRONMENT, "specular, environment"),
];

fn alone(
    studio: &mut Studio,
    html: &mut Html,
    entries: &mut Vec<Entry>,
    findings: &mut Vec<String>,
) -> Result<(), LabError> {
    let size = studio.pick(40, 96);
    let turns = studio.pick(4u32, 12);
    let sigmas = sigmas(studio);
    let surface =
        Surface::bake(Vec2::ONE, Frequency::High, studio.pick(Detail { patches: 8, tile: 32 }, Detail::PICTURE));
    for (lighting, terms, title) in LIGHTS {
        let stage = surface.stage(1.0, lighting.facets());
        let mut subject = Subject::in_panorama(studio, stage, &lighting.panorama(), lighting.lights())?;
        let camera = subject.stage.views.mid;
        let mut mean = |studio: &Studio, settings: RenderSettings, sigma: f32| -> Result<Shot, LabError> {
            let mut halves = [Vec::new(), Vec::new()];
            for turn in 0..turns {
                subject.set_time(f64::from(turn) / f64::from(turns) * ROTATION_PERIOD);
                let mut state = subject.seen_by(&camera);
                state.height_scale = sigma;
                let settings = RenderSettings { seed: settings.seed + u64::from(turn), ..settings };
                halves[turn as usize % 2].push(studio.shoot(&mut subject.renderer, &state, &settings)?);
            }
            let [a, b] = halves.map(|half| Shot::mean(&half).map_err(fault));
            Shot::mean_of(&a?, &b?).map_err(fault)
        };
        let mut table = Table::new(
            format!("Figure 8, {title}: rRMSE inside the silhouette, one sample per pixel"),
            [
                "σ",
                "normal-map truth",
                "leadr, normal map",
                "",
                "displaced",
                "displacement model on the normal map",
                "noise",
            ],
        );
        for &sigma in sigmas {
            let samples = studio.pick(4, 16);
            let truth = |truth: Truth, samples: u32| {
                let mut settings = truth.settings((size, size), samples, 1);
                settings.shading = settings.shading.adjusted(|options| ShadingOptions { terms, ..options });
                settings.shadows = false;
                settings
            };
            let leadr = |shadowing: Shadowing, displacement: bool| RenderSettings {
                size: (size, size),
                samples: 1,
                displacement,
                shadows: false,
                shading: Technique::Leadr.with(ShadingOptions {
                    terms,
                    shadowing,
                    relief_occlusion: false,
                    ..Default::default()
                }),
                ..Default::default()
            };
            let mapped_truth = mean(studio, truth(Truth::NormalMap, 4 * samples), sigma)?;
            let displaced_truth = mean(studio, truth(Truth::Displacement, samples), sigma)?;
            let mapped = mean(studio, leadr(Shadowing::NormalMap, false), sigma)?;
            let displaced = mean(studio, leadr(Shadowing::None, true), sigma)?;
            let as_relief = mean(studio, leadr(Shadowing::None, false), sigma)?;
            let error = |truth: &Shot, shot: &Shot| judge(truth, shot, 0.8).map(|v| v.interior.rrmse).map_err(fault);
            let errors = [
                error(&mapped_truth, &mapped)?,
                error(&displaced_truth, &displaced)?,
                error(&mapped_truth, &as_relief)?,
            ];
            let name = |what: &str| format!("normals-{}-{sigma}-{what}", lighting_name(lighting)).replace('.', "_");
            let picture = [
                studio.picture(&name("truth"), &mapped_truth.image, 0.8, "normal-map truth", Vec::new())?,
                studio.picture(&name("leadr"), &mapped.image, 0.8, "leadr", Vec::new())?,
            ];
            let [shown, found] = picture.map(Cell::Figure);
            table.row([
                Cell::from(format!("{sigma}")),
                shown,
                found,
                Cell::from(errors[0]),
                Cell::from(errors[1]),
                Cell::from(errors[2]),
                Cell::from(mapped_truth.noise),
            ]);
            let [normal_map, displacement, as_relief] = errors;
            studio.step();
            entries.push(Entry::Sphere { light: lighting_name(lighting), sigma, normal_map, displacement, as_relief });
        }
        let worst = entries.iter().rev().take(sigmas.len()).map(|entry| match entry {
            Entry::Sphere { normal_map, as_relief, .. } => (*normal_map, *as_relief),
            Entry::Both { .. } => (0.0, 0.0),
        });
        let (mapped, relief) = worst.fold((0.0f64, 0.0f64), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        findings.push(format!(
            "Normal maps, {title}: at most {} from supersampled normal mapping; filtered as a displaced surface up to {}.",
            number(mapped),
            number(relief)
        ));
        html.table(&table);
    }
    Ok(())
}

fn lighting_name(lighting: Lighting) -> &'static str {
    match lighting {
        Lighting::Front => "front",
        Lighting::Irradiance => "irradiance",
        Lighting::Environment => "environment",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_resolution_heights_lose_only_fine_slopes() {
        let full = full_heights();
        let coarse = coarse_heights(&full);
        let power = |field: &HeightField| slopes(field).iter().map(|s| f64::from(s[0] * s[0])).sum::<f64>();
        let mean = |field: &HeightField| field.map.texels.iter().map(|&h| f64::from(h)).sum::<f64>();
        let kept = power(&coarse) / power(&full);
        assert!((0.4..0.95).contains(&kept), "{kept}");
        assert!((mean(&coarse) - mean(&full)).abs() < 1e-3 * f64::from(FULL * FULL) * 0.01);
    }
}
