//! Runs a program, from the command line to the exit code.

use std::ffi::OsString;
use std::fmt::Display;
use std::process::ExitCode;
use std::sync::OnceLock;

use clap::builder::Resettable;
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
            return fail(&name, &AppError::Usage(usage_fault(&command, &arguments, &fault)));
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

/// Returns the sentence for a command line that clap refuses.
fn usage_fault(command: &clap::Command, arguments: &[OsString], fault: &clap::Error) -> String {
    let sentence = missing_sentence(command, arguments, fault).or_else(|| elsewhere_sentence(fault));
    sentence.unwrap_or_else(|| usage_sentence(command.get_name(), fault))
}

/// Returns a sentence for a missing argument, which names the given flags that need it.
fn missing_sentence(command: &clap::Command, arguments: &[OsString], fault: &clap::Error) -> Option<String> {
    let missing = missing_arguments(fault)?;
    let words: Vec<&str> = arguments.iter().filter_map(|word| word.to_str()).collect();
    let subcommand = words.iter().find_map(|word| command.find_subcommand(word));
    let of_command = || subcommand.unwrap_or(command).get_arguments();
    let list = |names: &[String]| names.join(" and ");
    let always: Vec<String> = of_command().filter(|flag| flag.is_required_set()).map(Arg::to_string).collect();
    let (always, needed): (Vec<String>, Vec<String>) = missing.into_iter().partition(|name| always.contains(name));
    if needed.is_empty() {
        return Some(format!("{} is missing: add it (see --help)", list(&always)));
    }
    // clap does not tell which flag has the requirement, so each given flag is tried as the only flag with requirements.
    let needs = |flag: &str| {
        let alone = |known: Arg| if known.get_long() == Some(flag) { known } else { known.requires(Resettable::Reset) };
        let trial = match subcommand {
            Some(subcommand) => {
                command.clone().mut_subcommand(subcommand.get_name(), |command| command.mut_args(alone))
            }
            None => command.clone().mut_args(alone),
        };
        let missing = trial.try_get_matches_from(arguments).err().and_then(|fault| missing_arguments(&fault));
        missing.is_some_and(|missing| needed.iter().any(|name| missing.contains(name)))
    };
    let given = |flag: &&str| words.iter().any(|word| word.split('=').next() == Some(&format!("--{flag}")));
    let flags = of_command().filter_map(Arg::get_long).filter(given).filter(|flag| needs(flag));
    let flags: Vec<String> = flags.map(|flag| format!("--{flag}")).collect();
    let need = if flags.len() > 1 { "need" } else { "needs" };
    Some(format!("{} {need} {}: add it (see --help)", list(&flags), list(&needed)))
}

/// Returns the arguments that an error calls missing.
fn missing_arguments(fault: &clap::Error) -> Option<Vec<String>> {
    match fault.get(ContextKind::InvalidArg) {
        Some(ContextValue::Strings(missing)) if fault.kind() == ErrorKind::MissingRequiredArgument => {
            Some(missing.clone())
        }
        _ => None,
    }
}

/// Subcommands that a build lacks or that belong to another program, and the remedy.
const ELSEWHERE: [(&str, &str); 2] = [
    ("demo", "this build has no window: use leadr capture, or build with cargo build --release --features window"),
    ("report", "the report is a command of the laboratory: use cargo run --release -p leadr-lab -- report"),
];

/// Returns a sentence for a subcommand that exists elsewhere.
fn elsewhere_sentence(fault: &clap::Error) -> Option<String> {
    let Some(ContextValue::String(name)) = fault.get(ContextKind::InvalidSubcommand) else { return None };
    ELSEWHERE.iter().find(|(known, _)| known == name).map(|(name, remedy)| format!("{name}: {remedy}"))
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
    format!("{} (see --help)", sentence.replace(" tip: ", "; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sentence(line: &str) -> String {
        let flag = |name: &'static str| Arg::new(name).long(name);
        let draw = clap::Command::new("draw").args([
            flag("size"),
            flag("split").requires("beside"),
            flag("label").requires("beside"),
            flag("beside").value_name("NAME"),
            flag("fps").requires("frames"),
            flag("frames"),
        ]);
        let mut command = clap::Command::new("leadr").subcommand(draw);
        let arguments: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        let fault = command.try_get_matches_from_mut(&arguments).unwrap_err();
        usage_fault(&command, &arguments, &fault)
    }

    #[test]
    fn only_flags_with_a_requirement_are_named() {
        for (line, expected) in [
            ("leadr draw --size 8 --split 1", "--split needs --beside <NAME>: add it (see --help)"),
            ("leadr draw --fps=24 --size 8", "--fps needs --frames <frames>: add it (see --help)"),
            (
                "leadr draw --split 1 --label 2 --size 8",
                "--split and --label need --beside <NAME>: add it (see --help)",
            ),
        ] {
            assert_eq!(sentence(line), expected);
        }
    }

    #[test]
    fn tips_are_separate_and_commands_elsewhere_are_named() {
        let misspelt = sentence("leadr draw --sise 8");
        assert!(misspelt.contains("found; a similar argument exists: '--size' (see --help)"), "{misspelt}");
        assert!(sentence("leadr demo").contains("leadr capture") && sentence("leadr demo").contains("window"));
        assert!(sentence("leadr report --quick").contains("cargo run --release -p leadr-lab -- report"));
    }
}
