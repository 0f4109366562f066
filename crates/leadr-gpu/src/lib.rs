//! A layer over Vulkan for devices, memory, images, pipelines, commands and timing. The layer is independent of any BRDF.
//!
//! # The API at a glance
//!
//! ```no_run
//! use leadr_gpu::{Buffer, ComputePipeline, Descriptor, Gpu, GpuOptions, Memory, SharedStruct, Use};
//!
//! leadr_gpu::shared_struct! {
//!     /// Push constants of the shader: `uniform P { uint count; };`.
//!     struct Count for "P" { count: u32 }
//! }
//!
//! # fn main() -> leadr_gpu::Result<()> {
//! let gpu = Gpu::new(&GpuOptions { validation: true, ..Default::default() })?; // Arc<Gpu>
//! let double = ComputePipeline::new(&gpu, "probes/selftest/selftest.comp", &[], &[Count::LAYOUT])?;
//! let input = Buffer::from_slice(&gpu, "input", &[1.0f32, 2.0, 3.0])?;
//! let output = Buffer::new(&gpu, "output", 12, Memory::Device)?;
//! gpu.submit("double", |cmd| {
//!     cmd.bind(&double, &[("In", Descriptor::Storage(&input)), ("Out", Descriptor::Storage(&output))]);
//!     cmd.push_constants(&Count { count: 3 });
//!     cmd.dispatch_invocations(&double, [3, 1, 1]);
//! })?; // waits
//! let values: Vec<f32> = output.read_all()?;
//! # Ok(())
//! # }
//! ```
//!
//! - **Shaders** are the entry points `shaders-glsl/{passes,probes}/**/*.{vert,tesc,tese,frag,comp}`. The build script compiles
//!   them, and each is named by its path: `"passes/shade/shade.frag"`. `#include "leadr/x.glsl"` works everywhere.
//! - **Resources are bound by name**, never by number. GLSL declares them without `binding`. A block is named by its instance name
//!   or, if it has none, by its block name. Specialization constants are also set by name, with their type. Undeclared and missing
//!   names are errors. Names that a shader declares but does not use are allowed. Arrays of resources are not supported.
//! - **Sets by lifetime**: `bind` pushes set 0. Longer-lived resources belong to a [`ResourceSet`] of a [`SetLayout`]. GLSL
//!   declares them with `layout(set = 1)` or `2`. The set is written once, and `bind_set` binds it after the pipeline.
//! - **`shared_struct!`** declares the Rust twin of every struct in buffers and push constants. A pipeline takes the twins'
//!   [`SharedStruct::LAYOUT`]s. Pipeline creation fails if the names, offsets or sizes of members differ, or if a struct is
//!   missing. Buffers of plain numbers and vectors need no twin.
//! - **[`Buffer`]**: `new(gpu, name, bytes, Memory::{Device, Upload, Readback})`, `from_slice(gpu, name, &data)`,
//!   `write(offset, &data)`, `read(offset, count)`, `read_all()`.
//! - **[`Image`]**: `new(gpu, name, ImageDesc::new(format, w, h).full_mips().layers(n).cube().storage().color_target()
//!   .depth_target())`, `write(mip, layer, &texels)`, `read(mip, layer)`; views `whole()`, `mip_layer(mip, layer)`,
//!   `mip_array(mip)`, `array()`.
//! - **[`Sampler`]**: `new(gpu, Filter::{Nearest, Bilinear, Trilinear}, AddressMode::{Repeat, ClampToEdge})`.
//! - **[`ComputePipeline`]**`::new(gpu, shader, spec, structs)`, **[`GraphicsPipeline`]**`::new(gpu, name,
//!   &GraphicsDesc { spec, structs, .. })`; `spec` is `&[("SAMPLES", SpecValue::I32(5))]`.
//! - **[`Commands`]** inside [`Gpu::submit`] (waits) or [`CommandRecorder`] (frames in flight): `bind`, `push_constants`,
//!   `dispatch`, `dispatch_invocations`, `begin_rendering`, `end_rendering`, `viewport`, `scissor`, `draw`, `copy_*`,
//!   `fill_buffer`, `label`.
//! - **Barriers**: `cmd.transition(&image, Use::Sampled)` changes the use of an image; `cmd.mip_barrier` for parts of an image;
//!   `cmd.memory_barrier(Use::ComputeWrite, Use::GraphicsRead)` for buffers. Barriers are not needed between calls of
//!   [`Gpu::submit`].
//! - **[`Timestamps`]**: `cmd.reset_timestamps(&t)`, `cmd.timestamp(&t, "shade")` after each pass, `t.intervals()`.
//! - **`Swapchain`** (feature `window`): `new(gpu, window)`, `acquire(size)`, `present(recorder, frame)`, with a device
//!   opened with `window_extensions(display)`.
//!
//! Misuse while recording does not panic. The submission returns the first misuse as an error, and the state of images and
//! timestamps stays unchanged. All recorded objects live until the commands are done.

#![allow(unsafe_code)]

pub mod shaders;

mod barriers;
mod bind;
mod buffer;
mod commands;
mod copies;
mod device;
mod error;
mod faults;
mod image;
mod memory;
mod pipeline;
mod pipeline_handles;
mod pipeline_layout;
mod reload;
mod sampler;
mod select;
mod sets;
#[cfg(feature = "watch")]
pub mod shader_watch;
mod shared_struct;
mod spirv;
mod submit;
mod timestamps;
mod transfer;
mod usage;
mod validation;
mod window;

pub use ash::vk;
pub use bind::Descriptor;
pub use buffer::{Buffer, Memory};
pub use commands::{ColorTarget, Commands, DepthTarget, Load};
pub use device::{Gpu, GpuOptions};
pub use error::{GpuError, Result, binary};
pub use faults::DriverCall;
pub use image::{Image, ImageDesc, ImageView};
pub use memory::{MemoryRoom, MemoryUse, machine_memory};
pub use pipeline::{ComputePipeline, Depth, GraphicsDesc, GraphicsPipeline, Pipeline, Topology};
pub use pipeline_layout::{PipelineCore, Spec, SpecValue};
pub use sampler::{AddressMode, Filter, Sampler};
pub use sets::{ResourceSet, SetLayout};
pub use shared_struct::{MemberLayout, SharedStruct, StructLayout};
pub use submit::CommandRecorder;
pub use timestamps::Timestamps;
pub use usage::Use;
pub use window::{FRAMES_IN_FLIGHT, Swapchain, SwapchainFrame, window_extensions};
