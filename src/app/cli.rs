//! The command line: subcommands and the flags that they share.

use clap::{CommandFactory, Parser, Subcommand};
use leadr_tools::command::run::{OutputArgs, with_negative_numbers};

use super::bake::args::BakeArgs;
use super::bench::args::BenchArgs;
use super::capture::args::CaptureArgs;
use super::compare::args::CompareArgs;
#[cfg(feature = "window")]
use super::demo::args::DemoArgs;
use super::fit::args::FitArgs;
use super::{bake, bench, capture, compare, fit};

/// Renders displaced surfaces that look the same at any distance (LEADR mapping).
#[derive(Debug, Parser)]
#[command(name = "leadr", version, propagate_version = true, arg_required_else_help = true)]
#[command(after_help = "Exit codes: 0 success, 1 failed or over a threshold, 2 wrong usage.
Set the environment variable LEADR_LOG to error, warn, info, debug or trace to choose the detail of the log on stderr.")]
pub struct Cli {
    /// The subcommand.
    #[command(subcommand)]
    pub command: Command,
    /// How to print the result.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// Returns the clap declaration of the command line.
pub fn command() -> clap::Command {
    with_negative_numbers(Cli::command())
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Explore a scene in a window
    #[cfg(feature = "window")]
    #[command(after_help = super::demo::args::keys())]
    Demo(Box<DemoArgs>),
    /// Render a picture or a sequence to files, without a window
    #[command(after_help = capture::args::EXAMPLES)]
    Capture(Box<CaptureArgs>),
    /// Filter heights, normals or a material folder into maps with mip levels for other engines
    #[command(after_help = bake::args::EXAMPLES)]
    Bake(Box<BakeArgs>),
    /// Fit a microfacet model to a measured material: slopes, Fresnel term, roughness
    #[command(after_help = fit::args::EXAMPLES)]
    Fit(FitArgs),
    /// Time every pass on the GPU: the tables of the LEADR paper, and scenes at several distances
    #[command(after_help = bench::args::EXAMPLES)]
    Bench(Box<BenchArgs>),
    /// Measure the difference between two pictures: FLIP, relative RMSE, largest difference
    #[command(after_help = compare::args::EXAMPLES)]
    Compare(CompareArgs),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_declaration_is_consistent() {
        command().debug_assert();
    }

    #[test]
    fn flags_stand_under_headings_and_few_are_in_the_short_help() {
        for name in ["capture", "demo", "bench"] {
            let all = command();
            let Some(command) = all.find_subcommand(name) else { continue };
            for argument in command.get_arguments() {
                assert!(argument.get_help_heading().is_some(), "{name}: {argument} has no heading");
            }
            let common = command.get_arguments().filter(|argument| !argument.is_hide_short_help_set()).count();
            assert!((10..=30).contains(&common), "{name} -h has {common} flags");
        }
    }
}
