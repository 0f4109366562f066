//! Draws one view with maps of falling resolution, whose finest levels are left out of their files.

use glam::Vec3;
use serde::Serialize;

use super::precision::{Baked, baked};
use crate::report::configuration::Configuration;
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::{Shot, judge};
use leadr_maps::bake::{Inputs, Kind, Layout, Plan, Precision};
use leadr_maps::material::{Input, Material, RoughnessMeaning};
use leadr_maps::{HeightMap, LeadrMap, Wrap, procedural};
use leadr_reflectance::facets::metals::Metal;
use leadr_render::camera::Camera;
use leadr_render::light::sky::Sky;
use leadr_render::settings::{RenderSettings, Technique};
use leadr_scenes::dressed::plane_stage;
use leadr_tools::error::LabError;
use leadr_tools::fit::specimen::{Lacquer, dressed};
use leadr_tools::html::{Cell, Html, Table, number};

const INTRO: &str = "One view of a plane, with maps of falling resolution (the thesis' Figures 5.3 to 5.5). The file of each map \
    begins at a coarser level (leadr bake --drop-levels). One sample of LEADR uses the moments of this level; mips of normals use \
    its mean slopes alone. Both are compared with the supersampled picture of the map at full resolution, pixel by pixel and in \
    blocks of pixels, which show the appearance without the lost details. The metal is nickel, with its measured indices of refraction. \
    All pictures lack shadows between bumps.";

/// The number of pixels along a block.
const BLOCK: u32 = 8;
/// The roughness of the metal. It is smooth, so that the slopes of the relief dominate.
const METAL_ALPHA: f32 = 0.1;
/// The distance of the camera in metres, half a repeat of the maps, and its field of view in degrees.
const DISTANCE: f32 = 1.0;
const FIELD: f32 = 50.0;

/// The mean luminance of the truth as shown.
pub(super) const MEAN_SHOWN: f64 = 0.3;

/// The reliefs, each with the RMS of its slopes.
const RELIEFS: [(&str, f64); 2] = [("scratched", 0.15), ("rugged", 0.25)];

const FORMS: [(&str, Technique); 2] = [("moments", Technique::Leadr), ("mips of normals", Technique::NormalMip)];

#[derive(Serialize)]
struct Row {
    material: &'static str,
    relief: &'static str,
    form: &'static str,
    dropped_levels: usize,
    texels: u32,
    bytes: u64,
    rrmse: f64,
    /// The error of the means over blocks of pixels.
    rrmse_of_blocks: f64,
    bias: f64,
    flip: f64,
    /// The noise of the truth's block means.
    noise: f64,
}

/// Generates heights whose slopes have this RMS along each axis.
fn relief((kind, slope): (&str, f64), side: u32) -> HeightMap {
    let map = match kind {
        "scratched" => procedural::scratches(side, side, 3, 400),
        _ => procedural::gaussian(side, side, 5, 1.0, 2.0 / side as f32),
    };
    let [xx, yy, _] = LeadrMap::new(&map, Wrap::Repeat).mean().slope_covariance();
    let factor = (slope / (0.5 * (xx + yy)).sqrt()) as f32;
    HeightMap { texels: map.texels.iter().map(|height| factor * height).collect(), ..map }
}

