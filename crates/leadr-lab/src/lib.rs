//! The measurements of the project. A report repeats the papers' experiments, studies measure the quadrature rules, and ray
//! casts give references.
//!
//! `cargo run --release -p leadr-lab -- report` repeats all measurements of the report and writes one page.

pub mod brdf_fit_study;
pub mod command;
pub mod cracks;
pub mod energy_table;
pub mod extraction_study;
pub mod facet_walk;
pub mod hard_edges;
pub mod least_squares;
pub mod multiscattering_study;
pub mod normal_forms_study;
pub mod oren_nayar_study;
pub mod panorama_study;
pub mod quadrature_study;
pub mod ray_cast;
pub mod relaxation;
pub mod relief;
pub mod report;
pub mod shadowed_reference;
pub mod shadowing_errors;
