//! The `leadr` command from scripts.

mod bake;
mod bench;
mod cli;
#[cfg(unix)]
mod corpus;
mod faults;
mod fit;
mod foreign;
mod hard_times;
mod models;
mod pictures;
mod readme;
