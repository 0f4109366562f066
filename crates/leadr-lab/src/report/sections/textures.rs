//! Compares filters of normal maps on scanned surfaces at several distances, by error, flicker, memory and time.

use glam::Vec3;
use serde::Serialize;

use crate::report::section::Section;
use crate::report::shared::shared;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::Shot;
use leadr_maps::folders::OutsideLinks;
use leadr_maps::material::{Material, MaterialFolder};
use leadr_maps::shown::shown_path;
use leadr_maps::{HeightMap, RgbImage, procedural};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::camera::Camera;
use leadr_render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr_render::surfaces::tessellation::TessellationSettings;
use leadr_scenes::dressed::plane_stage;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};
use leadr_tools::metrics::Mask;
use leadr_tools::metrics::compare::{bias_over, rrmse_over};
use leadr_tools::metrics::flicker::{difference, magnitude};

const INTRO: &str = "A plane under the sky and its sun as a normal map in each material of LEADR_SHARED/displacement, or in two generated \
    ones. The geometry is smooth; slopes come from the normals, or from the heights if there are none. Every filter draws one sample per \
    pixel at several distances and is compared with the supersampled normal map with its own base. The base is GGX for shortened normals \
    (Chan 2018) and for LEADR's two lobes, and Beckmann for all others, whose Blinn-Phong lobe has the same peak. Flicker is the change \
    between two pictures with cameras a third of a pixel apart, beyond the truth's change, relative to the mean of the truth. Bytes are \
    those of the finest level that a filter reads instead of plain normals and roughness, as 16-bit floats and, if the baker has them, as \
    compressed blocks. Times are device milliseconds for these pictures.";

/// The compared techniques, each with its bytes per texel in 16-bit floats and in blocks.
const FILTERS: [(Technique, f64, Option<f64>); 8] = [
    // The filter stores two channels of normals (BC5 in blocks) and one channel of roughness (BC4 in blocks).
    (Technique::NormalMip, 6.0, Some(1.5)),
    (Technique::Toksvig, 8.0, None),
    (Technique::Gloss, 6.0, Some(1.5)),
    (Technique::Clean, 8.0, None),
    (Technique::CleanConservative, 8.0, None),
    (Technique::Lean, 12.0, None),
    (Technique::Leadr, 12.0, Some(9.0)),
    (Technique::LeadrGgx, 12.0, Some(9.0)),
];

/// The camera distances from the plane in metres.
const DISTANCES: [f32; 5] = [1.0, 2.5, 6.0, 12.0, 24.0];
const FIELD: f32 = 10.0;

#[derive(Clone, Serialize)]
struct Row {
    surface: String,
    distance: f32,
    filter: &'static str,
    rrmse: f64,
    bias: f64,
    flicker: f64,
    noise: f64,
    milliseconds: f64,
}

/// Returns the surfaces with their names.
fn surfaces(studio: &Studio) -> Result<Vec<(String, Material)>, LabError> {
    let Some(folder) = shared("displacement") else {
        let relief = |map: HeightMap, name: &str, alpha: f32| {
            let mut material = Material::new(name);
            material.roughness = leadr_maps::material::Input::constant(alpha.sqrt());
            let middle = map.mean();
            material.relief = Some(leadr_maps::material::Relief { map, scale: Some(1.0), in_widths: false, middle });
            (name.to_owned(), material)
        };
        let side = studio.pick(128, 512);
        return Ok(vec![
            relief(procedural::gaussian(side, side, 4, 0.4, 0.02), "bumps", 0.2),
            relief(procedural::scratches(side, side, 3, 300), "scratches", 0.1),
        ]);
    };
    let entries = std::fs::read_dir(&folder).map_err(|e| LabError(format!("{}: {e}", shown_path(folder))))?;
    let mut folders: Vec<_> = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    folders.sort();
    folders.truncate(studio.pick(1, usize::MAX));
    let read = |path: std::path::PathBuf| {
        let material = MaterialFolder::open(&path, OutsideLinks::Refused)?.load()?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok((name, material))
    };
    folders.into_iter().map(read).collect()
}

