//! Shows the tables and goals of the bench, which is measured in this run.

use serde_json::Value;

use crate::report::section::Section;
use crate::report::studio::Studio;
use leadr_scenes::view::Size;
use leadr_tools::bench::{BenchConfig, Quad, bench};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};

const INTRO: &str = "Pass times on the device, measured like leadr bench --paper. Every round draws one frame of each row. The table \
    gives medians over rounds; ratios are computed within each round. The quad has 512 x 512 pixels (256 x 256 in a quick report); the \
    paper's own times are from an NVIDIA GTX 480 at 1024 x 1024.";

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
    html.table(&lines(&data));
    let mut rows = Html::new();
    rows.table(&passes(&data));
    html.details("All passes", &rows);
    let findings = findings(&data);
    Section::new(INTRO, findings, &html, data)
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
