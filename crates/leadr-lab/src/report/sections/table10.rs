//! Measures how many slope samples are required (table 10 of the LEADR supplement).

use glam::Vec2;
use serde::Serialize;

use crate::report::configuration::Configuration;
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::verdict::{Shot, judge};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::settings::{Probes, RenderSettings, Terms};
use leadr_scenes::spheres::cell::Lighting;
use leadr_scenes::spheres::surface::{Detail, Frequency, Surface};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Figure, Html, Table, number};
use leadr_tools::html::{Plot, Scale};

const INTRO: &str = "Mirror facets in the studio at several roughnesses: the paper's grids of increasing size and the visible-slope rules \
    with few probes, all compared with the 128×128 grid on the same surface. The error is that of the quadrature alone: relative RMSE \
    inside the silhouette.";

const EXPOSURE: f32 = 0.8;

#[derive(Debug, Serialize)]
struct Entry {
    sigma: [f32; 2],
    look: String,
    /// The number of environment lookups per pixel.
    fetches: u32,
    rrmse: f64,
    flip: f64,
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let sigmas: &[[f32; 2]] = if studio.quick {
        &[[0.25, 0.25], [1.0, 1.0]]
    } else {
        &[[0.05, 0.05], [0.25, 0.25], [0.5, 0.5], [1.0, 1.0], [0.05, 0.2], [0.2, 0.8]]
    };
    let grids: &[u32] = if studio.quick { &[1, 3, 5, 9, 32] } else { &[1, 2, 3, 5, 7, 9, 16, 32, 64] };
    let configs: Vec<(Configuration, u32)> = grids
        .iter()
        .map(|&n| (Configuration::grid(n), n * n))
        .chain(Probes::ALL.iter().map(|&probes| (Configuration::visible(probes), probes.count())))
        .collect();
    let (mut html, mut entries) = (Html::new(), Vec::new());
    for &sigma in sigmas {
        let (shown, made) = roughness(studio, sigma, &configs)?;
        html.heading(&name_of(sigma));
        html.append(&shown);
        entries.extend(made);
    }
    html.table(&table(sigmas, &configs, &entries));
    let findings = findings(&entries);
    Section::new(INTRO, findings, &html, &entries)
}

fn name_of(sigma: [f32; 2]) -> String {
    if sigma[0] == sigma[1] { format!("σ {}", sigma[0]) } else { format!("σ {}, {}", sigma[0], sigma[1]) }
}

/// Renders the pictures for one roughness, and returns its plot and numbers.
fn roughness(
    studio: &mut Studio,
    sigma: [f32; 2],
    configs: &[(Configuration, u32)],
) -> Result<(Html, Vec<Entry>), LabError> {
    let size = studio.pick(64, 128);
    let detail = studio.pick(Detail { patches: 8, tile: 32 }, Detail::PICTURE);
    let light = Lighting::Environment;
    let slopes = Vec2::from_array(sigma);
    let stage = Surface::bake(slopes, Frequency::High, detail).stage(slopes.max_element(), light.facets());
    let mut subject = Subject::in_panorama(studio, stage, &light.panorama(), light.lights())?;
    let state = subject.seen_by(&subject.stage.views.mid);
    let mut shoot = |config: &Configuration| -> Result<Shot, LabError> {
        let config = config.clone().with(Terms::SPECULAR_ENVIRONMENT, Shadowing::None);
        let settings = RenderSettings { shadows: false, ..config.settings((size, size), 1) };
        studio.shoot(&mut subject.renderer, &state, &settings)
    };
    let best = shoot(&Configuration::grid(128))?;
    let shots: Vec<Shot> = configs.iter().map(|(config, _)| shoot(config)).collect::<Result<_, _>>()?;
    let key = format!("{}-{}", sigma[0], sigma[1]).replace('.', "_");
    let caption = vec!["128×128".to_owned()];
    let mut figures: Vec<Figure> =
        vec![studio.picture(&format!("table10-{key}-best"), &best.image, EXPOSURE, "128×128", caption)?];
    let (mut entries, mut lines) = (Vec::new(), [Vec::new(), Vec::new()]);
    for ((config, fetches), shot) in configs.iter().zip(&shots) {
        let errors = judge(&best, shot, EXPOSURE).map_err(fault)?.interior;
        let is_grid = config.is_grid();
        lines[usize::from(!is_grid)].push((f64::from(*fetches), errors.rrmse));
        let caption = vec![config.name.replace("leadr ", ""), format!("rRMSE {}", number(errors.rrmse))];
        let file = format!("table10-{key}-{}", config.file());
        figures.push(studio.picture(&file, &shot.image, EXPOSURE, &config.name, caption)?);
        let (rrmse, flip) = (errors.rrmse, errors.flip);
        entries.push(Entry { sigma, look: config.name.clone(), fetches: *fetches, rrmse, flip });
    }
    let mut plot = Plot::new(
        &format!("{}: error against lookups", name_of(sigma)),
        ("lookups in the environment per pixel", Scale::Log),
        ("relative RMSE inside", Scale::Log),
    );
    let [grid, line] = lines;
    plot.line("the paper's grid", grid);
    plot.line("few probes", line);
    let mut html = Html::new();
    html.figures(&figures);
    html.plot(&plot);
    Ok((html, entries))
}

fn table(sigmas: &[[f32; 2]], configs: &[(Configuration, u32)], entries: &[Entry]) -> Table {
    let head = ["rule".to_owned(), "lookups".to_owned()].into_iter().chain(sigmas.iter().map(|&s| name_of(s)));
    let mut table = Table::new("Relative RMSE inside against 128×128", head);
    for (config, fetches) in configs {
        let numbers = sigmas.iter().map(|&sigma| {
            let found = entries.iter().find(|e| e.sigma == sigma && e.look == config.name);
            Cell::from(found.map_or(f64::NAN, |e| e.rrmse))
        });
        let head = [Cell::from(config.name.as_str()), Cell::from(fetches.to_string())];
        table.row(head.into_iter().chain(numbers));
    }
    table
}

/// Returns findings about the RMS error over all roughnesses, for few probes and for the paper's 5×5 grid.
fn findings(entries: &[Entry]) -> Vec<String> {
    let rms = |look: &str| {
        let of: Vec<f64> = entries.iter().filter(|e| e.look == look).map(|e| e.rrmse).collect();
        (of.iter().map(|e| e * e).sum::<f64>() / of.len().max(1) as f64).sqrt()
    };
    let paper = rms("leadr 5×5");
    let line = |n: u32| {
        let rule = rms(&format!("leadr visible {n}"));
        format!(
            "{n} probes have {} times the error of the paper's 5×5 (RMS over roughnesses: {} against {}).",
            number(rule / paper),
            number(rule),
            number(paper)
        )
    };
    [5, 9, 16].map(line).to_vec()
}
