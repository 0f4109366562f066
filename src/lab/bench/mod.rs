//! The bench: the time of every pass on the device, of rows that are measured alternately.

mod against;
mod goals;
mod maps;
mod ocean;
mod quad;
mod report;
mod rounds;
mod rows;
mod run;
mod scene;
mod soak;
mod stats;

pub use against::{Comparison, Times};
pub use report::BenchReport;
pub use run::{BenchConfig, Quad, bench};
pub use scene::Table;
pub use soak::{SoakReport, soak};
