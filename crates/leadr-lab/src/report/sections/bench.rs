//! Shows the tables and goals of the bench, which is measured in this run.

use serde_json::Value;

use crate::report::configuration::Configuration;
use crate::report::section::Section;
use crate::report::studio::Studio;
use crate::report::subject::Subject;
use leadr_render::camera::Camera;
use leadr_scenes::view::Size;
use leadr_tools::bench::{BenchConfig, Quad, bench};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Plot, Scale, Table, number};

const INTRO: &str = "Pass times on the device, measured like leadr bench --paper. Every round draws one frame of each row. The table \
    gives medians over rounds; ratios are computed within each round. The quad has 512 x 512 pixels (256 x 256 in a quick report); the \
    paper's own times are from an NVIDIA GTX 480 at 1024 x 1024. The T-rex is drawn without ground, at one sample per pixel, with the \
    default rules; its times are the least of several frames. In the distant view, the animal covers as many pixels as a square of an \
    eighth of the picture's width.";

/// The views of the T-rex with the times in milliseconds that the paper reports (LEADR section 7).
const TREX: [(&str, &str); 3] = [("whole", "40 to 60"), ("close-up", "about 200"), ("distant", "about 9")];

/// The sum of passes that Figure 11 shows and its lines fit.
const PASS: &str = "filter+shade";

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let size = studio.pick(256, 512);
    let config = BenchConfig {
        quad: Some(Quad { size: Size { width: size, height: size }, goals_only: false }),
        forward: None,
        scenes: Vec::new(),
        tables: Vec::new(),
        view_sizes: Vec::new(),
        technique: None,
        rounds: studio.pick(3, 7),
    };
    let report = bench(&config, || Ok(studio.gpu.clone()), studio.progress)?;
    let data = serde_json::to_value(&report).map_err(|e| LabError::json(&e))?;
    let mut html = Html::new();
    html.table(&goals(&data));
    html.table(&ratios(&data));
    html.plot(&figure_11(&data));
    html.table(&lines(&data));
    let (table, trex) = trex(studio)?;
    html.table(&table);
    let mut rows = Html::new();
    rows.table(&passes(&data));
    html.details("All passes", &rows);
    let mut findings = findings(&data);
    findings.push(format!(
        "The T-rex at {0} x {0} takes {1} ms as a whole, {2} ms in the close-up and {3} ms at a distance (the paper at 1024 x 1024: 40 to 60, \
        about 200 and about 9).",
        trex_side(studio),
        number(trex[0]),
        number(trex[1]),
        number(trex[2])
    ));
    Section::new(INTRO, findings, &html, data)
}

fn trex_side(studio: &Studio) -> u32 {
    studio.pick(128, 1024)
}

/// Draws the T-rex in the views of the paper. Returns a table and the times in milliseconds.
fn trex(studio: &mut Studio) -> Result<(Table, [f64; 3]), LabError> {
    let side = trex_side(studio);
    let mut subject = Subject::trex(studio, studio.pick(8, 32))?;
    let settings = Configuration::program_default().settings((side, side), 1);
    let rounds = studio.pick(2, 5);
    let views = subject.stage.views;
    let mut measure = |camera: &Camera| -> Result<(f64, f64), LabError> {
        let state = subject.seen_by(camera);
        let (mut least, mut covered) = (f64::INFINITY, 0.0);
        for _ in 0..rounds {
            let shot = studio.shoot(&mut subject.renderer, &state, &settings)?;
            least = least.min(shot.milliseconds);
            covered = shot.coverage.iter().map(|&c| f64::from(c)).sum();
        }
        Ok((least, covered))
    };
    let whole = measure(&views.mid)?;
    let distance = views.mid.position.distance(views.mid.target) * (whole.1.sqrt() * 8.0 / f64::from(side)) as f32;
    let seen = [whole, measure(&views.near)?, measure(&views.mid.at_distance(distance))?];
    let caption = format!("The T-rex, {side} x {side} pixels");
    let mut table = Table::new(caption, ["view", "covered pixels", "ms", "paper, ms at 1024 x 1024"]);
    for ((view, paper), (ms, covered)) in TREX.iter().zip(seen) {
        table.row([Cell::from(*view), Cell::from(covered.round()), Cell::from(ms), Cell::from(*paper)]);
    }
    Ok((table, seen.map(|of| of.0)))
}

fn list<'a>(data: &'a Value, key: &str) -> &'a [Value] {
    data[key].as_array().map_or(&[], Vec::as_slice)
}

fn text(value: &Value) -> Cell {
    match value {
        Value::String(text) => Cell::from(text.as_str()),
        Value::Number(n) => Cell::Number(n.as_f64().unwrap_or(f64::NAN)),
        Value::Bool(b) => Cell::from(if *b { "yes" } else { "no" }),
        Value::Null => Cell::from(""),
        other => Cell::from(other.to_string()),
    }
}

/// Returns a table with one row per object of a list. `columns` selects the fields.
fn fields(data: &Value, key: &str, caption: &str, columns: &[(&str, &str)]) -> Table {
    let mut table = Table::new(caption, columns.iter().map(|c| c.1));
    for row in list(data, key) {
        table.row(columns.iter().map(|(field, _)| text(&row[*field])));
    }
    table
}

