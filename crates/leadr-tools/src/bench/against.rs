//! Compares a bench with an earlier run, by ratios for each row and geometric means for each pass.

use std::collections::{HashMap, HashSet};
use std::fmt;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::rounds::TOTAL;
use super::stats::in_order;
use crate::command::device::DeviceInfo;
use crate::error::LabError;
use leadr_maps::MapFault;
use leadr_maps::limits::read_file;
use leadr_maps::shown::{shown, shown_line, shown_path};

/// The times of a run from the output of `leadr bench --json`. Other fields are ignored.
#[derive(Clone, Debug, Deserialize)]
pub struct Times {
    /// The file that contained the times, or an empty path for the current run.
    #[serde(skip)]
    file: PathBuf,
    device: String,
    driver: String,
    commit: String,
    rows: Vec<Time>,
}

#[derive(Clone, Debug, Deserialize)]
pub(super) struct Time {
    pub table: String,
    pub row: String,
    pub pass: String,
    pub size: [u32; 2],
    pub median_ms: f64,
    pub min_ms: f64,
}

/// The comparison of a run with an earlier run.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// The file of the earlier run.
    file: PathBuf,
    device: String,
    driver: String,
    commit: String,
    /// Whether the names of the devices differ.
    other_device: bool,
    /// The passes of rows whose times are above 0 in both runs.
    rows: Vec<RowRatio>,
    /// The geometric means over all rows, for each pass.
    passes: Vec<PassRatio>,
    /// The rows that only the current run has, and the passes that it has in addition in common rows.
    only_in_this: Vec<Lonely>,
    /// The rows and passes that only the earlier run has.
    only_in_that: Vec<Lonely>,
}

/// A row's pass that both runs have. Ratios are the current time over the earlier time, so a ratio below 1 is faster.
#[derive(Clone, Debug, Serialize)]
struct RowRatio {
    table: String,
    row: String,
    pass: String,
    size: [u32; 2],
    min_ratio: f64,
    median_ratio: f64,
}

/// The mean ratios of a pass over all rows that have the pass in both runs.
#[derive(Clone, Debug, Serialize)]
struct PassRatio {
    pass: String,
    rows: usize,
    /// The geometric mean of the ratios of minimum times.
    min_ratio: f64,
    /// The geometric mean of the ratios of medians.
    median_ratio: f64,
}

/// A row or pass that only one of the runs has.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Lonely {
    table: String,
    row: String,
    size: [u32; 2],
    /// The pass, or `None` if the whole row is missing from one run.
    pass: Option<String>,
}

/// The maximum size of a result file. The result of all tables has several hundred thousand bytes.
const MOST_BYTES: usize = 64 << 20;

type Key<'a> = (&'a str, &'a str, [u32; 2], &'a str);

impl Time {
    fn key(&self) -> Key<'_> {
        (&self.table, &self.row, self.size, &self.pass)
    }

    fn row_key(&self) -> (&str, &str, [u32; 2]) {
        (&self.table, &self.row, self.size)
    }
}

impl Times {
    pub(super) fn new(on: &DeviceInfo, commit: &str, rows: Vec<Time>) -> Self {
        let DeviceInfo { device, driver } = on.clone();
        Self { file: PathBuf::new(), device, driver, commit: commit.to_owned(), rows }
    }

    /// Reads the output of `leadr bench --json`.
    ///
    /// # Errors
    /// Fails if the file cannot be read, is truncated, is not JSON, or is not the result of a bench. The message is one
    /// sentence that includes the file name.
    pub fn read(path: &Path) -> Result<Self, LabError> {
        let bytes = read_file(path).map_err(|fault| match fault {
            MapFault::NotAFile => LabError::io("read", path, "it is not a file; give the output of leadr bench --json"),
            fault => LabError::io("read", path, fault),
        })?;
        let times = Self::parse(&bytes).map_err(|fault| {
            LabError::io("compare with", path, format!("{fault}; give the output of leadr bench --json"))
        })?;
        Ok(Self { file: path.to_owned(), ..times })
    }