/// Returns the materials without relief.
fn materials() -> Result<[(&'static str, Material); 2], LabError> {
    let metal = Metal::named("nickel").ok_or_else(|| LabError("there is no nickel".to_owned()))?;
    let metal = Material {
        base_color: Input::constant(metal.f0().as_vec3().to_array()),
        metalness: Input::constant(1.0),
        edge_tint: metal.edge_tint().as_vec3().to_array(),
        roughness: Input::constant(METAL_ALPHA),
        roughness_meaning: RoughnessMeaning::Alpha,
        ..Material::new("metal")
    };
    let lacquer = Lacquer::fit().ok_or_else(|| LabError("the lacquer was not fitted".to_owned()))?;
    let flat = HeightMap::new(1, 1, vec![0.0]).map_err(fault)?;
    Ok([("metal", metal), ("lacquer", dressed(&lacquer, "lacquer", flat, 1.0))])
}

/// Bakes heights into a file without its finest levels.
fn reduced(map: &HeightMap, dropped_levels: usize) -> Result<Baked, LabError> {
    let inputs = Inputs { heights: Some(map.clone()), height_scale: Some(1.0), ..Inputs::default() };
    let plan = Plan::new(&inputs, Kind::Leadr, Layout::Leadr, Precision::F16);
    baked(&inputs, &plan.and_then(|plan| plan.without_levels(dropped_levels)).map_err(fault)?)
}

/// Covers a plane with a material and the relief of a file.
fn subject(studio: &Studio, material: &Material, file: &Baked) -> Result<Subject, LabError> {
    let Material { relief, slope_moments, .. } = Material::of_baked(&file.map).map_err(fault)?;
    let material = Material { relief, slope_moments, ..material.clone() };
    Subject::under_the_sky(studio, plane_stage(&material, None), 0.0)
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let side = studio.pick(128, 512);
    let dropped: &[usize] = studio.pick(&[0, 2, 4], &[0, 1, 2, 3, 4, 5, 6]);
    let all = materials()?;
    studio.steps(all.len() * RELIEFS.len() * (1 + dropped.len()));
    let (mut html, mut rows, mut findings) = (Html::new(), Vec::new(), Vec::new());
    for (material, of_material) in &all {
        for kind in RELIEFS {
            let map = relief(kind, side);
            let files = dropped.iter().map(|&count| reduced(&map, count)).collect::<Result<Vec<_>, _>>()?;
            let of = measure(studio, (*material, of_material), kind.0, &files, &mut html)?;
            findings.push(finding(&of));
            rows.extend(of);
        }
    }
    Section::new(INTRO, findings, &html, &rows)
}

/// Compares the pictures of one relief with its truth. The first file has all levels.
fn measure(
    studio: &mut Studio,
    (material, of_material): (&'static str, &Material),
    relief: &'static str,
    files: &[Baked],
    html: &mut Html,
) -> Result<Vec<Row>, LabError> {
    let size = studio.pick((48, 32), (192, 128));
    let samples = studio.pick(16, 128);
    let mut whole = subject(studio, of_material, &files[0])?;
    // The camera sees the reflection of the sun, whose size follows from the slopes.
    let sun = Sky::default().sun_direction.normalize();
    let camera = Camera::looking_at(DISTANCE * Vec3::new(-sun.x, -sun.y, sun.z), Vec3::ZERO, FIELD);
    let state = whole.seen_by(&camera);
    let truth = studio.shoot_truth(&mut whole.renderer, &state, &Truth::Displacement.settings(size, samples, 1))?;
    studio.step();
    let blocks = truth.of_blocks(BLOCK).map_err(fault)?;
    let exposure = (MEAN_SHOWN / truth.luminance(&truth.object().map_err(fault)?)) as f32;
    let mut table = Table::new(
        format!(
            "{material}, {relief}: {} pixels across; truth of {samples} samples, its noise {}, in blocks {}",
            size.0,
            number(truth.noise),
            number(blocks.noise)
        ),
        ["texels", "bytes", "moments", "mips of normals"],
    );
    let figure = studio.picture(
        &format!("resolution-{material}-{relief}-truth"),
        &truth.image,
        exposure,
        "truth",
        Vec::new(),
    )?;
    table.row([Cell::from("truth"), Cell::from("–"), Cell::Figure(figure)]);
    let mut rows = Vec::new();
    for file in files {
        let mut seen = subject(studio, of_material, file)?;
        let (texels, dropped_levels) = (file.map.levels[0].width, file.map.dropped_levels as usize);
        let mut cells = vec![Cell::from(texels.to_string()), Cell::from(file.bytes.to_string())];
        for (form, technique) in FORMS {
            let settings: RenderSettings = Configuration::of(technique).settings(size, 1);
            let shot: Shot = studio.shoot(&mut seen.renderer, &state, &settings)?;
            let errors = judge(&truth, &shot, exposure).map_err(fault)?.object;
            let of_blocks = judge(&blocks, &shot.of_blocks(BLOCK).map_err(fault)?, exposure).map_err(fault)?.object;
            let caption = vec![
                format!("rRMSE {}, in blocks {}", number(errors.rrmse), number(of_blocks.rrmse)),
                format!("bias {}, FLIP {}", number(errors.bias), number(errors.flip)),
            ];
            let picture = format!("resolution-{material}-{relief}-{texels}-{}", form.replace(' ', "-"));
            cells.push(Cell::Figure(studio.picture(&picture, &shot.image, exposure, form, caption)?));
            rows.push(Row {
                material,
                relief,
                form,
                dropped_levels,
                texels,
                bytes: file.bytes,
                rrmse: errors.rrmse,
                rrmse_of_blocks: of_blocks.rrmse,
                bias: errors.bias,
                flip: errors.flip,
                noise: blocks.noise,
            });
        }
        table.row(cells);
        studio.step();
    }
    html.table(&table);
    Ok(rows)
}

/// Compares the finest and the coarsest map of one relief.
fn finding(rows: &[Row]) -> String {
    let of = |form: &str| {
        let mut of_form = rows.iter().filter(|row| row.form == form);
        let first = of_form.next().expect("each relief has a row of each form");
        let last = of_form.next_back().unwrap_or(first);
        (first, last)
    };
    let ((first, last), (naive_first, naive_last)) = (of(FORMS[0].0), of(FORMS[1].0));
    format!(
        "{}, {}: from {} to {} texels along a side ({} to {} bytes), the error of blocks goes from {} to {} with moments, and from {} \
         to {} with mips of normals; the bias of the coarsest map is {} and {}.",
        first.material,
        first.relief,
        first.texels,
        last.texels,
        first.bytes,
        last.bytes,
        number(first.rrmse_of_blocks),
        number(last.rrmse_of_blocks),
        number(naive_first.rrmse_of_blocks),
        number(naive_last.rrmse_of_blocks),
        number(last.bias),
        number(naive_last.bias)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_get_smaller_and_keep_the_slopes() {
        for (name, slope) in RELIEFS {
            let map = relief((name, slope), 128);
            let [whole, coarse] = [0, 3].map(|dropped| reduced(&map, dropped).unwrap());
            assert!(coarse.bytes * 32 < whole.bytes, "{} {}", coarse.bytes, whole.bytes);
            let last = |file: &Baked| file.map.moments().unwrap().mean();
            assert_eq!(last(&whole), last(&coarse));
            let [xx, yy, _] = last(&coarse).slope_covariance();
            assert!(((0.5 * (xx + yy)).sqrt() / slope - 1.0).abs() < 1e-2, "{name}: {xx} {yy}");
        }
    }
}
