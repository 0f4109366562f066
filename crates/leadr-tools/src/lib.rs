//! Shared code of the `leadr` and `leadr-lab` commands: image metrics, the bench, pictures of fits, HTML pages, results,
//! progress, errors and device flags.

pub mod bench;
pub mod command;
pub mod csv;
pub mod error;
pub mod fit;
pub mod html;
pub mod metrics;
pub mod program;
