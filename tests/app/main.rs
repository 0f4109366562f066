//! The `leadr` command from scripts.

mod bake;
mod bench;
mod cli;
mod faults;
mod fit;
mod models;
mod readme;
