//! The laboratory: quadrature rules, ray casts, shadowing.

#[path = "../common/mod.rs"]
mod common;

mod quadrature;
mod ray_cast;
mod shadowing;
