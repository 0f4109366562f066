//! Shared code of the `leadr` command and `leadr-lab`: image metrics, the bench, pictures of fits, HTML pages, and shared code of
//! commands (results, progress, errors, device flags).

pub mod bench;
pub mod command;
pub mod error;
pub mod fit;
pub mod html;
pub mod metrics;
pub mod program;
