//! Runs a program, from the command line to the exit code.

use std::ffi::OsString;
use std::fmt::Display;
use std::process::ExitCode;
use std::sync::OnceLock;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgMatches, Args, FromArgMatches};

use super::error::AppError;
use super::output::{self, Output};
use super::stop;
use leadr_maps::shown::shown_line;

/// Flags of every command.
#[derive(Clone, Copy, Debug, Args)]
pub struct OutputArgs {
    /// Print the result as one JSON object on stdout
    #[arg(long, global = true, help_heading = "Output", display_order = 900)]
    pub json: bool,
    /// Print no progress and no text result; errors and --json output remain
    #[arg(long, short, global = true, help_heading = "Output", display_order = 901)]
    pub quiet: bool,
}

/// Makes all flags of a program accept negative numbers. An error is then about the number instead of an unknown flag.
pub fn with_negative_numbers(command: clap::Command) -> clap::Command {
    let negative = |flag: Arg| {
        if flag.get_action().takes_values() { flag.allow_negative_numbers(true) } else { flag }
    };
    command.mut_subcommands(|command| command.mut_args(negative))
}

/// Parses the command line (program name first), does the work, and reports an error in one line on stderr. Returns the exit
/// code: 0 success, 1 failed or over a threshold, 2 wrong usage. A process that is stopped ends with 130 or 143 ([`stop`]).
pub fn run<C: FromArgMatches>(
    command: clap::Command,
    arguments: impl IntoIterator<Item = OsString>,
    output: impl FnOnce(&C) -> OutputArgs,
    work: impl FnOnce(C, &ArgMatches, &Output) -> Result<(), AppError>,
) -> ExitCode {
    let name = command.get_name().to_owned();
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let mut command = command;
    let parsed = command.try_get_matches_from_mut(&arguments);
    let (matches, cli) = match parsed.and_then(|matches| Ok((C::from_arg_matches(&matches)?, matches))) {
        Ok((cli, matches)) => (matches, cli),
        Err(fault) if matches!(fault.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            return output::check_stdout(fault.print())
                .map_or_else(|fault| fail(&name, &fault), |()| ExitCode::SUCCESS);
        }
        Err(fault) => {
            let sentence = missing_sentence(&command, &arguments, &fault);
            let sentence = sentence.unwrap_or_else(|| usage_sentence(&name, &fault));
            return fail(&name, &AppError::Usage(sentence));
        }
    };
    let OutputArgs { json, quiet } = output(&cli);
    output::start_log(quiet);
    let started = start_threads().and_then(|()| stop::listen(&name));
    match started.and_then(|()| work(cli, &matches, &Output::new(json, quiet))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(&name, &error),
    }
}

/// Starts the threads that share the work. Without this, the first use of the threads would panic if the system refused them.
fn start_threads() -> Result<(), AppError> {
    static STARTED: OnceLock<Result<(), String>> = OnceLock::new();
    let start = || rayon::ThreadPoolBuilder::new().build_global().map_err(|fault| fault.to_string());
    STARTED.get_or_init(start).as_ref().copied().map_err(no_thread)
}

/// The error of a system that refuses a thread.
pub(super) fn no_thread(fault: impl Display) -> AppError {
    AppError::Failed(format!(
        "the system refuses another thread ({fault}): raise its limits (ulimit -u and -v), end other programs, or set \
         RAYON_NUM_THREADS=1"
    ))
}

fn fail(name: &str, error: &AppError) -> ExitCode {
    // Messages of libraries may have several lines, but scripts expect one line.
    let sentence = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    output::print_error_line(&shown_line(&format!("{name}: error: {sentence}")));
    ExitCode::from(error.exit_code())
}

/// Returns a sentence for a missing argument, which names the given flags if one of them needs it.
fn missing_sentence(command: &clap::Command, arguments: &[OsString], fault: &clap::Error) -> Option<String> {
    let Some(ContextValue::Strings(missing)) = fault.get(ContextKind::InvalidArg) else { return None };
    if fault.kind() != ErrorKind::MissingRequiredArgument {
        return None;
    }
    let words: Vec<&str> = arguments.iter().filter_map(|word| word.to_str()).collect();
    let command = words.iter().find_map(|word| command.find_subcommand(word)).unwrap_or(command);
    let always = |argument: &&String| {
        let required = command.get_arguments().filter(|known| known.is_required_set());
        required.map(Arg::to_string).any(|known| known == **argument)
    };
    let list = |names: &[&String]| names.iter().map(|name| name.as_str()).collect::<Vec<_>>().join(" and ");
    let (always, needed): (Vec<&String>, Vec<&String>) = missing.iter().partition(always);
    if needed.is_empty() {
        return Some(format!("{} is missing: add it (see --help)", list(&always)));
    }
    let flags = command.get_arguments().filter_map(|known| known.get_long().map(|long| format!("--{long}")));
    let given = |flag: &String| words.iter().any(|word| word.split('=').next() == Some(flag));
    let given: Vec<String> = flags.filter(given).collect();
    let which = if given.len() > 1 { "one of " } else { "" };
    Some(format!("{which}{} needs {}: add it (see --help)", given.join(", "), list(&needed)))
}

/// Returns clap's error message without colours, usage lines and line breaks.
fn usage_sentence(name: &str, fault: &clap::Error) -> String {
    let text = fault.render().to_string();
    let lines = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let sentence = lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
    let sentence = sentence.trim_start_matches("error: ").trim_end_matches(" For more information, try '--help'.");
    if fault.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return format!("no command given (see {name} --help)");
    }
    format!("{sentence} (see --help)")
}
