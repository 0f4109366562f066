//! What the user sees: the result on stdout (text or one JSON object), log and progress on stderr.

use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use tracing_subscriber::EnvFilter;

use super::error::AppError;

/// Where a command reports to.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    json: bool,
    quiet: bool,
}

impl Output {
    /// `json`: the result is one JSON object. `quiet`: no progress, and no result either unless it is JSON.
    #[must_use]
    pub fn new(json: bool, quiet: bool) -> Self {
        Self { json, quiet }
    }

    /// Prints a command's result on stdout.
    ///
    /// # Errors
    /// If stdout cannot be written to. A reader that closed the pipe early is no error.
    pub fn result<R: Serialize + Display>(&self, result: &R) -> Result<(), AppError> {
        let text = if self.json {
            serde_json::to_string_pretty(result).map_err(|e| AppError::Failed(format!("cannot write JSON: {e}")))?
        } else if self.quiet {
            return Ok(());
        } else {
            result.to_string()
        };
        match writeln!(io::stdout(), "{text}") {
            Err(e) if e.kind() != ErrorKind::BrokenPipe => {
                Err(AppError::Failed(format!("cannot write to standard output: {e}")))
            }
            _ => Ok(()),
        }
    }

    /// Says on stderr what long work is at, unless quiet.
    pub fn say(&self, line: &str) {
        if !self.quiet {
            // Nobody to talk to is no failure.
            let _ = writeln!(io::stderr(), "{line}");
        }
    }

    /// A progress bar over `steps` steps; it draws only for work of several steps, on a terminal, unless quiet.
    #[must_use]
    pub fn progress(&self, steps: usize) -> ProgressBar {
        if self.quiet || steps < 2 || !io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let style = ProgressStyle::with_template("{bar:32} {pos}/{len} {wide_msg} {eta} left");
        ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::stderr())
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
    }
}

/// Sends `tracing` events to stderr: warnings (of the window library, errors), or errors alone if `quiet`, unless `LEADR_LOG` asks for something else
/// (`debug`, `leadr::gpu=trace`, …).
pub fn start_log(quiet: bool) {
    let default = if quiet { "error" } else { "warn,winit=error" };
    let filter = EnvFilter::try_from_env("LEADR_LOG").unwrap_or_else(|_| EnvFilter::new(default));
    // A second call (tests in one process) keeps the first subscriber.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(io::stderr)
        .with_ansi(io::stderr().is_terminal())
        .without_time()
        .try_init();
}
