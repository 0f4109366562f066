//! Compares the rules for integrals over visible slopes with converged integrals, and measures how smooth the rules are in
//! slow sweeps.

use serde::Serialize;

use crate::quadrature_study::diffuse::DiffuseSet;
use crate::quadrature_study::light::LightSet;
use crate::quadrature_study::specular::{Sharpness, SpecularSet};
use crate::quadrature_study::sweep::{SweepRow, sweep_rows};
use crate::quadrature_study::{CLASSES, Row};
use crate::report::section::Section;
use crate::report::studio::Studio;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};
use leadr_tools::html::{Plot, Scale};

const INTRO: &str = "Every rule on random surfaces, viewers and environments against the converged integral of the same model (64-bit, on \
    the CPU). Errors measure only the quadrature. Errors of diffuse light are in units of the environment's mean radiance or of the \
    light's irradiance over π. Errors of specular light are relative to the true radiance, or to 1 if that is larger. Classes are by \
    the larger slope deviation σ. The bench's section lists the times of the rules.";

#[derive(Debug, Serialize)]
struct Study {
    name: &'static str,
    surfaces: usize,
    rows: Vec<Measured>,
}

#[derive(Clone, Debug, Serialize)]
struct Measured {
    rule: String,
    evaluations: u32,
    rms: f64,
    p95: f64,
    max: f64,
    classes: Vec<Option<f64>>,
}

impl From<Row> for Measured {
    fn from(row: Row) -> Self {
        let classes = row.classes.iter().map(|&c| c.is_finite().then_some(c)).collect();
        let Row { rule, evaluations, rms, p95, max, .. } = row;
        Self { rule, evaluations, rms, p95, max, classes }
    }
}

/// The largest step and the largest second difference of a rule along a path.
#[derive(Debug, Serialize)]
struct Sweep {
    integral: &'static str,
    rule: String,
    path: &'static str,
    step: f64,
    bend: f64,
}

impl From<SweepRow> for Sweep {
    fn from(SweepRow { integral, path, rule, steps }: SweepRow) -> Self {
        Self { integral, rule, path: path.name(), step: steps.step, bend: steps.bend }
    }
}

#[derive(Serialize)]
struct Data {
    studies: Vec<Study>,
    samplers: Vec<Study>,
    sweeps: Vec<Sweep>,
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let n = studio.pick(500, 3000);
    let study = |name, rows: Vec<Row>| Study { name, surfaces: n, rows: rows.into_iter().map(Into::into).collect() };
    let (diffuse, light) = (DiffuseSet::new(n, 16, 1), LightSet::new(n, 1));
    let [smooth, sharp] = [Sharpness::Smooth, Sharpness::Sharp].map(|of| SpecularSet::new(n, of, 1));
    let studies = vec![
        study("diffuse facets under order-2 irradiance", diffuse.rows()),
        study("diffuse facets under one light", light.rows()),
        study("specular facets in smooth environments", smooth.rows()),
        study("specular facets in sharp environments", sharp.rows()),
    ];
    // The samplers that LEADR §6 and §7 compare with the grid.
    let samplers = vec![
        study("samplers for diffuse facets under order-2 irradiance", diffuse.sampler_rows()),
        study("samplers for diffuse facets under one light", light.sampler_rows()),
        study("samplers for specular facets in smooth environments", smooth.sampler_rows()),
        study("samplers for specular facets in sharp environments", sharp.sampler_rows()),
    ];
    let sweeps: Vec<Sweep> = sweep_rows(studio.pick(6, 20)).into_iter().map(Into::into).collect();
    let mut html = Html::new();
    let mut findings = Vec::new();
    for study in &studies {
        html.heading(study.name);
        html.plot(&plot(study));
        html.table(&table(study));
        findings.extend(finding(study));
    }
    html.heading("Samplers that the papers compare with the grid");
    for study in &samplers {
        html.paragraph(&format!("{}{}.", study.name[..1].to_uppercase(), &study.name[1..]));
        html.table(&table(study));
    }
    html.heading("No popping");
    html.table(&sweep_table(&sweeps));
    findings.extend(sweep_findings(&sweeps));
    Section::new(INTRO, findings, &html, Data { studies, samplers, sweeps })
}

fn is_grid(row: &Measured) -> bool {
    row.rule.starts_with("paper")
}

fn plot(study: &Study) -> Plot {
    let title = format!("{}: error against evaluations per pixel", study.name);
    let mut plot = Plot::new(&title, ("evaluations per pixel", Scale::Log), ("rms error", Scale::Log));
    // The first word of a rule names its family.
    let mut families: Vec<&str> = Vec::new();
    for row in &study.rows {
        let family = row.rule.split(' ').next().unwrap_or_default();
        if !families.contains(&family) {
            families.push(family);
        }
    }
    for family in families {
        let mut points: Vec<(f64, f64)> = study
            .rows
            .iter()
            .filter(|row| row.rule.split(' ').next() == Some(family))
            .map(|row| (f64::from(row.evaluations), row.rms))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        plot.line(family, points);
    }
    plot
}

