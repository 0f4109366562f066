//! The output of a command. The result goes to stdout (as text or one JSON object), and log and progress go to stderr.

use std::fmt::{self, Debug, Display};
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::time::Instant;

use serde::Serialize;
use tracing_subscriber::field::MakeExt as _;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::format::{Writer, debug_fn};
use tracing_subscriber::layer::{Layer as _, SubscriberExt as _};
use tracing_subscriber::util::SubscriberInitExt as _;

use super::bars::{Bar, EVERY};
use super::error::AppError;
use crate::program::Stamped;
use leadr_maps::shown::{shown, shown_json, shown_line, shown_lines, shown_path};
use leadr_scenes::set::SetUp;

/// The output settings of a command.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    json: bool,
    quiet: bool,
}

impl Output {
    /// Creates the settings. With `json`, the result is one JSON object. With `quiet`, progress and text results are not
    /// printed.
    pub fn new(json: bool, quiet: bool) -> Self {
        Self { json, quiet }
    }

    /// Whether the result is one JSON object.
    pub fn is_json(&self) -> bool {
        self.json
    }

    /// Prints the result of a command to stdout.
    ///
    /// # Errors
    /// Fails if stdout cannot be written. A closed pipe is not an error.
    pub fn result<R: Serialize + Display>(&self, result: &R) -> Result<(), AppError> {
        let text = if self.json {
            let json = serde_json::to_string_pretty(&Stamped::new(result));
            shown_json(&json.map_err(|e| AppError::Failed(format!("cannot write JSON: {e}")))?)
        } else if self.quiet {
            return Ok(());
        } else {
            shown_lines(&result.to_string())
        };
        print_line(&text)
    }

    /// Prints the summary of a command that writes files, as one JSON object on stdout or as a line on stderr. Without JSON,
    /// stdout contains the names of the files ([`file`](Self::file)).
    ///
    /// # Errors
    /// Fails if stdout cannot be written. A closed pipe is not an error.
    pub fn summary<R: Serialize + Display>(&self, summary: &R) -> Result<(), AppError> {
        if self.json {
            return self.result(summary);
        }
        self.say(&summary.to_string());
        Ok(())
    }

    /// Prints the name of a completed file to stdout, so that scripts can process it while further files are written. Prints
    /// nothing if quiet or with JSON, because the JSON object contains the name. Hides `bar` while printing.
    ///
    /// # Errors
    /// Fails if stdout cannot be written. A closed pipe is not an error.
    pub fn file(&self, path: &Path, bar: &Bar) -> Result<(), AppError> {
        if self.json || self.quiet {
            return Ok(());
        }
        bar.suspended(|| print_line(&shown_path(path)))
    }

    /// Prints a line to stderr, unless quiet.
    pub fn say(&self, line: &str) {
        if !self.quiet {
            print_error_line(&shown_lines(line));
        }
    }

    /// Creates a bar with this many steps (0 if unknown) for the work `what`, such as "baking heights". It is drawn on a terminal,
    /// printed as lines elsewhere, and hidden if quiet.
    pub fn bar(&self, steps: usize, what: &str) -> Bar {
        if self.quiet {
            Bar::hidden()
        } else if io::stderr().is_terminal() {
            Bar::on_terminal(steps, what)
        } else {
            Bar::in_lines(steps, what, EVERY, io::stderr())
        }
    }

    /// Creates a bar with the message `what`, for work that reports its finished fraction from 0 to 1. If `what` is `None`,
    /// no bar is created.
    pub fn share(&self, what: Option<&str>) -> impl Fn(f32) + Sync + use<> {
        let bar = what.map_or_else(Bar::hidden, |what| self.bar(SHARES, what));
        move |share| bar.at(shares(share))
    }

    /// Creates a bar for the set-up of a scene.
    pub fn set_up(&self) -> impl Fn(SetUp) + Sync + use<> {
        let bar = self.bar(SHARES, "reading files");
        let begun = Instant::now();
        move |step| match step {
            SetUp::Begins(what) => {
                tracing::debug!("{what}, {:.3} s after the start", begun.elapsed().as_secs_f64());
                bar.restart(SHARES);
                bar.message(what);
            }
            SetUp::Share(share) => bar.at(shares(share)),
        }
    }
}

/// The number of steps of a bar that shows a fraction.
const SHARES: usize = 1000;

fn shares(share: f32) -> usize {
    (share * SHARES as f32) as usize
}

/// Prints a line to stderr. A closed or full stderr is not an error, because there is nowhere to report it.
pub(super) fn print_error_line(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// Checks the result of writing to stdout. A pipe that its reader closed early is not an error.
pub(super) fn check_stdout(written: io::Result<()>) -> Result<(), AppError> {
    match written.and_then(|()| io::stdout().flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(AppError::Failed(format!("cannot write to standard output: {e}")))
        }
        _ => Ok(()),
    }
}

fn print_line(text: &str) -> Result<(), AppError> {
    check_stdout(writeln!(io::stdout(), "{text}"))
}

/// Sends the log to stderr. The log has warnings, but only errors from the window library, and only errors if `quiet`. `LEADR_LOG`
/// overrides these levels (`debug`, `leadr_gpu=trace`, …).
pub fn start_log(quiet: bool) {
    let default = if quiet { "error" } else { "warn,winit=error" };
    let requested = std::env::var("LEADR_LOG").ok().filter(|levels| !levels.is_empty());
    let levels = requested.as_deref().unwrap_or(default);
    let filter = log_levels(levels);
    let filter = filter.unwrap_or_else(|fault| {
        let levels = shown(levels);
        print_error_line(&shown_line(&format!(
            "leadr: LEADR_LOG={levels}: {fault}; use error, warn, info, debug, trace or leadr_gpu=debug"
        )));
        default.parse().expect("the defaults are levels")
    });
    let log = tracing_subscriber::fmt::layer()
        .with_writer(io::stderr)
        // A log that cannot be written is not reported on the same stderr.
        .log_internal_errors(false)
        .fmt_fields(debug_fn(write_field).delimited(" "))
        .with_ansi(io::stderr().is_terminal())
        .without_time()
        .with_filter(filter);
    // A second call in the same process, as in tests, has no effect.
    let _ = tracing_subscriber::registry().with(log).try_init();
}

/// Writes a field of a log event. Its text may come from files and drivers.
fn write_field(to: &mut Writer<'_>, field: &tracing::field::Field, value: &dyn Debug) -> fmt::Result {
    let value = shown_line(&format!("{value:?}"));
    if field.name() == "message" { write!(to, "{value}") } else { write!(to, "{}={value}", field.name()) }
}

/// Parses levels for everything and for modules, such as `warn,leadr_gpu=debug`.
fn log_levels(text: &str) -> Result<Targets, String> {
    // A single word must be a level, because `Targets` would accept a misspelt level as a module name.
    let odd = text.split(',').find(|word| !word.contains('=') && word.trim().parse::<LevelFilter>().is_err());
    match odd {
        Some(word) => Err(format!("\"{}\" is not a level", shown(word))),
        None => text.parse::<Targets>().map_err(|fault| fault.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::log_levels;

    #[test]
    fn log_levels_parse_and_misspellings_are_reported() {
        for good in ["warn", "off", "warn,winit=error", "leadr_gpu=debug", "info, leadr=trace"] {
            assert!(log_levels(good).is_ok(), "{good}");
        }
        for bad in ["wran", "leadr=loud", "warn,leadr_gpu"] {
            assert!(log_levels(bad).is_err(), "{bad}");
        }
        assert_eq!(log_levels("wran").unwrap_err(), "\"wran\" is not a level");
    }
}
