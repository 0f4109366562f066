//! Ends the process when it is stopped by Ctrl-C (SIGINT, exit code 130) or by SIGTERM (143): removes temporary files and prints one
//! line. Files that are complete stay. A second signal ends the process at once.

use std::sync::{Mutex, PoisonError};

use super::error::AppError;

/// How far the work has come, for the line.
static REACHED: Mutex<String> = Mutex::new(String::new());

/// Sets how far the work has come, such as `after frame 12`.
pub fn reached(text: String) {
    *REACHED.lock().unwrap_or_else(PoisonError::into_inner) = text;
}

/// Handles the signals from now on, in a separate thread. `name` is the program's name.
///
/// # Errors
/// If the system refuses the thread or the handlers.
#[cfg(unix)]
pub(super) fn listen(name: &str) -> Result<(), AppError> {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::flag::register_conditional_default;
    use signal_hook::iterator::Signals;

    let refused =
        |fault: std::io::Error| AppError::Failed(format!("cannot handle signals ({fault}): restart the program"));
    let stopping = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        register_conditional_default(signal, stopping.clone()).map_err(refused)?;
    }
    let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(refused)?;
    let name = name.to_owned();
    let wait = move || {
        if let Some(signal) = signals.forever().next() {
            stopping.store(true, Ordering::SeqCst);
            end(&name, 128 + signal);
        }
    };
    std::thread::Builder::new().spawn(wait).map(drop).map_err(super::run::no_thread)
}

#[cfg(not(unix))]
pub(super) fn listen(_: &str) -> Result<(), AppError> {
    Ok(())
}

#[cfg(unix)]
fn end(name: &str, code: i32) {
    use std::io::IsTerminal;

    leadr_maps::new_file::abandon_all();
    // A progress bar may stand in the line.
    let clear = if std::io::stderr().is_terminal() { "\r\x1b[2K" } else { "" };
    let reached = REACHED.lock().unwrap_or_else(PoisonError::into_inner);
    let line = leadr_maps::shown::shown_line(format!("{name}: stopped {reached}").trim_end());
    super::output::print_error_line(&format!("{clear}{line}"));
    // Other threads still use the device, so nothing is unloaded.
    signal_hook::low_level::exit(code);
}
