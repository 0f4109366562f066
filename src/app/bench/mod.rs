//! `leadr bench`: measures the time of every pass on the device. Optionally, it compares the times with an earlier run. With `--soak`, it
//! measures the memory use over many frames.

pub mod args;

use std::fmt;

use serde::Serialize;

use self::args::BenchArgs;
use leadr_maps::new_file::NewFile;
use leadr_scenes::file_kind::FileKind;
use leadr_tools::bench::{BenchConfig, BenchReport, Comparison, Times, bench, soak};
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::{begin, keep_inputs};
use leadr_tools::command::output::Output;

/// Runs the selected measurements and prints the report.
pub fn run(arguments: &BenchArgs, output: &Output) -> Result<(), AppError> {
    let config = arguments.resolve()?;
    if let Some(frames) = arguments.soak {
        return run_soak(arguments, &config, frames, output);
    }
    keep_inputs(arguments.csv.as_deref(), arguments.against.as_deref())?;
    // A run takes minutes, so an unwritable file is reported first.
    let table = arguments.csv.as_deref().map(begin).transpose()?;
    let Some(against) = &arguments.against else {
        let report = bench(&config, || Ok(arguments.device.open()?), output)?;
        write(table, &report)?;
        return output.result(&report);
    };
    let runs = [("--against", Some(against)), ("--measured", arguments.measured.as_ref())];
    for (flag, file) in runs.into_iter().filter_map(|(flag, file)| Some((flag, file?))) {
        FileKind::check(flag, file, &[FileKind::Result])?;
    }
    let earlier = Times::read(against)?;
    let check_device = |device: &str| if arguments.any_device { Ok(()) } else { earlier.check_device(device) };
    if let Some(measured) = &arguments.measured {
        let measured = Times::read(measured)?;
        check_device(measured.device())?;
        let comparison = earlier.compare(&measured)?;
        output.result(&ComparisonReport { command: "bench", against: &comparison })?;
        return check_ratio(&comparison, arguments.max_ratio);
    }
    // A run takes minutes, so errors that prevent the comparison are reported first.
    let open = || {
        let gpu = arguments.device.open()?;
        check_device(gpu.device_name())?;
        Ok(gpu)
    };
    let mut report = bench(&config, open, output)?;
    write(table, &report)?;
    let comparison = report.compare_with(&earlier).cloned();
    output.result(&report)?;
    check_ratio(&comparison?, arguments.max_ratio)
}

/// Writes the rows of a report as CSV, if a file is requested.
fn write(table: Option<NewFile>, report: &BenchReport) -> Result<(), AppError> {
    Ok(table.map_or(Ok(()), |file| file.write(report.csv().as_bytes()))?)
}

/// The result of a comparison of two files without measurement.
#[derive(Serialize)]
struct ComparisonReport<'a> {
    command: &'static str,
    against: &'a Comparison,
}

impl fmt::Display for ComparisonReport<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.against.fmt(f)
    }
}

fn check_ratio(comparison: &Comparison, most: Option<f32>) -> Result<(), AppError> {
    let Some(most) = most else { return Ok(()) };
    match comparison.total() {
        Some(ratio) if ratio <= f64::from(most) => Ok(()),
        Some(ratio) => {
            Err(AppError::Failed(format!("the total time is {ratio:.6} times that of the earlier run, over {most}")))
        }
        None => Err(AppError::Failed("--max-ratio cannot be checked: no row has a total in both runs".to_owned())),
    }
}

fn run_soak(arguments: &BenchArgs, config: &BenchConfig, frames: u32, output: &Output) -> Result<(), AppError> {
    let [scene] = config.scenes.as_slice() else {
        return Err(AppError::Usage("--soak needs exactly one scene: add --scene".into()));
    };
    let report = soak(scene, &arguments.device.open()?, frames, arguments.technique, output)?;
    output.result(&report)
}