    fn parse(bytes: &[u8]) -> Result<Self, String> {
        if bytes.len() > MOST_BYTES {
            return Err(format!("it has {} bytes, over the limit of {MOST_BYTES}", bytes.len()));
        }
        let value: Value = serde_json::from_slice(bytes).map_err(|e| {
            let location = format!("line {} column {}", e.line(), e.column());
            if e.is_eof() {
                format!("it ends too early, at {location}")
            } else {
                format!("it is not JSON at {location}")
            }
        })?;
        let Some(object) = value.as_object() else { return Err("it is not a JSON object".to_owned()) };
        match object.get("command").and_then(Value::as_str) {
            Some("bench") => {}
            Some(other) => return Err(format!("it is the result of leadr {}", shown(other))),
            None => return Err("it has no field command".to_owned()),
        }
        if !object.contains_key("rows") {
            return Err("it has no field rows".to_owned());
        }
        let times: Self = serde_json::from_value(value).map_err(|e| shown_line(&e.to_string()))?;
        if times.rows.is_empty() {
            return Err("its list of rows is empty".to_owned());
        }
        let mut seen = HashSet::new();
        for time in &times.rows {
            let name = || shown(&format!("{}: {}, {}", time.table, time.row, time.pass));
            if !(time.median_ms >= 0.0 && time.min_ms >= 0.0) {
                return Err(format!("a time of {} is below 0", name()));
            }
            if !seen.insert(time.key()) {
                return Err(format!("it has {} twice", name()));
            }
        }
        Ok(times)
    }

    /// Checks that the times were measured on the device with this name.
    ///
    /// # Errors
    /// Fails if the names of the devices differ.
    pub fn check_device(&self, device: &str) -> Result<(), LabError> {
        if self.device == device {
            return Ok(());
        }
        let fault = format!(
            "it was measured on {}, and this run is on {device}; add --any-device to compare them anyway",
            shown(&self.device)
        );
        Err(LabError::io("compare with", &self.file, fault))
    }

    /// Returns the name of the measured device.
    pub fn device(&self) -> &str {
        &self.device
    }

    /// Compares `this` run with the earlier times in `self`.
    ///
    /// # Errors
    /// Fails if the runs have no row in common.
    pub fn compare(&self, this: &Self) -> Result<Comparison, LabError> {
        let before: HashMap<Key<'_>, &Time> = self.rows.iter().map(|time| (time.key(), time)).collect();
        let rows: Vec<RowRatio> = this
            .rows
            .iter()
            .filter_map(|time| Some((time, *before.get(&time.key())?)))
            // A pass without work takes 0 ms, so its ratio is undefined.
            .filter(|(now, then)| [now.min_ms, now.median_ms, then.min_ms, then.median_ms].iter().all(|ms| *ms > 0.0))
            .map(|(now, then)| RowRatio {
                table: now.table.clone(),
                row: now.row.clone(),
                pass: now.pass.clone(),
                size: now.size,
                min_ratio: now.min_ms / then.min_ms,
                median_ratio: now.median_ms / then.median_ms,
            })
            .collect();
        if rows.is_empty() {
            let fault = format!(
                "the runs have no row in common: the earlier one has {}, this one {}; measure the same tables at the same --size",
                self.first_row(),
                this.first_row()
            );
            return Err(LabError::io("compare with", &self.file, fault));
        }
        Ok(Comparison {
            file: self.file.clone(),
            device: self.device.clone(),
            driver: self.driver.clone(),
            commit: self.commit.clone(),
            other_device: self.device != this.device,
            passes: means(&rows),
            rows,
            only_in_this: lonely(&this.rows, &self.rows),
            only_in_that: lonely(&self.rows, &this.rows),
        })
    }

    fn first_row(&self) -> String {
        let Some(Time { table, row, size: [width, height], .. }) = self.rows.first() else { return "none".to_owned() };
        format!("'{}: {}' at {width}x{height}", shown(table), shown(row))
    }
}

/// Returns the geometric means of the ratios of each pass.
fn means(rows: &[RowRatio]) -> Vec<PassRatio> {
    let passes = in_order(rows.iter().map(|row| row.pass.as_str()));
    let mean = |pass: &&str| {
        let of: Vec<&RowRatio> = rows.iter().filter(|row| row.pass == **pass).collect();
        let mean =
            |ratio: fn(&RowRatio) -> f64| (of.iter().map(|r| ratio(r).ln()).sum::<f64>() / of.len() as f64).exp();
        PassRatio {
            pass: (*pass).to_owned(),
            rows: of.len(),
            min_ratio: mean(|row| row.min_ratio),
            median_ratio: mean(|row| row.median_ratio),
        }
    };
    passes.iter().map(mean).collect()
}

