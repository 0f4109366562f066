//! The command line: its commands, and the flags that all of them have.

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

/// Renders displaced surfaces that keep their look at every distance (LEADR mapping).
#[derive(Debug, Parser)]
#[command(name = "leadr", version, propagate_version = true, arg_required_else_help = true)]
#[command(after_help = "Exit codes: 0 done, 1 failed or over a threshold, 2 wrong usage.
Set LEADR_LOG (error, warn, info, debug, trace) for a longer log on stderr.")]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// How to report it.
    #[command(flatten)]
    pub output: OutputArgs,
}

/// The declaration of the command line.
pub fn command() -> clap::Command {
    with_negative_numbers(Cli::command())
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Explore a scene in a window
    #[cfg(feature = "window")]
    #[command(after_help = super::demo::args::keys())]
    Demo(Box<DemoArgs>),
    /// Render a picture or a sequence without a window
    #[command(after_help = capture::args::EXAMPLES)]
    Capture(Box<CaptureArgs>),
    /// Filter heights, normals or a material's folder into maps with mip levels for other engines
    #[command(after_help = bake::args::EXAMPLES)]
    Bake(Box<BakeArgs>),
    /// Find the facets that a measured material could be made of: slopes, Fresnel term, roughness
    #[command(after_help = fit::args::EXAMPLES)]
    Fit(FitArgs),
    /// Time every pass on the device: the paper's tables, scenes near and far, with ratios
    #[command(after_help = bench::args::EXAMPLES)]
    Bench(Box<BenchArgs>),
    /// Measure the difference of two pictures: FLIP, relative RMSE, largest difference
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
