//! Compares every function of the include library with its Rust twin, on arrays on the device.

mod chi_square;
mod parity;
mod sampling;
