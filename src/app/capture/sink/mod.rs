//! Where the frames of a capture go: a file for each, or one file of all of them.

mod frame_sink;
mod open;
mod sheet;
mod stills;
mod webp;
mod y4m;

pub use frame_sink::Earlier;
pub use open::open;

#[cfg(test)]
mod tests;
