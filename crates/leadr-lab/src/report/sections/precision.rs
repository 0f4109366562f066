//! Measures picture errors when slopes are stored in 16 bits or in compressed blocks.

use serde::Serialize;

use crate::report::configuration::Configuration;
use crate::report::outside::reliefs::relief;
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use leadr_maps::bake::{Inputs, Kind, Ktx2File, Layout, LevelError, Plan, Precision, bake};
use leadr_maps::baked::BakedMap;
use leadr_maps::{HeightMap, RgbImage, procedural};
use leadr_render::surfaces::moments::MomentFormat;
use leadr_scenes::stage::{
    BakedRelief, GENERATED_HEIGHT, ReliefOptions, Stage, USUAL_RELIEF, plane_stage, sphere_stage,
};
use leadr_scenes::trex::stage::trex_stage;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};
use leadr_tools::metrics::compare::rrmse;

const INTRO: &str = "One sample of leadr at its default settings under the sky, with map slopes in 32 bits, in 16 bits on the device \
    (--map-precision f16), from a 16-bit file, and from a block-compressed one (leadr bake --format f16, bc). Errors are relative RMSE \
    against 32 bits. Scanned height maps are drawn if LEADR_SHARED contains them.";

/// The largest acceptable picture error for slopes in 16 bits.
const MOST_F16: f64 = 1e-3;
const MOST_BC: f64 = 1e-2;

#[derive(Clone, Debug, Serialize)]
struct Measured {
    scene: String,
    view: &'static str,
    on_device: f64,
    /// The error with moments from a 16-bit file, for planes only.
    f16_file: Option<f64>,
    bc_file: Option<f64>,
}

#[derive(Clone, Debug, Serialize)]
struct Sizes {
    map: String,
    /// The number of bytes of all levels per texel of the finest level.
    f32: f64,
    f16: f64,
    bc: f64,
    /// The largest variance error on any level.
    f16_variance: f64,
    bc_variance: f64,
}

