//! The `leadr` command: everything it does is in [`leadr::app`].

use std::process::ExitCode;

fn main() -> ExitCode {
    leadr::app::run(std::env::args_os())
}
