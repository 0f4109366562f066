//! The `leadr` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    leadr::command::run(std::env::args_os())
}
