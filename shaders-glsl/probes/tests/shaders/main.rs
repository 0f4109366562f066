//! Every function of the include library against its Rust counterpart, run over arrays on the device.

mod chi_square;
mod parity;
mod sampling;
