//! The bench, which measures the time of every pass on the device in interleaved rounds.

mod against;
mod bases;
mod forward;
pub mod full_screen;
mod goals;
mod maps;
mod ocean;
mod quad;
mod report;
mod rounds;
mod rows;
mod run;
mod scale;
mod scene;
mod soak;
mod stats;

pub use against::{Comparison, Times};
pub use forward::{Forward, ForwardPass};
pub use quad::against_forward;
pub use report::BenchReport;
pub use run::{BenchConfig, FullScreen, Quad, bench};
pub use scene::Table;
pub use soak::{MemorySample, SoakReport, soak};
