//! The renderer: surfaces, light, render passes, and the frame that orders the passes.
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

/// Opens a device. The renderer's shaders and descriptor sets are added to the ones in `options`.
///
/// # Errors
/// Fails without a matching device, if the device lacks a required feature, or if a Vulkan call fails.
pub fn open_gpu(options: &GpuOptions) -> Result<Arc<Gpu>, GpuError> {
    let mut options = options.clone();
    options.shaders.push(leadr_shaders::SHADERS);
    options.sets.extend([&sets::SCENE, &sets::OBJECT]);
    Gpu::new(&options)
}