/// Returns the rows and passes in `these` that are missing in `others`.
fn lonely(these: &[Time], others: &[Time]) -> Vec<Lonely> {
    let keys: HashSet<Key<'_>> = others.iter().map(Time::key).collect();
    let rows: HashSet<_> = others.iter().map(Time::row_key).collect();
    let missing = these.iter().filter(|time| !keys.contains(&time.key()));
    in_order(missing.map(|time| {
        let Time { table, row, size, pass, .. } = time.clone();
        let pass = rows.contains(&time.row_key()).then_some(pass);
        Lonely { table, row, size, pass }
    }))
}

impl Comparison {
    /// Returns the geometric mean of the ratios of the minimum total times. A mean below 1 means that the current run is
    /// faster.
    pub fn total(&self) -> Option<f64> {
        self.passes.iter().find(|mean| mean.pass == TOTAL).map(|mean| mean.min_ratio)
    }

    fn table(&self, f: &mut fmt::Formatter<'_>, table: &str) -> fmt::Result {
        let rows: Vec<&RowRatio> = self.rows.iter().filter(|row| row.table == table).collect();
        let names = in_order(rows.iter().map(|row| (row.row.as_str(), row.size)));
        let passes = in_order(rows.iter().map(|row| row.pass.as_str()));
        write!(f, "\n{table}\n  {:32}", "")?;
        for pass in &passes {
            write!(f, " {pass:>13}")?;
        }
        writeln!(f)?;
        for (name, size) in names {
            write!(f, "  {:32}", format!("{name}, {}x{}", size[0], size[1]))?;
            for pass in &passes {
                let cell = rows.iter().find(|row| row.row == name && row.size == size && row.pass == *pass);
                let cell = cell.map_or(String::new(), |row| format!("{:.3} {:.3}", row.min_ratio, row.median_ratio));
                write!(f, " {cell:>13}")?;
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [device, driver, commit] = [&self.device, &self.driver, &self.commit].map(|text| shown(text));
        writeln!(f, "against {}: {device} ({driver}), commit {commit}", shown_path(&self.file))?;
        if self.other_device {
            writeln!(f, "the devices differ: the ratios compare devices as well as programs")?;
        }
        writeln!(f, "ratios of this run to the earlier one, below 1 is faster: least times, then medians")?;
        for table in in_order(self.rows.iter().map(|row| row.table.as_str())) {
            self.table(f, table)?;
        }
        write!(f, "\ngeometric means{:>25} {:>9} {:>9}", "rows", "least", "median")?;
        for PassRatio { pass, rows, min_ratio, median_ratio } in &self.passes {
            write!(f, "\n  {pass:32} {rows:>5} {min_ratio:>9.3} {median_ratio:>9.3}")?;
        }
        for (run, lonely) in [("this run", &self.only_in_this), ("the earlier run", &self.only_in_that)] {
            for Lonely { table, row, size: [width, height], pass } in lonely {
                let [table, row] = [table, row].map(|text| shown(text));
                let pass = pass.as_ref().map_or(String::new(), |pass| format!(", {}", shown(pass)));
                write!(f, "\nonly in {run}: {table}: {row}, {width}x{height}{pass}")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn time(row: &str, pass: &str, min_ms: f64, median_ms: f64) -> Time {
        let [table, row, pass] = ["t", row, pass].map(str::to_owned);
        Time { table, row, pass, size: [8, 4], median_ms, min_ms }
    }

    fn times(rows: Vec<Time>) -> Times {
        let on = DeviceInfo { device: "a device".to_owned(), driver: "a driver".to_owned() };
        Times::new(&on, "abc", rows)
    }

    #[test]
    fn ratios_are_of_the_same_rows_and_means_are_geometric() {
        let before =
            times(vec![time("a", "shade", 2.0, 4.0), time("b", "shade", 1.0, 1.0), time("gone", TOTAL, 1.0, 1.0)]);
        let now = vec![time("b", "shade", 4.0, 3.0), time("a", "shade", 1.0, 1.0), time("a", "tiles", 1.0, 1.0)];
        let comparison = before.compare(&times(now)).unwrap();
        let ratios: Vec<_> = comparison.rows.iter().map(|r| (r.row.as_str(), r.min_ratio, r.median_ratio)).collect();
        assert_eq!(ratios, [("b", 4.0, 3.0), ("a", 0.5, 0.25)]);
        let [shade] = comparison.passes.as_slice() else { panic!("{comparison:?}") };
        assert!((shade.min_ratio - 2f64.sqrt()).abs() < 1e-12 && (shade.median_ratio - 0.75f64.sqrt()).abs() < 1e-12);
        assert_eq!(comparison.total(), None);
        assert_eq!(comparison.only_in_this.iter().map(|l| l.pass.as_deref()).collect::<Vec<_>>(), [Some("tiles")]);
        assert_eq!(
            comparison.only_in_that.iter().map(|l| (l.row.as_str(), l.pass.as_deref())).collect::<Vec<_>>(),
            [("gone", None)]
        );
        let text = comparison.to_string();
        for part in
            ["0.500 0.250", "1.414", "only in this run: t: a, 8x4, tiles", "only in the earlier run: t: gone, 8x4"]
        {
            assert!(text.contains(part), "{part}: {text}");
        }
    }

    #[test]
    fn a_run_against_itself_is_as_fast() {
        let run = times(vec![time("a", TOTAL, 2.0, 3.0), time("a", "sky", 0.0, 0.0)]);
        let comparison = run.compare(&run).unwrap();
        assert_eq!((comparison.total(), comparison.rows.len()), (Some(1.0), 1), "a time of 0 is not compared");
        assert!(comparison.only_in_this.is_empty() && comparison.only_in_that.is_empty());
    }

    #[test]
    fn other_rows_and_other_devices_are_refused() {
        let this = times(vec![time("a", TOTAL, 1.0, 1.0)]);
        let larger = times(vec![Time { size: [16, 8], ..time("a", TOTAL, 1.0, 1.0) }]);
        let fault = larger.compare(&this).unwrap_err().to_string();
        assert!(fault.contains("'t: a' at 16x8") && fault.contains("at 8x4") && !fault.contains('\n'), "{fault}");
        let fault = this.check_device("another").unwrap_err().to_string();
        assert!(fault.contains("a device") && fault.contains("another") && fault.contains("--any-device"), "{fault}");
        this.check_device("a device").unwrap();
    }

    #[test]
    fn non_bench_files_are_refused() {
        let row = r#"{"table": "t", "row": "r", "pass": "p", "size": [1, 2], "median_ms": 1, "min_ms": 1}"#;
        let bench = |rows: &str| {
            format!(r#"{{"command": "bench", "device": "d", "driver": "e", "commit": "c", "rows": {rows}}}"#)
        };
        assert_eq!(Times::parse(bench(&format!("[{row}]")).as_bytes()).unwrap().rows.len(), 1);
        let cases = [
            (String::new(), "ends too early"),
            (bench(&format!("[{row}]"))[..100].to_owned(), "ends too early, at line 1"),
            ("\u{89}PNG".to_owned(), "not JSON at line 1"),
            ("[1]".to_owned(), "not a JSON object"),
            ("{}".to_owned(), "no field command"),
            (r#"{"command": "capture\n"}"#.to_owned(), r"leadr capture\n"),
            (r#"{"command": "bench", "samples": []}"#.to_owned(), "no field rows"),
            (bench("[]"), "empty"),
            (bench("7"), "expected a sequence"),
            (bench(&format!("[{row}, {row}]")), "twice"),
            (bench(&format!("[{}]", row.replace(r#""min_ms": 1"#, r#""min_ms": -1"#))), "below 0"),
            (bench(&format!("[{}]", row.replace(r#", "min_ms": 1"#, ""))), "min_ms"),
            (bench(&format!("[{}]", row.replace("[1, 2]", "[-1, 2]"))), "-1"),
        ];
        for (text, reason) in cases {
            let fault = Times::parse(text.as_bytes()).expect_err(&text);
            assert!(fault.contains(reason) && !fault.contains('\n'), "{text}: {fault}");
        }
        let missing = Times::read(Path::new("missing.json")).unwrap_err().to_string();
        assert!(missing.contains("missing.json"), "{missing}");
    }
}
