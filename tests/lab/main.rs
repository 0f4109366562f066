//! The laboratory: quadrature rules, ray casts, shadowing, the forward pass of the bench.

#[path = "../common/mod.rs"]
mod common;

mod forward;
mod painted;
mod quadrature;
mod ray_cast;
mod shadowing;
