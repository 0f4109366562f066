//! The result of a bench as JSON or as text tables.

use std::fmt;

use serde::Serialize;

use super::against::{Comparison, Time, Times};
use super::forward::FORWARD;
use super::goals::{Bound, Verdict};
use super::ocean::WAVES;
use super::quad::{FIGURE_11, GOALS, paper_ms};
use super::rounds::{CPU, FRAME, PIXELS, TOTAL, WITH_GEOMETRY};
use super::rows::Measured;
use super::stats::{Line, Ratio, in_order, least_squares, median, quantile};
use crate::command::device::DeviceInfo;
use crate::csv::quoted;
use crate::error::LabError;
use crate::program::commit;
use leadr_gpu::Gpu;

/// The result of a bench.
#[derive(Debug, Serialize)]
pub struct BenchReport {
    command: &'static str,
    #[serde(flatten)]
    device: DeviceInfo,
    /// The build profile of the program, which does not affect times on the device.
    profile: &'static str,
    /// The number of rounds.
    frames: u32,
    rows: Vec<RowReport>,
    ratios: Vec<RatioReport>,
    /// The line fits of time over samples, one for each table (LEADR Figure 11).
    lines: Vec<LineReport>,
    goals: Vec<Verdict>,
    /// The comparison with an earlier run, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    against: Option<Comparison>,
    /// The wall-clock time of the whole bench in seconds.
    seconds: f64,
}

/// The pass in which techniques differ most, and whose ratio is also printed.
const SHADE: &str = "shade";

/// One pass of one row.
#[derive(Clone, Debug, Serialize)]
pub struct RowReport {
    table: String,
    row: String,
    /// The name of the row with which this row is compared.
    base: Option<String>,
    /// A second row with which the per-pixel passes are compared.
    beside: Option<String>,
    /// The name of the pass or sum of passes that is compared.
    compared: &'static str,
    technique: &'static str,
    /// The sampling rule of the integrals over slopes.
    rule: &'static str,
    /// The number of slopes per pixel and environment term: probes of the environment, or samples of the grid.
    #[serde(rename = "samples")]
    probes: u32,
    visibility: &'static str,
    /// The distance in metres from the camera to its target, for tables with several distances.
    distance: Option<f64>,
    size: [u32; 2],
    /// The upper bound on the number of triangles in a frame, including shadow maps, for rows of whole frames.
    triangles: Option<u64>,
    /// The number of patches drawn for the camera, for rows of whole frames.
    patches: Option<u32>,
    /// The name of a pass or sum of passes on the device, or of a component of the CPU time (`cpu prepare`, `cpu record`,
    /// `cpu wait`). `frame` is the sum of the CPU components.
    pass: String,
    median_ms: f64,
    p95_ms: f64,
    min_ms: f64,
    /// The number of repetitions of the pass in each timed region.
    repeats: u32,
    /// The number of rounds in which the row was measured.
    measurements: usize,
    /// The set-up time of the scene in seconds, for tables that measure set-up.
    #[serde(skip_serializing_if = "Option::is_none")]
    set_up_s: Option<f64>,
    /// The time in milliseconds that the paper reports on an NVIDIA GTX 480.
    paper_ms: Option<f64>,
}

/// The ratio of a row to the row with which it is compared.
#[derive(Clone, Debug, Serialize)]
pub struct RatioReport {
    table: String,
    of: String,
    to: String,
    pass: &'static str,
    #[serde(flatten)]
    ratio: Ratio,
    /// The ratio of the times that the paper reports for the same rows.
    paper: Option<f64>,
}

/// A least-squares fit of a line to the medians of `filter+shade` over the number of samples.
#[derive(Clone, Debug, Serialize)]
pub struct LineReport {
    table: String,
    #[serde(flatten)]
    line: Line,
}

impl BenchReport {
    /// Returns the rows as tidy CSV: a header with units, and a line per pass of each row.
    pub fn csv(&self) -> String {
        csv(&self.rows)
    }

