//! Files in and out, and what damaged files cost.

#[path = "../common/mod.rs"]
mod common;

mod bad_input;
mod images;
