//! The command line: subcommands and the flags that they share.

use clap::{CommandFactory, Parser, Subcommand};
use leadr_maps::cache::MapCache;
use leadr_maps::shown::shown_path;
use leadr_tools::command::run::{OutputArgs, with_negative_numbers};

use super::bake::args::BakeArgs;
use super::bench::args::BenchArgs;
use super::capture::args::CaptureArgs;
use super::compare::args::CompareArgs;
#[cfg(feature = "window")]
use super::demo::args::DemoArgs;
use super::fit::args::FitArgs;
use super::install::{CompletionsArgs, ManArgs};
use super::{bake, bench, capture, compare, fit};

/// Renders displaced surfaces that look the same at any distance (LEADR mapping).
#[derive(Debug, Parser)]
#[command(name = "leadr", propagate_version = true, arg_required_else_help = true)]
#[command(
    after_help = "Exit codes: 0 success, 1 failed or over a threshold, 2 wrong usage, 130 or 143 stopped by Ctrl-C or SIGTERM.
Set the environment variable LEADR_LOG to error, warn, info, debug or trace to choose the detail of the log on stderr."
)]
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
    with_negative_numbers(Cli::command()).version(version(false)).long_version(version(true))
}

/// Returns the version with its commit, and optionally the facts of the build that a report of a fault needs.
fn version(long: bool) -> String {
    let commit = match env!("LEADR_COMMIT") {
        // A package has no commit.
        "unknown" => String::new(),
        commit => format!(" ({commit})"),
    };
    let short = format!("{}{commit}", env!("CARGO_PKG_VERSION"));
    if !long {
        return short;
    }
    let (system, machine) = (std::env::consts::OS, std::env::consts::ARCH);
    let window = if cfg!(feature = "window") { "with" } else { "without" };
    let checks = if cfg!(debug_assertions) { "with" } else { "without" };
    let cache = MapCache::of_user().map_or_else(|| "none".to_owned(), |cache| shown_path(cache.folder()));
    format!("{short}\n{system} {machine}, {window} window, {checks} debug assertions\ncache: {cache}")
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Explore a scene in a window
    #[cfg(feature = "window")]
    #[command(after_help = super::demo::window::keys::text())]
    Demo(Box<DemoArgs>),
    /// Render a picture or a sequence to files, without a window
    #[command(after_help = capture::args::EXAMPLES)]
    Capture(Box<CaptureArgs>),
    /// Filter heights, normals, a material folder or the textures of a model into mip levels for other engines
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
    /// Print the completion script of a shell
    #[command(after_help = "Example: leadr completions bash > ~/.local/share/bash-completion/completions/leadr")]
    Completions(CompletionsArgs),
    /// Write the manual pages to a folder
    #[command(after_help = "Example: leadr man ~/.local/share/man/man1")]
    Man(ManArgs),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_declaration_is_consistent() {
        command().debug_assert();
    }

    #[test]
    fn the_version_has_the_facts_for_a_report() {
        let commit = env!("LEADR_COMMIT");
        let [short, long] = [version(false), version(true)];
        assert!(commit == "unknown" || short.ends_with(&format!("({commit})")), "{short}");
        for fact in [short.as_str(), std::env::consts::OS, std::env::consts::ARCH, "window", "cache: "] {
            assert!(long.contains(fact), "{fact}: {long}");
        }
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
