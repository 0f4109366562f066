//! Floor 2 · Vulkan, and nothing else: device, memory, images, pipelines, commands, timing. Knows no BRDF.
//!
//! # The API at a glance
//!
//! ```no_run
//! use leadr::gpu::{Buffer, ComputePipeline, Descriptor, Gpu, GpuOptions, Memory, Use};
//!
//! # fn main() -> leadr::gpu::Result<()> {
//! let gpu = Gpu::new(&GpuOptions { validation: true, ..Default::default() })?; // Arc<Gpu>
//! let double = ComputePipeline::new(&gpu, "probes/selftest/selftest.comp", &[])?;
//! let input = Buffer::from_slice(&gpu, "input", &[1.0f32, 2.0, 3.0])?;
//! let output = Buffer::new(&gpu, "output", 12, Memory::Device)?;
//! gpu.submit("double", |cmd| {
//!     cmd.bind(&double, &[(0, Descriptor::Storage(&input)), (1, Descriptor::Storage(&output))]);
//!     cmd.push_constants(&3u32);
//!     cmd.dispatch_invocations(&double, [3, 1, 1]);
//! })?; // waits
//! let values: Vec<f32> = output.read_all()?;
//! # Ok(())
//! # }
//! ```
//!
//! - **Shaders** are entry points `shaders-glsl/{passes,probes}/**/*.{vert,tesc,tese,frag,comp}`, compiled by `build.rs`
//!   and named by their path: `"passes/shade.frag"`. `#include "leadr/x.glsl"` works everywhere. All descriptors are in
//!   set 0, none are arrays; layouts come from the shaders.
//! - **[`Buffer`]**: `new(gpu, name, bytes, Memory::{Device, Upload, Readback})`, `from_slice(gpu, name, &data)`,
//!   `write(offset, &data)`, `read(offset, count)`, `read_all()`.
//! - **[`Image`]**: `new(gpu, name, ImageDesc::new(format, w, h).full_mips().layers(n).cube().storage().color_target()
//!   .depth_target())`, `write(mip, layer, &texels)`, `read(mip, layer)`; views `whole()`, `mip_layer(mip, layer)`,
//!   `mip_array(mip)`, `array()`.
//! - **[`Sampler`]**: `new(gpu, name, Filter::{Nearest, Bilinear, Trilinear, Anisotropic}, Wrap::{Repeat, Clamp})`.
//! - **[`ComputePipeline`]**`::new(gpu, shader, spec)`, **[`GraphicsPipeline`]**`::new(gpu, name, &GraphicsDesc {..})`;
//!   `spec` is `&[(constant_id, SpecValue::F32(1.0))]`.
//! - **[`Commands`]** inside [`Gpu::submit`] (waits) or [`CommandRecorder`] (frames in flight): `bind`, `descriptors`,
//!   `push_constants`, `dispatch`, `dispatch_invocations`, `begin_rendering`, `end_rendering`, `viewport`, `scissor`,
//!   `bind_index_buffer`, `draw`, `draw_indexed`, `copy_*`, `fill_buffer`, `clear_image`, `blit`, `label`.
//! - **Barriers**: `cmd.transition(&image, Use::Sampled)` from whatever use the image is in; `cmd.mip_barrier` for parts;
//!   `cmd.memory_barrier(Use::ComputeWrite, Use::GraphicsRead)` for buffers. Between calls of [`Gpu::submit`] no barrier
//!   is needed.
//! - **[`Timestamps`]**: `cmd.reset_timestamps(&t)`, `cmd.timestamp(&t, "shade")` after each pass, `t.intervals()`.
//! - **`Swapchain`** (feature `window`): `new(gpu, window)`, `acquire(size)`, `present(recorder, frame)`, with a device
//!   opened with `window_extensions(display)`.
//! - **[`reflect`]**: `struct_offsets(spirv, "Block")` and `struct_stride` for the one truth of shared structs.
//!
//! Misuse while recording does not panic: the submission returns the first as an error. Whatever is recorded lives until
//! the commands are done.

pub mod reflect;
pub mod shaders;

mod barriers;
mod buffer;
mod commands;
mod copies;
mod device;
mod error;
mod image;
mod memory;
mod pipeline;
mod pipeline_layout;
mod sampler;
mod select;
mod submit;
mod timestamps;
mod transfer;
mod usage;
mod validation;
#[cfg(feature = "window")]
mod window;

pub use ash::vk;
pub use buffer::{Buffer, Memory};
pub use commands::{ColorTarget, Commands, DepthTarget, Descriptor, Load};
pub use device::{Gpu, GpuOptions};
pub use error::{GpuError, Result};
pub use image::{Image, ImageDesc, ImageView};
pub use memory::MemoryUse;
pub use pipeline::{
    Blend, ComputePipeline, Cull, Depth, GraphicsDesc, GraphicsPipeline, Pipeline, PolygonMode, Topology,
};
pub use pipeline_layout::{PipelineCore, Spec, SpecValue};
pub use sampler::{Filter, Sampler, Wrap};
pub use submit::CommandRecorder;
pub use timestamps::Timestamps;
pub use usage::Use;
#[cfg(feature = "window")]
pub use window::{Swapchain, SwapchainFrame, window_extensions};
