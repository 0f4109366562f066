//! The `leadr` command as scripts see it.

#[path = "../common/mod.rs"]
mod common;

mod bake;
mod bench;
mod cli;
mod faults;
mod fit;
mod models;
mod readme;
mod report;
