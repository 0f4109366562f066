//! The `leadr` command as scripts see it.

mod bake;
mod bench;
mod cli;
mod faults;
mod fit;
mod models;
mod readme;
