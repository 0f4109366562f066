//! Tests the mathematics against closed forms, quadrature and external values. The tests need no GPU.

mod base_roughness;
mod brdf;
mod distributions;
mod furnace;
mod oracles;
