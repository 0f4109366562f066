//! The `leadr-lab` command line.

pub mod args;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{ArgMatches, CommandFactory, Parser, Subcommand};
use leadr_tools::command::error::AppError;
use leadr_tools::command::output::Output;
use leadr_tools::command::run::{OutputArgs, with_negative_numbers};
use leadr_tools::program;

use self::args::ReportArgs;
use crate::report::{ReportConfig, report};

/// Repeats the papers' experiments and measures the accuracy of the renderer.
#[derive(Debug, Parser)]
#[command(name = "leadr-lab", version, propagate_version = true, arg_required_else_help = true)]
struct Cli {
    /// The subcommand.
    #[command(subcommand)]
    command: Command,
    /// Output options.
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Repeat the papers' measurements and write them as one page of tables, pictures and plots
    #[command(after_help = args::EXAMPLES)]
    Report(ReportArgs),
}

/// Parses the command line (program name first), runs it and returns the exit code, like `leadr`.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    program::set_commit(env!("LEADR_COMMIT"));
    let work = |cli: Cli, _: &ArgMatches, output: &Output| match cli.command {
        Command::Report(arguments) => run_report(&arguments, output),
    };
    leadr_tools::command::run::run(with_negative_numbers(Cli::command()), arguments, |cli: &Cli| cli.output, work)
}

/// Builds the report, writes it and prints its findings.
fn run_report(arguments: &ReportArgs, output: &Output) -> Result<(), AppError> {
    let config = ReportConfig {
        quick: arguments.quick,
        only: arguments.only.clone(),
        resume: arguments.resume,
        folder: arguments.output.clone(),
    };
    let summary = report(&config, || Ok(arguments.device.open()?), output)?;
    output.result(&summary)
}
