//! The sea as a surface: its waves, its mesh around the viewer, and its beach.

pub mod mesh;
pub mod shore;
pub mod waves;
