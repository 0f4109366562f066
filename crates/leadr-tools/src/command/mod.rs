//! Parts of commands: results and progress on the terminal, errors with their exit codes, files, flags of the device.

pub mod bars;
pub mod device;
pub mod error;
pub mod files;
pub mod output;
pub mod run;
