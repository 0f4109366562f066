//! Floor 3 · the renderer: surfaces and light, the passes that draw them, and the frame that orders the passes.

pub mod camera;
pub mod constants;
pub mod frame;
pub mod light;
pub mod passes;
pub mod pixel_area;
pub mod sampling;
pub mod scene;
pub mod settings;
pub mod surfaces;
pub mod view;
