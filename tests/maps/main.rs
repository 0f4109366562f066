//! Loading and saving files, and the cost of damaged ones.

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod images;
