//! The frame: what a renderer holds of a scene, what it prepares for one moment of it, and the passes in their order.
//!
//! [`Renderer::prepare`] makes a [`PreparedFrame`] of a state and settings, and only that can be drawn.

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
