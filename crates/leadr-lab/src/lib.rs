//! The laboratory of the project: a report that repeats the papers' experiments, studies of the quadrature rules, and reference ray casts.
//!
//! `cargo run --release -p leadr-lab -- report` measures everything again and writes one page.

pub mod command;
pub mod cracks;
pub mod energy_table;
pub mod extraction_study;
pub mod facet_walk;
pub mod least_squares;
pub mod multiscattering_study;
pub mod panorama_study;
pub mod quadrature_study;
pub mod ray_cast;
pub mod report;
pub mod shadowed_reference;
pub mod shadowing_errors;