fn table(study: &Study) -> Table {
    let mut head: Vec<String> = ["rule", "evaluations", "rms", "95 % below", "largest"].map(str::to_owned).to_vec();
    let lows = [0.0].into_iter().chain(CLASSES);
    head.extend(lows.zip(CLASSES).map(|(low, top)| format!("rms, σ {low} to {top}")));
    let mut table = Table::new(format!("{} random surfaces", study.surfaces), head);
    for row in &study.rows {
        let mut cells: Vec<Cell> = vec![row.rule.as_str().into(), row.evaluations.to_string().into()];
        cells.extend([row.rms, row.p95, row.max].map(Cell::from));
        cells.extend(row.classes.iter().map(|c| Cell::from(c.unwrap_or(f64::NAN))));
        table.row(cells);
    }
    table
}

/// Compares the rules with the paper's 5 × 5 grid.
fn finding(study: &Study) -> Option<String> {
    let paper = study.rows.iter().find(|row| row.rule.starts_with("paper 5x5"))?;
    let best = study.rows.iter().filter(|row| !is_grid(row)).min_by(|a, b| a.rms.total_cmp(&b.rms))?;
    let few =
        study.rows.iter().filter(|row| !is_grid(row) && row.evaluations <= 9).min_by(|a, b| a.rms.total_cmp(&b.rms))?;
    let goal = if study.name.starts_with("specular") { 0.5 } else { 0.25 };
    let ratio = few.rms / paper.rms;
    Some(format!(
        "{}: {} with {} evaluations has {} times the rms error of the paper's 5×5 with {} (goal: at most {}: {}); the most accurate rule is {} with {} ({} times).",
        study.name,
        few.rule,
        few.evaluations,
        number(ratio),
        paper.evaluations,
        goal,
        if ratio <= goal { "met" } else { "missed" },
        best.rule,
        number(best.rms),
        number(best.rms / paper.rms),
    ))
}

fn sweep_table(sweeps: &[Sweep]) -> Table {
    let mut table = Table::new(
        "Slow sweeps: largest change between neighbouring steps, and largest change of that change, visible as popping",
        ["integral", "rule", "path", "largest step", "largest bend"],
    );
    for sweep in sweeps {
        let head = [sweep.integral.into(), sweep.rule.as_str().into(), sweep.path.into()];
        table.row(head.into_iter().chain([sweep.step, sweep.bend].map(Cell::from)));
    }
    table
}

const DEFAULTS: [&str; 2] = ["visible 2 terms", "rings of 16"];

/// Returns a finding for each integral, which compares the default rule with the paper's grid by the largest second
/// difference over all sweeps.
fn sweep_findings(sweeps: &[Sweep]) -> Vec<String> {
    let mut integrals: Vec<&'static str> = sweeps.iter().map(|sweep| sweep.integral).collect();
    integrals.sort_unstable();
    integrals.dedup();
    let of = |integral: &'static str| {
        let largest = |is_meant: &dyn Fn(&str) -> bool| {
            let meant = sweeps.iter().filter(|s| s.integral == integral && is_meant(&s.rule));
            meant.max_by(|a, b| a.bend.total_cmp(&b.bend))
        };
        let (rule, grid) = (largest(&|rule| DEFAULTS.contains(&rule))?, largest(&|rule| rule == "paper 5x5")?);
        Some(format!(
            "No popping, {integral}: along slow sweeps the change between steps changes by at most {} with {} (in {}) and by {} with the paper's 5×5 (in {}); goal, less than the grid: {}.",
            number(rule.bend),
            rule.rule,
            rule.path,
            number(grid.bend),
            grid.path,
            if rule.bend < grid.bend { "met" } else { "missed" }
        ))
    };
    integrals.into_iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn popping_is_judged_by_the_worst_sweep() {
        let sweep = |rule: &str, path, bend| Sweep { integral: "light", rule: rule.to_owned(), path, step: 1.0, bend };
        let mut sweeps = vec![
            sweep("paper 5x5", "elevation", 0.5),
            sweep("visible 2 terms", "elevation", 0.1),
            sweep("visible 3 terms", "elevation", 0.9),
            sweep("paper 5x5", "azimuth", 0.01),
            sweep("visible 2 terms", "azimuth", 0.02),
        ];
        let [met] = &sweep_findings(&sweeps)[..] else { panic!("one integral") };
        assert!(met.contains("at most 0.100 with visible 2 terms (in elevation)") && met.ends_with("met."), "{met}");
        sweeps.push(sweep("visible 2 terms", "roughness", 0.5));
        assert!(sweep_findings(&sweeps)[0].ends_with("missed."), "{}", sweep_findings(&sweeps)[0]);
        assert!(sweep_findings(&sweeps[1..2]).is_empty(), "nothing to compare with");
    }
}
