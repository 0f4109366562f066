//! The bench: the time of every pass on the device, of rows that are measured alternately.

mod goals;
mod ocean;
mod report;
mod rounds;
mod rows;
mod run;
mod soak;
mod stats;

pub use report::BenchReport;
pub use run::{BenchConfig, Quad, bench};
pub use soak::{SoakReport, soak};
