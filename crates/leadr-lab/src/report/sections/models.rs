//! Checks displaced third-party models for cracks.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::cracks::{self, Cracks, DISTANCES, Search};
use crate::report::section::Section;
use crate::report::studio::Studio;
use leadr_models::{LoadOptions, Model};
use leadr_scenes::model::{ModelChoice, stage};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table};

const INTRO: &str = "Every glTF model of the shared data gets a rough height map on all materials, is posed in the middle of its first \
    animation, and is seen from all around at three distances. Where the undisplaced surface covers everything that bumps can move into a \
    pixel, the displaced surface must cover the pixel. A deeper pixel is a crack, unless bumps at an outline may have uncovered a gap \
    between two parts. LEADR_SHARED is the folder of the models.";

/// The folders of the shared data that contain models.
const FOLDERS: [&str; 2] = ["creatures", "gltf"];

#[derive(Debug, Serialize)]
struct Row {
    file: String,
    triangles: usize,
    #[serde(flatten)]
    found: Cracks,
}

#[derive(Debug, Serialize)]
struct Models {
    views: u32,
    distances: [f32; 3],
    size: (u32, u32),
    rows: Vec<Row>,
    /// The names of files without triangles, and the reason for each.
    left_out: Vec<String>,
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let (views, size) = studio.pick((3, (96, 72)), (24, (256, 192)));
    let files = files();
    let mut models = Models { views, distances: DISTANCES, size, rows: Vec::new(), left_out: Vec::new() };
    studio.steps(files.len());
    for (name, file) in files {
        match searched(studio, &file, views, size)? {
            Ok((triangles, found)) => models.rows.push(Row { file: name, triangles, found }),
            Err(why) => models.left_out.push(format!("{name}: {why}")),
        }
        studio.step();
    }
    Section::new(INTRO, findings(&models), &shown(&models), &models)
}

/// Searches a file for cracks. Returns the result, or the reason why the file is skipped.
fn searched(
    studio: &Studio,
    file: &Path,
    views: u32,
    size: (u32, u32),
) -> Result<Result<(usize, Cracks), String>, LabError> {
    let model = match Model::load(file, LoadOptions::default()) {
        Ok(model) => cracks::roughened(model, None),
        Err(error) => return Ok(Err(error.to_string())),
    };
    let time = model.animations.first().map_or(0.0, |animation| 0.4 * f64::from(animation.duration));
    let made = ModelChoice::new(model, None).and_then(stage);
    let stage = match made {
        Ok(stage) => stage,
        Err(error) => return Ok(Err(error.to_string())),
    };
    let triangles = stage.objects.iter().filter(|o| o.mesh.triangles).map(|o| o.mesh.patches.len()).sum();
    let found = cracks::search(&studio.gpu, stage, Search { views, size, time })?;
    Ok(Ok((triangles, found)))
}

/// Returns the models of the shared data with their relative names, in sorted order.
fn files() -> Vec<(String, PathBuf)> {
    let Some(data) = std::env::var_os("LEADR_SHARED").map(|root| Path::new(&root).join("data")) else {
        return Vec::new();
    };
    let mut files = Vec::new();
    let mut folders: Vec<PathBuf> = FOLDERS.iter().map(|folder| data.join(folder)).collect();
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(&folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path())) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf") {
                let name = path.strip_prefix(&data).unwrap_or(&path).to_string_lossy().into_owned();
                files.push((name, path));
            }
        }
    }
    files.sort();
    files
}

fn findings(models: &Models) -> Vec<String> {
    if models.rows.is_empty() {
        return vec!["No model was searched: LEADR_SHARED has none.".into()];
    }
    let (views, distances) = (models.views, models.distances.len());
    let at_outlines: usize = models.rows.iter().map(|row| row.found.at_outlines).sum();
    let cracks = models.rows.iter().map(|row| row.found.cracks).sum::<usize>() - at_outlines;
    let searched: usize = models.rows.iter().map(|row| row.found.searched).sum();
    let torn = models.rows.iter().filter(|row| row.found.cracks > row.found.at_outlines).count();
    let count = models.rows.len();
    let mut findings = vec![format!(
        "Goal 0: {cracks} cracks among {searched} pixels of {count} models from {views} views at {distances} distances; {torn} models \
         have any. {at_outlines} more pixels at outlines and on steep surfaces show deeper surfaces; gaps between separate parts look the \
         same."
    )];
    if !models.left_out.is_empty() {
        findings.push(format!("{} files without triangles were left out.", models.left_out.len()));
    }
    findings
}

fn shown(models: &Models) -> Html {
    let mut html = Html::new();
    let (width, height) = models.size;
    let title = format!("{} views at {} distances, {width} x {height} pixels", models.views, models.distances.len());
    let mut table = Table::new(title, ["model", "triangles", "pixels searched", "cracks", "at outlines"]);
    for Row { file, triangles, found } in &models.rows {
        let cracks = found.cracks - found.at_outlines;
        let numbers =
            [*triangles, found.searched, cracks, found.at_outlines].map(|count| Cell::from(count.to_string()));
        table.row(std::iter::once(Cell::from(file.as_str())).chain(numbers));
    }
    html.table(&table);
    for why in &models.left_out {
        html.paragraph(why);
    }
    html
}
