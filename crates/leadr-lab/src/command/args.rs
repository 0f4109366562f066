//! The arguments of `leadr-lab report`.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::report::{SECTIONS, SectionEntry};
use leadr_tools::command::device::DeviceArgs;

/// Text below the help.
pub const EXAMPLES: &str = "Examples:
  leadr-lab report                                  everything, into out/report; takes half an hour without a GPU
  leadr-lab report --quick -o out/quick             everything, small, in minutes
  leadr-lab report --only convergence -o out/one    a single section";

/// Arguments of `leadr-lab report`.
#[derive(Clone, Debug, Args)]
pub struct ReportArgs {
    /// Small pictures and few samples
    #[arg(long)]
    pub quick: bool,
    /// Only these sections
    #[arg(long, value_name = "NAME,...", value_parser = sections(), value_delimiter = ',')]
    pub only: Vec<&'static SectionEntry>,
    /// Keep the sections that an earlier run of this build on this device left in the folder
    #[arg(long)]
    pub resume: bool,
    /// Folder of the report: index.html, report.json and the pictures
    #[arg(long, short, value_name = "DIR", default_value = "out/report")]
    pub output: PathBuf,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArgs,
}

fn sections() -> impl TypedValueParser<Value = &'static SectionEntry> {
    PossibleValuesParser::new(SECTIONS.iter().map(|section| PossibleValue::new(section.key).help(section.help)))
        .try_map(|key| SectionEntry::find(&key).ok_or("no such section"))
}