/// Returns an oblique camera at `distance`, shifted along the picture by `moved` picture widths.
fn camera(distance: f32, moved: f32) -> Camera {
    let width = 2.0 * distance * (0.5 * FIELD.to_radians()).tan();
    let target = Vec3::new(moved * width, 0.0, 0.0);
    Camera::looking_at(target + Vec3::new(0.0, -0.8, 0.6) * distance, target, FIELD)
}

fn filtered(technique: Technique, size: u32) -> RenderSettings {
    let mapped = |options: ShadingOptions| ShadingOptions { shadowing: Shadowing::NormalMap, ..options };
    RenderSettings {
        size: (size, size),
        displacement: false,
        shading: technique.with(mapped(ShadingOptions::default())),
        tessellation: TessellationSettings { to_texels: false, ..Default::default() },
        ..Default::default()
    }
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let (mut html, mut rows): (_, Vec<Row>) = (Html::new(), Vec::new());
    let size = studio.pick(24, 64);
    let samples = studio.pick(8, 64);
    let all = surfaces(studio)?;
    let names: Vec<String> = all.iter().map(|(name, _)| name.clone()).collect();
    studio.steps(all.len() * DISTANCES.len());
    for (surface, material) in all {
        let mut subject = Subject::under_the_sky(studio, plane_stage(&material, None), 0.0)?;
        let headings = ["distance", "truth"].into_iter().chain(FILTERS.iter().map(|(technique, ..)| technique.name()));
        let mut shown = Table::new(format!("{surface}: pictures, {size} pixels across"), headings.collect::<Vec<_>>());
        for distance in DISTANCES {
            let moved = 1.0 / (3.0 * size as f32);
            let mut shoot = |studio: &Studio, settings: &RenderSettings, truth: bool, moved: f32| {
                let state = subject.seen_by(&camera(distance, moved));
                if truth {
                    studio.shoot_truth(&mut subject.renderer, &state, settings)
                } else {
                    studio.shoot(&mut subject.renderer, &state, settings)
                }
            };
            let mut pair = |studio: &Studio, settings: RenderSettings, truth: bool| {
                Ok::<[Shot; 2], LabError>([
                    shoot(studio, &settings, truth, 0.0)?,
                    shoot(studio, &settings, truth, moved)?,
                ])
            };
            let mut truth_of = |studio: &Studio, technique: Technique| {
                let settings = Truth::NormalMap.settings_for(technique, (size, size), samples, 1);
                pair(studio, settings, true)
            };
            let truths = [truth_of(studio, Technique::Leadr)?, truth_of(studio, Technique::LeadrGgx)?];
            let name = |what: &str| format!("textures-{surface}-{distance}-{what}").replace('.', "_");
            let exposure = 0.8;
            let truth = studio.picture(&name("truth"), &truths[0][0].image, exposure, "truth", Vec::new())?;
            let mut cells = vec![Cell::from(format!("{distance} m")), Cell::Figure(truth)];
            let mask = Mask::all(size, size);
            for (technique, ..) in FILTERS {
                let [truth, moved_truth] = &truths[usize::from(technique.has_ggx_base())];
                let [shot, moved_shot] = pair(studio, filtered(technique, size), false)?;
                let rrmse = rrmse_over(&truth.image, &shot.image, &mask).map_err(fault)?;
                let bias = bias_over(&truth.image, &shot.image, &mask).map_err(fault)?;
                let change = |a: &Shot, b: &Shot| difference(&b.image, &a.image).map_err(fault);
                let beyond = difference(&change(&shot, &moved_shot)?, &change(truth, moved_truth)?).map_err(fault)?;
                let flicker = magnitude(&beyond, &mask).map_err(fault)?.rms / mean(&truth.image);
                let what = technique.name();
                let caption = vec![format!("rRMSE {}, flicker {}", number(rrmse), number(flicker))];
                cells.push(Cell::Figure(studio.picture(&name(what), &shot.image, exposure, what, caption)?));
                rows.push(Row {
                    surface: surface.clone(),
                    distance,
                    filter: what,
                    rrmse,
                    bias,
                    flicker,
                    noise: truth.noise,
                    milliseconds: shot.milliseconds.min(moved_shot.milliseconds),
                });
            }
            shown.row(cells);
            studio.step();
        }
        html.table(&shown);
    }
    let findings = findings(&rows, &names, &mut html);
    Section::new(INTRO, findings, &html, &rows)
}

