//! What the `leadr` command and the laboratory share: metrics of pictures, the bench, fits as pictures, HTML pages, and
//! the parts of a command (results, progress, errors, flags of the device).

pub mod bench;
pub mod command;
pub mod error;
pub mod fit;
pub mod html;
pub mod metrics;
pub mod program;
