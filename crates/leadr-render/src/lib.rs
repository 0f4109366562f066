//! The renderer, with its surfaces, light and render passes, and the frame that runs the passes in order.
//!
//! [`open_gpu`] opens a device with the renderer's shaders. A [`frame::Renderer`] draws a [`scene::FrameState`] of
//! [`scene::Object`]s under an [`light::environment::Environment`].

pub mod camera;
pub mod frame;
pub mod light;
pub mod passes;
pub mod pixel_area;
pub mod sampling;
pub mod scene;
pub mod sets;
pub mod settings;
pub mod surfaces;
pub mod view;

use std::sync::Arc;

use leadr_gpu::{Gpu, GpuError, GpuOptions};
pub use leadr_shaders::constants;

/// Opens a device. The shaders and descriptor sets of the renderer are added to those in `options`.
///
/// # Errors
/// Returns an error if no device matches, if the device lacks a required feature, or if a Vulkan call fails.
pub fn open_gpu(options: &GpuOptions) -> Result<Arc<Gpu>, GpuError> {
    let mut options = options.clone();
    options.shaders.push(leadr_shaders::SHADERS);
    options.sets.extend([&sets::SCENE, &sets::OBJECT]);
    Gpu::new(&options)
}