/// Computes the mean over pixels and channels.
fn mean(image: &RgbImage) -> f64 {
    let values = image.texels.as_flattened();
    (values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64).max(1e-9)
}

/// Adds the table of all results to the page, and returns the findings.
fn findings(rows: &[Row], surfaces: &[String], html: &mut Html) -> Vec<String> {
    let of = |technique: Technique, keep: &dyn Fn(&Row) -> bool, value: fn(&Row) -> f64| {
        let values = rows.iter().filter(|row| row.filter == technique.name() && keep(row)).map(value);
        let (sum, count) = values.fold((0.0, 0usize), |(sum, count), v| (sum + v, count + 1));
        sum / count.max(1) as f64
    };
    let near = |row: &Row| row.distance <= DISTANCES[1];
    let far = |row: &Row| row.distance >= DISTANCES[3];
    let mut table = Table::new(
        "All surfaces: means",
        [
            "filter",
            "rRMSE near",
            "rRMSE far",
            "bias far",
            "flicker near",
            "flicker far",
            "bytes, halves",
            "bytes, blocks",
            "ms",
        ],
    );
    for (technique, halves, blocks) in FILTERS {
        table.row([
            Cell::from(technique.name()),
            Cell::from(of(technique, &near, |row| row.rrmse)),
            Cell::from(of(technique, &far, |row| row.rrmse)),
            Cell::from(of(technique, &far, |row| row.bias)),
            Cell::from(of(technique, &near, |row| row.flicker)),
            Cell::from(of(technique, &far, |row| row.flicker)),
            Cell::from(halves),
            blocks.map_or_else(|| Cell::from("–"), Cell::from),
            Cell::from(of(technique, &|_| true, |row| row.milliseconds)),
        ]);
    }
    html.table(&table);
    let mut by_surface = Table::new(
        "rRMSE, mean over all distances",
        std::iter::once("surface").chain(FILTERS.iter().map(|(technique, ..)| technique.name())).collect::<Vec<_>>(),
    );
    let mut findings = Vec::new();
    let mut not_worse = 0;
    for surface in surfaces {
        let here = |row: &Row| row.surface == *surface;
        let errors = FILTERS.map(|(technique, ..)| of(technique, &here, |row| row.rrmse));
        by_surface.row(std::iter::once(Cell::from(surface.as_str())).chain(errors.map(Cell::from)));
        let [gloss, toksvig] = [Technique::Gloss, Technique::Toksvig].map(|t| of(t, &here, |row| row.rrmse));
        not_worse += usize::from(gloss <= toksvig);
        let best =
            FILTERS.iter().zip(errors).min_by(|a, b| a.1.total_cmp(&b.1)).map(|((t, ..), error)| (t.name(), error));
        if let Some((best, error)) = best {
            findings.push(format!(
                "{surface}: the error of shortened normals is {}, of Toksvig {}; the smallest is {best} with {}.",
                number(gloss),
                number(toksvig),
                number(error)
            ));
        }
    }
    html.table(&by_surface);
    findings.push(format!(
        "Shortened normals have no larger error than Toksvig on {not_worse} of {} surfaces (goal: all).",
        surfaces.len()
    ));
    findings
}
