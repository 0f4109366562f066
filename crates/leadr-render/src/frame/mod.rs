//! Frames: the scene data of a renderer, the preparation of a frame for one state, and the order of the passes.
//!
//! [`Renderer::prepare`] turns a state and settings into a [`PreparedFrame`]. No other type can be drawn.

mod cache;
mod drawing;
mod drawn_layers;
mod edge_samples;
mod layers;
mod pipelines;
mod pool;
mod prepare;
mod prepared;
mod record;
mod render;
mod renderer;
mod scene_set;
mod sky;
mod surfaces;
mod targets;
mod timing;

pub use layers::Layer;
pub use prepared::{PausedFrame, PreparedFrame};
pub use render::FrameOutput;
pub use renderer::KeptTargets;
pub use renderer::Renderer;
pub use timing::{CpuTime, FrameCost, MAX_PASSES, PassTime};
