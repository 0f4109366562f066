//! The flags that several commands share, the values of these flags, and the flags that the user sets.

pub mod scene;
pub mod values;

use std::ffi::OsStr;

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command};
use leadr_scenes::given::CommandLine;

/// Returns those flags of `A` that the user has set, with their values.
pub fn given<A: Args>(matches: &ArgMatches) -> CommandLine {
    let mut line = CommandLine::default();
    for argument in A::augment_args(Command::new("given")).get_arguments() {
        let (id, Some(long)) = (argument.get_id().as_str(), argument.get_long()) else { continue };
        if matches.value_source(id) != Some(ValueSource::CommandLine) {
            continue;
        }
        let flag = format!("--{long}");
        if !argument.get_action().takes_values() {
            line.add(&flag, None);
            continue;
        }
        for occurrence in matches.get_raw_occurrences(id).into_iter().flatten() {
            let values: Vec<&OsStr> = occurrence.collect();
            line.add(&flag, Some(values.join(OsStr::new(","))));
        }
    }
    line
}
