//! `leadr report`: the tables, pictures and plots of the papers, measured again, on one page.

pub mod args;

use self::args::ReportArgs;
use crate::app::error::AppError;
use crate::app::output::Output;
use crate::lab::report::{ReportConfig, report};

/// Makes the report, writes it and prints its findings.
///
/// # Errors
/// A folder that cannot be written, no device, a lost device, a section that fails.
pub fn run(arguments: &ReportArgs, output: &Output) -> Result<(), AppError> {
    let config = ReportConfig {
        quick: arguments.quick,
        only: arguments.only.clone(),
        resume: arguments.resume,
        folder: arguments.output.clone(),
    };
    let summary = report(&config, || Ok(arguments.device.open()?), output)?;
    output.result(&summary)
}