    /// Summarises measurements on `gpu`. `frames` is the number of rounds, and `seconds` is the wall-clock time.
    pub fn new(gpu: &Gpu, measured: Vec<Measured>, frames: u32, seconds: f64) -> Self {
        let find = |table: &str, row: &str| measured.iter().find(|m| m.row.table == table && m.row.name == row);
        Self {
            command: "bench",
            device: DeviceInfo::of(gpu),
            profile: if cfg!(debug_assertions) { "dev" } else { "release" },
            frames,
            rows: measured.iter().flat_map(rows).collect(),
            ratios: measured
                .iter()
                .filter_map(|m| Some((m, find(&m.row.table, m.row.base.as_deref()?)?)))
                .filter(|(m, base)| m.row.name != base.row.name)
                .flat_map(|(m, base)| {
                    let passes =
                        if base.row.forward.is_some() { [PIXELS, WITH_GEOMETRY] } else { [m.row.compared, SHADE] };
                    passes.into_iter().filter_map(|pass| ratio(m, base, pass))
                })
                .chain(measured.iter().filter_map(|m| ratio(m, find(&m.row.table, m.row.beside.as_deref()?)?, PIXELS)))
                .collect(),
            lines: FIGURE_11.iter().filter_map(|table| line(table, &measured)).collect(),
            goals: GOALS.iter().filter_map(|goal| goal.judge(|t, r| find(t, r).map(|m| &m.series))).collect(),
            against: None,
            seconds,
        }
    }

    /// Adds a comparison with an earlier run, and returns the comparison.
    ///
    /// # Errors
    /// Fails if the runs have no row in common.
    pub fn compare_with(&mut self, earlier: &Times) -> Result<&Comparison, LabError> {
        let time = |row: &RowReport| Time {
            table: row.table.clone(),
            row: row.row.clone(),
            pass: row.pass.clone(),
            size: row.size,
            median_ms: row.median_ms,
            min_ms: row.min_ms,
        };
        let this = Times::new(&self.device, commit(), self.rows.iter().map(time).collect());
        Ok(self.against.insert(earlier.compare(&this)?))
    }
}

/// Columns of the CSV form, with units.
const COLUMNS: [&str; 17] = [
    "table",
    "row",
    "pass",
    "technique",
    "rule",
    "probes",
    "visibility",
    "width_px",
    "height_px",
    "distance_m",
    "triangles",
    "patches",
    "median_ms",
    "p95_ms",
    "min_ms",
    "repeats",
    "measurements",
];

/// Formats rows as tidy CSV: a header with units, and a line per pass of each row. Numbers that a row lacks are empty.
fn csv(rows: &[RowReport]) -> String {
    fn number(value: Option<impl ToString>) -> String {
        value.map(|value| value.to_string()).unwrap_or_default()
    }
    let line = |row: &RowReport| {
        let texts = [&row.table, &row.row, &row.pass, row.technique, row.rule].map(quoted);
        let settings =
            [row.probes.to_string(), quoted(row.visibility), row.size[0].to_string(), row.size[1].to_string()];
        let counts = [number(row.distance), number(row.triangles), number(row.patches)];
        let times = [row.median_ms, row.p95_ms, row.min_ms].map(|ms| format!("{ms:.6}"));
        let rounds = [row.repeats.to_string(), row.measurements.to_string()];
        [&texts[..], &settings, &counts, &times, &rounds].concat().join(",") + "\n"
    };
    COLUMNS.join(",") + "\n" + &rows.iter().map(line).collect::<String>()
}

fn rows(measured: &Measured) -> Vec<RowReport> {
    let Measured { row, series } = measured;
    let mut passes = series.passes();
    if !passes.contains(&row.compared) {
        passes.push(row.compared);
    }
    // A forward pass has no separate filter and shade passes.
    passes.retain(|pass| series.of(pass).iter().any(Option::is_some));
    let counts = series.counts();
    let report = |pass: &&str| {
        let times = series.times(pass);
        RowReport {
            table: row.table.clone(),
            row: row.name.clone(),
            base: row.base.clone(),
            beside: row.beside.clone(),
            compared: row.compared,
            technique: row.settings.shading.technique().name(),
            rule: row.rule(),
            probes: row.probes(),
            visibility: row.shadowing(),
            distance: row.distance(),
            size: [row.settings.size.0, row.settings.size.1],
            triangles: counts.map(|(triangles, _)| triangles),
            patches: counts.map(|(_, patches)| patches),
            pass: (*pass).to_owned(),
            median_ms: median(&times),
            p95_ms: quantile(&times, 0.95),
            min_ms: quantile(&times, 0.0),
            repeats: if is_once(pass) { 1 } else { series.repeats },
            measurements: series.measurements(),
            set_up_s: row.set_up,
            paper_ms: paper_ms(row).filter(|_| *pass == TOTAL),
        }
    };
    passes.iter().map(report).collect()
}

