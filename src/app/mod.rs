//! The `leadr` command. Each subcommand has a folder. The arguments of a subcommand are converted to a configuration of the library crates.
//! [`flags`] has the flags that several subcommands share.
//!
//! The result goes to stdout and the log to stderr. The exit code is 0 for success, 1 for a failure or an exceeded threshold, and 2 for
//! wrong usage.

pub mod bake;
pub mod bench;
pub mod capture;
mod cli;
pub mod compare;
#[cfg(feature = "window")]
pub mod demo;
pub mod fit;
pub mod flags;
mod install;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{ArgMatches, Args};
use leadr_tools::command::error::AppError;
use leadr_tools::command::output::Output;
use leadr_tools::program;

use capture::args::CaptureArgs;
use cli::{Cli, Command};
#[cfg(feature = "window")]
use flags::scene::SceneArgs;
use leadr_scenes::given::CommandLine;

/// Parses the command line (program name first), runs the subcommand, and reports an error in one line on stderr. Returns the exit code: 0
/// for success, 1 for a failure or an exceeded threshold, and 2 for wrong usage.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    program::set_commit(env!("LEADR_COMMIT"));
    leadr_tools::command::run::run(cli::command(), arguments, |cli: &Cli| cli.output, dispatch)
}

fn dispatch(cli: Cli, matches: &ArgMatches, output: &Output) -> Result<(), AppError> {
    match cli.command {
        Command::Capture(arguments) => capture::run(&arguments, given::<CaptureArgs>(matches), output),
        #[cfg(feature = "window")]
        Command::Demo(arguments) => demo::run(&arguments, given::<SceneArgs>(matches), output),
        Command::Bake(arguments) => bake::run(&arguments, output),
        Command::Fit(arguments) => fit::run(&arguments, output),
        Command::Bench(arguments) => bench::run(&arguments, output),
        Command::Compare(arguments) => compare::run(&arguments, output),
        Command::Completions(arguments) => install::completions(cli::command(), &arguments),
        Command::Man(arguments) => install::man(cli::command(), &arguments),
    }
}

/// Returns those flags of `A` that the user has set for the subcommand.
fn given<A: Args>(matches: &ArgMatches) -> CommandLine {
    matches.subcommand().map(|(_, matches)| flags::given::<A>(matches)).unwrap_or_default()
}
