//! `leadr fit`: fits a microfacet model to measured materials.

pub mod args;
mod coat;
mod export;
mod file;
mod fitted;
mod folder;
mod page;
mod report;
mod targets;

use self::args::FitArgs;
use leadr_tools::command::error::AppError;
use leadr_tools::command::output::Output;

/// Fits a material, or every material of a folder, and writes the requested files.
pub fn run(arguments: &FitArgs, output: &Output) -> Result<(), AppError> {
    if arguments.input.is_dir() { folder::run(arguments, output) } else { file::run(arguments, output) }
}