fn ratio(measured: &Measured, base: &Measured, pass: &'static str) -> Option<RatioReport> {
    let of_base = if base.row.forward.is_some() { TOTAL } else { pass };
    let ratio = measured.series.ratio(pass, &base.series, of_base)?;
    let paper = paper_ms(&measured.row).zip(paper_ms(&base.row)).map(|(of, to)| of / to);
    let (table, of, to) = (measured.row.table.clone(), measured.row.name.clone(), base.row.name.clone());
    Some(RatioReport { table, of, to, pass, ratio, paper })
}

fn line(table: &str, measured: &[Measured]) -> Option<LineReport> {
    let rows = measured.iter().filter(|m| m.row.table == table);
    let points: Vec<(f64, f64)> = rows.map(|m| (f64::from(m.row.probes()), median(&m.series.times(PIXELS)))).collect();
    Some(LineReport { table: table.to_owned(), line: least_squares(&points)? })
}

/// Whether a pass runs only once, even if other passes are repeated.
fn is_once(pass: &str) -> bool {
    pass == "sky" || is_cpu(pass)
}

/// Whether a name is a component of the CPU time.
fn is_cpu(pass: &str) -> bool {
    pass == FRAME || CPU.contains(&pass)
}

/// Returns the column heading of a pass or sum of passes.
fn title(pass: &str) -> &str {
    if pass == WAVES { "waves" } else { pass }
}

/// Formats milliseconds with about four digits.
fn ms(value: f64) -> String {
    let digits = [1000.0, 100.0, 10.0].into_iter().filter(|power| value < *power).count();
    format!("{value:.digits$}")
}

impl fmt::Display for BenchReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}, commit {}", self.device, commit())?;
        writeln!(
            f,
            "medians in ms on the device, {} rounds; ratios: median [quartiles] over rounds, then the ratio of the fastest frames",
            self.frames
        )?;
        for table in in_order(self.rows.iter().map(|row| row.table.as_str())) {
            self.table(f, table)?;
        }
        if !self.goals.is_empty() {
            writeln!(f, "\ngoals")?;
        }
        let width = self.goals.iter().map(|goal| goal.goal.len()).max().unwrap_or(0);
        for goal in &self.goals {
            let bound = match goal.bound {
                Bound::AtMost(most) => format!("at most {most:.2}"),
                Bound::AtLeast(least) => format!("at least {least:.0}"),
            };
            let met = match (goal.met, goal.clear) {
                (true, true) => "met",
                (true, false) => "met, within the noise",
                (false, true) => "MISSED",
                (false, false) => "MISSED, within the noise",
            };
            let (median, low, high) = (goal.median, goal.low, goal.high);
            let fastest = goal.fastest;
            writeln!(
                f,
                "  {:width$} {median:8.3} [{low:.3}, {high:.3}], fastest {fastest:.3}; {bound}: {met}",
                goal.goal
            )?;
        }
        if let Some(comparison) = &self.against {
            writeln!(f, "\n{comparison}\n")?;
        }
        write!(f, "{:.0} s", self.seconds)
    }
}

