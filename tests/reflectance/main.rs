//! The mathematics against closed forms, quadrature and values of other programs. Needs no device.

#[path = "../common/mod.rs"]
mod common;

mod base_roughness;
mod brdf;
mod distributions;
mod furnace;
mod not_a_number;
mod oracles;
