//! Flags that several commands share, and the values they take.

pub mod command_line;
pub mod scene;
pub mod values;