impl BenchReport {
    fn table(&self, f: &mut fmt::Formatter<'_>, table: &str) -> fmt::Result {
        let rows: Vec<&RowReport> = self.rows.iter().filter(|r| r.table == table).collect();
        // Tables of the quad print only the cost of pixels, but JSON has all passes.
        let own = |pass: &str| ["geometry", "filter", "shade", PIXELS, FORWARD].contains(&pass);
        let compared = rows[0].compared;
        let timed = rows.iter().map(|row| row.pass.as_str());
        let passes = in_order(timed.filter(|pass| !is_cpu(pass) && (compared != PIXELS || own(pass))));
        let [width, height] = rows[0].size;
        let size = format!(", {width}x{height}");
        match rows.iter().all(|row| row.size == rows[0].size) && !table.ends_with(&size) {
            true => writeln!(f, "\n{table}{size}")?,
            false => writeln!(f, "\n{table}")?,
        }
        let mut names: Vec<&str> = rows.iter().map(|r| r.row.as_str()).collect();
        names.dedup();
        let width = names.iter().map(|name| name.len()).max().unwrap_or(0).max(24);
        write!(f, "  {:width$} {:>7}", "", "probes")?;
        for pass in &passes {
            write!(f, " {:>12}", title(pass))?;
        }
        let base = if passes.contains(&FORWARD) { Some("the next forward pass") } else { rows[0].base.as_deref() };
        writeln!(f, " {:>9}  {} against {}", "p95", title(compared), base.unwrap_or("nothing"))?;
        for name in &names {
            let cells: Vec<&&RowReport> = rows.iter().filter(|r| r.row == **name).collect();
            write!(f, "  {name:width$} {:>7}", cells[0].probes)?;
            for pass in &passes {
                let cell = cells.iter().find(|c| c.pass == *pass).map_or(String::new(), |c| ms(c.median_ms));
                write!(f, " {cell:>12}")?;
            }
            let against = |to: &Option<String>, pass: &str| {
                let is_it = |r: &&RatioReport| r.table == table && r.of == **name && Some(&r.to) == to.as_ref();
                self.ratios.iter().filter(is_it).find(|r| r.pass == pass)
            };
            let ratio = |pass: &str| against(&cells[0].base, pass);
            let p95 =
                cells.iter().find(|c| c.pass == compared || c.pass == FORWARD).map_or(String::new(), |c| ms(c.p95_ms));
            write!(f, " {p95:>9}")?;
            if let Some(RatioReport { ratio: Ratio { median, low, high, fastest, .. }, paper, .. }) = ratio(compared) {
                write!(f, "  {median:7.3} [{low:.3}, {high:.3}], fastest {fastest:.3}")?;
                for (pass, what) in [(SHADE, "shade alone"), (WITH_GEOMETRY, "with geometry")] {
                    if let Some(RatioReport { ratio: Ratio { median, fastest, .. }, .. }) = ratio(pass) {
                        write!(f, "; {what} {median:.3}, fastest {fastest:.3}")?;
                    }
                }
                if let Some(paper) = paper {
                    write!(f, "; paper {paper:.3}")?;
                }
            }
            if let Some(paper) = cells.iter().find_map(|cell| cell.paper_ms) {
                write!(f, "{} paper {paper:.3} ms", if ratio(compared).is_some() { "," } else { " " })?;
            }
            if let Some(r) = against(&cells[0].beside, PIXELS) {
                write!(f, "; {PIXELS} against {} {:.3}, fastest {:.3}", r.to, r.ratio.median, r.ratio.fastest)?;
            }
            writeln!(f)?;
        }
        Self::frames(f, &rows, &names)?;
        for line in self.lines.iter().filter(|l| l.table == table) {
            let Line { intercept, slope, r_squared, worst } = line.line;
            let (a, b) = (ms(intercept), ms(slope));
            writeln!(f, "  {a} ms + {b} ms per probe; R² {r_squared:.5}, largest deviation {:.1} %", 100.0 * worst)?;
        }
        Ok(())
    }

    /// Prints the triangle counts and CPU times of rows that measure whole frames.
    fn frames(f: &mut fmt::Formatter<'_>, rows: &[&RowReport], names: &[&str]) -> fmt::Result {
        let columns: Vec<&str> = CPU.into_iter().chain([FRAME]).collect();
        if !rows.iter().any(|row| is_cpu(&row.pass)) {
            return Ok(());
        }
        write!(f, "  {:24} {:>9} {:>9}", "", "triangles", "patches")?;
        for column in &columns {
            write!(f, " {column:>12}")?;
        }
        writeln!(f, " {:>9}", "p95")?;
        for name in names {
            let cell = |pass: &str| rows.iter().find(|row| row.row == *name && row.pass == pass);
            let Some(frame) = cell(FRAME) else { continue };
            let count = |count: Option<u64>| count.map_or(String::new(), |count| count.to_string());
            let (triangles, patches) = (count(frame.triangles), count(frame.patches.map(u64::from)));
            write!(f, "  {name:24} {triangles:>9} {patches:>9}")?;
            for column in &columns {
                write!(f, " {:>12}", cell(column).map_or(String::new(), |cell| ms(cell.median_ms)))?;
            }
            writeln!(f, " {:>9}", ms(frame.p95_ms))?;
        }
        Ok(())
    }
}
