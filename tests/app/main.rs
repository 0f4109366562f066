//! The `leadr` command from scripts.

mod bake;
mod bench;
mod cli;
mod faults;
mod fit;
mod foreign;
mod hard_times;
mod models;
mod readme;
