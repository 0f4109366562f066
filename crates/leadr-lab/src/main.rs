//! The `leadr-lab` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    leadr_lab::command::run(std::env::args_os())
}
