//! Tests of the mathematics against closed forms, quadrature and external values. No GPU needed.

mod base_roughness;
mod brdf;
mod distributions;
mod furnace;
mod oracles;
