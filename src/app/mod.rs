//! Floor 6 · the `leadr` command. Each command has a folder with its arguments, which resolve to a configuration that lower floors
//! understand; flags that several commands share are in [`flags`].
//!
//! stdout carries the result, stderr the log. Exit codes: 0 done, 1 failed or over a threshold, 2 wrong usage.

pub mod bake;
pub mod bench;
pub mod capture;
mod cli;
pub mod compare;
#[cfg(feature = "window")]
pub mod demo;
pub mod error;
mod files;
pub mod fit;
pub mod flags;
pub mod output;
mod progress;
pub mod report;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{ArgMatches, Args, FromArgMatches};

use capture::args::CaptureArgs;
use cli::{Cli, Command};
use error::AppError;
use flags::command_line::CommandLine;
#[cfg(feature = "window")]
use flags::scene::SceneArgs;
use output::Output;

/// Parses the command line (program name first), does the work, reports errors in one line on stderr and returns
/// the exit code: 0 done, 1 failed or over a threshold, 2 wrong usage.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let parsed = cli::command().try_get_matches_from(arguments);
    let (matches, cli) = match parsed.and_then(|matches| Ok((Cli::from_arg_matches(&matches)?, matches))) {
        Ok((cli, matches)) => (matches, cli),
        Err(fault) if matches!(fault.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            // A closed pipe (`leadr --help | head -1`) is no failure.
            let _ = fault.print();
            return ExitCode::SUCCESS;
        }
        Err(fault) => return fail(&AppError::Usage(usage_sentence(&fault))),
    };
    output::start_log(cli.output.quiet);
    match dispatch(cli, &matches) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(&error),
    }
}

fn dispatch(cli: Cli, matches: &ArgMatches) -> Result<(), AppError> {
    let output = Output::new(cli.output.json, cli.output.quiet);
    match cli.command {
        Command::Capture(arguments) => capture::run(&arguments, given::<CaptureArgs>(matches), &output),
        #[cfg(feature = "window")]
        Command::Demo(arguments) => demo::run(&arguments, given::<SceneArgs>(matches), &output),
        Command::Bake(arguments) => bake::run(&arguments, &output),
        Command::Fit(arguments) => fit::run(&arguments, &output),
        Command::Bench(arguments) => bench::run(&arguments, &output),
        Command::Compare(arguments) => compare::run(&arguments, &output),
        Command::Report(arguments) => report::run(&arguments, &output),
    }
}

/// The flags among those of `A` that the command was given.
fn given<A: Args>(matches: &ArgMatches) -> CommandLine {
    matches.subcommand().map(|(_, matches)| CommandLine::given::<A>(matches)).unwrap_or_default()
}

fn fail(error: &AppError) -> ExitCode {
    // Messages from libraries may span lines; scripts expect one.
    let sentence = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    eprintln!("leadr: error: {sentence}");
    ExitCode::from(error.exit_code())
}

/// clap's message without its colours, usage lines and line breaks.
fn usage_sentence(fault: &clap::Error) -> String {
    let text = fault.render().to_string();
    let lines = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let sentence = lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
    let sentence = sentence.trim_start_matches("error: ").trim_end_matches(" For more information, try '--help'.");
    if fault.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return "no command given (see leadr --help)".to_owned();
    }
    format!("{sentence} (see --help)")
}
