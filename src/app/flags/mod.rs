//! Flags that several commands share, and the values they take.

pub mod command_line;
pub mod dress;
pub mod scene;
pub mod shading;
pub mod values;
pub mod waves;