#[derive(Clone, Debug, Serialize)]
struct Data {
    pictures: Vec<Measured>,
    files: Vec<Sizes>,
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let maps = maps(studio.quick)?;
    studio.steps(maps.len() + 1);
    let (mut pictures, mut files) = (Vec::new(), Vec::new());
    for (name, map, scale) in &maps {
        let inputs = Inputs { heights: Some(map.clone()), ..Inputs::default() };
        let found = [Precision::F32, Precision::F16, Precision::Bc].map(|precision| {
            let plan = Plan::new(&inputs, Kind::Leadr, Layout::Leadr, precision).map_err(fault)?;
            baked(&inputs, &plan)
        });
        let [exact, f16, bc] =
            found.into_iter().collect::<Result<Vec<_>, _>>()?.try_into().map_err(|_| fault_of_count())?;
        let texels = map.texels.len() as f64;
        let worst = |baked: &Baked| baked.variance;
        files.push(Sizes {
            map: name.clone(),
            f32: exact.bytes as f64 / texels,
            f16: f16.bytes as f64 / texels,
            bc: bc.bytes as f64 / texels,
            f16_variance: worst(&f16),
            bc_variance: worst(&bc),
        });
        let stage = |baked: Option<BakedMap>| {
            let baked = baked.and_then(BakedMap::into_moments).map(|moments| BakedRelief {
                moments,
                classes: None,
                in_widths: false,
                is_reduced: false,
            });
            let relief = ReliefOptions { map: Some(map.clone()), baked, ..ReliefOptions::default() };
            plane_stage(ReliefOptions { height: Some(scale * USUAL_RELIEF), ..relief })
        };
        let shots = [
            shoot(studio, stage(None), MomentFormat::Float32, 0.0)?,
            shoot(studio, stage(None), MomentFormat::Float16, 0.0)?,
            shoot(studio, stage(Some(f16.map)), MomentFormat::Float16, 0.0)?,
            shoot(studio, stage(Some(bc.map)), MomentFormat::Float32, 0.0)?,
        ];
        pictures.extend(measure(&format!("plane, {name}"), &shots)?);
        studio.step();
    }
    let tile = studio.pick(16, 64);
    let sphere = |studio: &Studio, format| {
        shoot(studio, sphere_stage(ReliefOptions { tile, ..ReliefOptions::default() }), format, 0.0)
    };
    let shots = [sphere(studio, MomentFormat::Float32)?, sphere(studio, MomentFormat::Float16)?];
    pictures.extend(measure("sphere", &shots)?);
    if !studio.quick {
        let trex = |studio: &Studio, format| {
            let stage = trex_stage(tile, &|_| {}).map_err(|e| LabError(e.to_string()))?;
            shoot(studio, stage, format, 0.4)
        };
        let shots = [trex(studio, MomentFormat::Float32)?, trex(studio, MomentFormat::Float16)?];
        pictures.extend(measure("T-rex", &shots)?);
    }
    studio.step();
    let mut table = Table::new(
        "rRMSE of pictures against 32 bits",
        ["scene", "view", "f16 on the device", "f16 file", "block-compressed file"],
    );
    for row in &pictures {
        let file = |error: Option<f64>| error.map_or(Cell::from("–"), Cell::from);
        let [f16, bc] = [row.f16_file, row.bc_file].map(file);
        table.row([Cell::from(row.scene.as_str()), row.view.into(), row.on_device.into(), f16, bc]);
    }
    let mut sizes = Table::new(
        "File bytes per texel of the finest level, and the error of the variance",
        ["map", "f32", "f16", "bc", "variance, f16", "variance, bc"],
    );
    for row in &files {
        let numbers = [row.f32, row.f16, row.bc, row.f16_variance, row.bc_variance].map(Cell::from);
        sizes.row(std::iter::once(Cell::from(row.map.as_str())).chain(numbers));
    }
    let mut html = Html::new();
    html.table(&table);
    html.table(&sizes);
    let findings = findings(&pictures, &files);
    Section::new(INTRO, findings, &html, Data { pictures, files })
}

fn fault_of_count() -> LabError {
    LabError("a map was not baked".to_owned())
}

/// Returns height maps by name, each with a height factor.
fn maps(quick: bool) -> Result<Vec<(String, HeightMap, f32)>, LabError> {
    let side = if quick { 128 } else { 1024 };
    let mut maps = vec![("rock".to_owned(), procedural::rock(side, side, 1), GENERATED_HEIGHT)];
    for (name, title) in
        [("studs", "studs"), ("rock", "scanned rock"), ("walkway", "scanned walkway"), ("leather", "scanned leather")]
    {
        if quick && name != "studs" {
            continue;
        }
        if let Some(map) = relief(name).map_err(|e| LabError(e.to_string()))? {
            maps.push((title.to_owned(), map, 1.0));
        }
    }
    Ok(maps)
}

/// A map that was written to a file and read back.
pub(super) struct Baked {
    pub map: BakedMap,
    /// The number of bytes of the file.
    pub bytes: u64,
    /// The largest error of the classes of facets on any level.
    pub classes: f64,
    /// The largest variance error on any level.
    variance: f64,
}

/// Bakes a map into a temporary file, and reads the file.
pub(super) fn baked(inputs: &Inputs, plan: &Plan) -> Result<Baked, LabError> {
    let path = std::env::temp_dir().join(format!("leadr-report-{}.ktx2", std::process::id()));
    let made = (|| {
        let mut file = std::fs::File::create(&path).map_err(|e| LabError::io("make the file", &path, e))?;
        let mut target = Ktx2File::new(&mut file, plan).map_err(fault)?;
        let report = bake(inputs, plan, &mut target, &|_| ()).map_err(fault)?;
        target.finish(&report).map_err(fault)?;
        let bytes = file.metadata().map_err(|e| LabError::io("read the file", &path, e))?.len();
        let map = BakedMap::load(&path).map_err(|e| LabError(e.to_string()))?;
        let largest = |of: fn(&LevelError) -> f64| report.errors.iter().map(of).fold(0.0, f64::max);
        Ok(Baked { map, bytes, classes: largest(|e| e.classes), variance: largest(|e| e.variance) })
    })();
    // Errors are ignored, because the file is no longer needed.
    let _ = std::fs::remove_file(&path);
    made
}