fn bound(goal: &Value) -> String {
    let at = |key: &str| goal["bound"][key].as_f64();
    match (at("at_most"), at("at_least")) {
        (Some(most), _) => format!("at most {most}"),
        (_, Some(least)) => format!("at least {least}"),
        _ => String::new(),
    }
}

fn goals(data: &Value) -> Table {
    let mut table = Table::new("Goals", ["goal", "bound", "median", "quartile", "quartile", "met"]);
    for goal in list(data, "goals") {
        let mut cells = vec![text(&goal["goal"]), Cell::from(bound(goal))];
        cells.extend(["median", "low", "high", "met"].map(|key| text(&goal[key])));
        table.row(cells);
    }
    table
}

fn ratios(data: &Value) -> Table {
    let columns = [
        ("table", "table"),
        ("of", "row"),
        ("to", "against"),
        ("pass", "pass"),
        ("median", "ratio"),
        ("low", "quartile"),
        ("high", "quartile"),
        ("paper", "paper's ratio"),
    ];
    fields(data, "ratios", "Ratios of times", &columns)
}

fn lines(data: &Value) -> Table {
    let columns = [
        ("table", "table"),
        ("intercept_ms", "ms without samples"),
        ("per_sample_ms", "ms per sample"),
        ("r_squared", "R²"),
        ("worst", "largest deviation from the line"),
    ];
    fields(data, "lines", "Time against samples, Figure 11: straight lines through the medians", &columns)
}

/// Plots the medians of LEADR Figure 11 over the number of samples, with the fitted lines.
fn figure_11(data: &Value) -> Plot {
    let mut plot = Plot::new(
        "LEADR Figure 11: time under environment light; fits are dashed",
        ("samples", Scale::Linear),
        ("ms of filter+shade", Scale::Linear),
    );
    let value = |of: &Value, key: &str| of[key].as_f64().unwrap_or(f64::NAN);
    for line in list(data, "lines") {
        let table = line["table"].as_str().unwrap_or_default();
        let of_table = list(data, "rows").iter().filter(|row| row["table"] == table && row["pass"] == PASS);
        let points: Vec<(f64, f64)> = of_table.map(|row| (value(row, "samples"), value(row, "median_ms"))).collect();
        let most = points.iter().map(|point| point.0).fold(0.0, f64::max);
        let fit = |samples: f64| (samples, value(line, "intercept_ms") + samples * value(line, "per_sample_ms"));
        let name = table.trim_start_matches("figure 11, ");
        plot.line(name, points);
        plot.guide(&format!("{name}, fit"), vec![fit(0.0), fit(most)]);
    }
    plot
}

fn passes(data: &Value) -> Table {
    let columns = [
        ("table", "table"),
        ("row", "row"),
        ("pass", "pass"),
        ("median_ms", "median, ms"),
        ("p95_ms", "95th percentile, ms"),
        ("paper_ms", "paper, ms"),
    ];
    fields(data, "rows", "Every row and pass", &columns)
}

fn findings(data: &Value) -> Vec<String> {
    let goals = list(data, "goals").iter().map(|goal| {
        let (median, met) = (goal["median"].as_f64().unwrap_or(f64::NAN), goal["met"].as_bool().unwrap_or(false));
        let clear = if goal["clear"].as_bool().unwrap_or(false) { "" } else { ", but the quartiles do not agree" };
        format!(
            "{}: {} ({}): {}{clear}.",
            goal["goal"].as_str().unwrap_or_default(),
            number(median),
            bound(goal),
            if met { "met" } else { "missed" },
        )
    });
    goals.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn figure_11_has_the_times_and_fits_of_both_tables() {
        let row = |table: &str, pass: &str, samples: u32, ms: f64| json!({ "table": table, "pass": pass, "samples": samples, "median_ms": ms });
        let [specular, diffuse] = ["figure 11, specular environment", "figure 11, diffuse environment"];
        let line = |table: &str| json!({ "table": table, "intercept_ms": 1.0, "per_sample_ms": 0.5 });
        let data = json!({
            "rows": [
                row(specular, PASS, 1, 1.5),
                row(specular, "shade", 1, 1.0),
                row("specular environment", PASS, 9, 7.0),
                row(specular, PASS, 4, 3.0),
                row(diffuse, PASS, 4, 3.5),
            ],
            "lines": [line(specular), line(diffuse)],
        });
        let plot = figure_11(&data);
        let names: Vec<&str> = plot.series.iter().map(|series| series.name.as_str()).collect();
        assert_eq!(
            names,
            ["specular environment", "specular environment, fit", "diffuse environment", "diffuse environment, fit"]
        );
        assert_eq!(plot.series[0].points, [(1.0, 1.5), (4.0, 3.0)]);
        assert_eq!(plot.series[1].points, [(0.0, 1.0), (4.0, 3.0)]);
        assert_eq!(plot.series[2].points, [(4.0, 3.5)]);
        assert!(plot.series[1].guide && plot.series[3].guide && !plot.series[0].guide);
    }
}
