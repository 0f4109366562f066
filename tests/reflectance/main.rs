//! The mathematics against closed forms, quadrature and values computed elsewhere. Needs no device.

#[path = "../common/mod.rs"]
mod common;

mod brdf;
mod distributions;
mod furnace;
mod oracles;