const VIEWS: [&str; 3] = ["near", "mid", "far"];

fn shoot(studio: &Studio, stage: Stage, format: MomentFormat, time: f64) -> Result<Vec<RgbImage>, LabError> {
    let views = stage.views;
    let mut subject = Subject::kept_in(format, studio, stage, time)?;
    let settings = Configuration::program_default().settings(studio.pick((80, 60), (320, 240)), 1);
    let cameras = [views.near, views.mid, views.far];
    let shots = cameras.iter().map(|camera| {
        let state = subject.seen_by(camera);
        Ok(studio.shoot(&mut subject.renderer, &state, &settings)?.image)
    });
    shots.collect()
}

/// Computes picture errors of every view. `shots` has the pictures of moments in 32 bits, in 16 bits on the device, from a
/// 16-bit file and in blocks, in this order.
fn measure(scene: &str, shots: &[Vec<RgbImage>]) -> Result<Vec<Measured>, LabError> {
    let error = |shot: Option<&Vec<RgbImage>>, view: usize| {
        shot.map(|shot| rrmse(&shots[0][view], &shot[view]).map_err(fault)).transpose()
    };
    let rows = VIEWS.into_iter().enumerate().map(|(view, name)| {
        Ok(Measured {
            scene: scene.to_owned(),
            view: name,
            on_device: error(shots.get(1), view)?.unwrap_or_default(),
            f16_file: error(shots.get(2), view)?,
            bc_file: error(shots.get(3), view)?,
        })
    });
    rows.collect()
}

fn findings(pictures: &[Measured], files: &[Sizes]) -> Vec<String> {
    let worst = |of: &dyn Fn(&Measured) -> Option<f64>| {
        let found = pictures.iter().filter_map(|m| Some((of(m)?, m)));
        found.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let sentence = |what: &str, found: Option<(f64, &Measured)>, goal: f64| {
        let (error, at) = found?;
        let kept = if error <= goal { "kept" } else { "missed" };
        Some(format!(
            "{what}: rRMSE of at most {} against 32 bits ({}, {}); the goal of {} is {kept}.",
            number(error),
            at.scene,
            at.view,
            number(goal)
        ))
    };
    let mut findings: Vec<String> = [
        sentence("16 bits on the device", worst(&|m| Some(m.on_device)), MOST_F16),
        sentence("Files of 16 bits", worst(&|m| m.f16_file), MOST_F16),
        sentence("Block-compressed files", worst(&|m| m.bc_file), MOST_BC),
    ]
    .into_iter()
    .flatten()
    .collect();
    if let Some(size) = files.first() {
        findings.push(format!(
            "A texel takes {} file bytes in 32 bits, {} in 16, {} in blocks.",
            number(size.f32),
            number(size.f16),
            number(size.bc)
        ));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_kept_and_missed() {
        let measured = |error: f64| Measured {
            scene: "plane".to_owned(),
            view: "mid",
            on_device: error,
            f16_file: None,
            bc_file: Some(0.5 * error),
        };
        let message = findings(&[measured(5e-4), measured(4e-4)], &[]);
        assert!(message.len() == 2 && message.iter().all(|s| s.ends_with("is kept.")), "{message:?}");
        let message = findings(&[measured(5e-4), measured(4e-2)], &[]);
        assert!(message.iter().all(|s| s.ends_with("is missed.")), "{message:?}");
    }
}
