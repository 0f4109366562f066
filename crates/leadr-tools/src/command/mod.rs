//! Shared code of commands, for results and progress on the terminal, errors with exit codes, files, and device flags.

pub mod bars;
pub mod device;
pub mod error;
pub mod files;
pub mod output;
pub mod run;
pub mod stop;
