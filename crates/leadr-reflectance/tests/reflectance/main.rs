//! The mathematics against closed forms, quadrature and values of other programs. Needs no device.

mod base_roughness;
mod brdf;
mod distributions;
mod furnace;
mod oracles;
