//! Opens a test device with validation, and runs probes on it.
//!
//! # A test with a device
//!
//! ```ignore
//! mod common;
//!
//! #[test]
//! fn something() {
//!     let Some(gpu) = common::test_gpu() else { return };
//!     // `gpu` is an Arc<Gpu> with a guard: any validation message fails the test when it goes out of scope.
//! }
//! ```
//!
//! Without a Vulkan driver the tests fail, unless `LEADR_SKIP_GPU=1` is set.
//!
//! # Probes
//!
//! A probe is a compute entry point `shaders-glsl/probes/<name>.comp` that evaluates one include over an array:
//!
//! ```glsl
//! #version 460
//! #include "leadr/facets/beckmann.glsl"
//! layout(local_size_x = 64) in;
//! layout(std430) readonly buffer In { float x[]; };
//! layout(std430) writeonly buffer Out { float y[]; };
//! layout(push_constant) uniform P { uint count; };
//!
//! void main() {
//!     uint i = gl_GlobalInvocationID.x;
//!     if (i >= count) { return; }
//!     // invocation i reads x[i * IN ..] and writes y[i * OUT ..]
//! }
//! ```
//!
//! `run_probe(&gpu, "probes/<name>.comp", &inputs, OUT)` takes one `[f32; IN]` per invocation and returns `OUT` floats for each, in order.
//! A probe must declare both buffers and the push constant as above, and use all three. The loops of one invocation must have fewer than
//! 65,535 iterations in total, because lavapipe silently stops after this number.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::ops::Deref;
use std::sync::Arc;

use leadr_gpu::{Buffer, ComputePipeline, Descriptor, Gpu, GpuOptions, Memory, SharedStruct, SpecValue, StructLayout};

leadr_gpu::shared_struct! {
    /// The push constants of every probe.
    pub struct Count for "P" {
        /// The number of invocations that have an item.
        pub count: u32,
    }
}

/// A test device with validation. Dropping the device asserts that there were no validation messages.
pub struct TestGpu(Arc<Gpu>);

impl Deref for TestGpu {
    type Target = Arc<Gpu>;

    fn deref(&self) -> &Arc<Gpu> {
        &self.0
    }
}

impl TestGpu {
    /// Fails if there were validation messages.
    pub fn assert_silent(&self) {
        let messages = self.0.validation_messages();
        assert!(messages.is_empty(), "validation on {}:\n{}", self.0.device_name(), messages.join("\n"));
    }
}

impl Drop for TestGpu {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.assert_silent();
        }
    }
}

/// Opens the test device, which is `LEADR_DEVICE` (a name or an index) or otherwise the best device. Returns `None` and prints the reason
/// if there is no device and `LEADR_SKIP_GPU=1` is set.
///
/// # Panics
/// If there is no device and `LEADR_SKIP_GPU=1` is not set. The message has the reason.
pub fn test_gpu() -> Option<TestGpu> {
    let options = GpuOptions {
        device: std::env::var("LEADR_DEVICE").ok(),
        validation: true,
        shaders: vec![leadr_probes::PROBES],
        ..Default::default()
    };
    match leadr_render::open_gpu(&options) {
        Ok(gpu) => Some(TestGpu(gpu)),
        Err(error) if std::env::var("LEADR_SKIP_GPU").is_ok_and(|value| value == "1") => {
            println!("skipped, since LEADR_SKIP_GPU=1: {error}");
            None
        }
        Err(error) => panic!("this test needs a GPU (LEADR_SKIP_GPU=1 skips it): {error}"),
    }
}

/// Evaluates a probe on every input, and returns `outputs_per_item` floats for each, in order.
///
/// # Panics
/// When the probe cannot run, with the reason.
pub fn run_probe<const N: usize>(
    gpu: &Arc<Gpu>,
    shader: &str,
    inputs: &[[f32; N]],
    outputs_per_item: usize,
) -> Vec<f32> {
    run_probe_with(gpu, shader, inputs, outputs_per_item, &[], &[], &[])
}

/// Like [`run_probe`], but with specialization constants, further resources and their struct layouts.
///
/// # Panics
/// When the probe cannot run, with the reason.
pub fn run_probe_with<const N: usize>(
    gpu: &Arc<Gpu>,
    shader: &str,
    inputs: &[[f32; N]],
    outputs_per_item: usize,
    spec: &[(&str, SpecValue)],
    further: &[(&str, Descriptor<'_>)],
    structs: &[StructLayout],
) -> Vec<f32> {
    // The number of items stays within two limits of every device: 65,535 work groups (of 64 items) and 128 MiB per storage buffer.
    const ITEMS: usize = 1 << 18;
    let fail = |error| -> ! { panic!("probe {shader} on {}: {error}", gpu.device_name()) };
    let pipeline =
        ComputePipeline::new(gpu, shader, spec, &[&[Count::LAYOUT], structs].concat()).unwrap_or_else(|e| fail(e));
    assert_eq!(pipeline.local_size(), [64, 1, 1], "probe {shader} must have local_size_x = 64");
    let mut results = Vec::with_capacity(inputs.len() * outputs_per_item);
    for chunk in inputs.chunks(ITEMS) {
        let run = || {
            let input = Buffer::from_slice(gpu, "probe input", chunk.as_flattened())?;
            let bytes = chunk.len() * outputs_per_item * size_of::<f32>();
            let output = Buffer::new(gpu, "probe output", bytes as u64, Memory::Readback)?;
            let mut descriptors = vec![("In", Descriptor::Storage(&input)), ("Out", Descriptor::Storage(&output))];
            descriptors.extend_from_slice(further);
            gpu.submit(shader, |cmd| {
                // The NaNs reveal values that the probe does not write.
                cmd.fill_buffer(&output, f32::NAN.to_bits());
                cmd.full_barrier();
                cmd.bind(&pipeline, &descriptors);
                cmd.push_constants(&Count { count: chunk.len() as u32 });
                cmd.dispatch_invocations(&pipeline, [chunk.len() as u32, 1, 1]);
            })?;
            output.read::<f32>(0, chunk.len() * outputs_per_item)
        };
        results.extend(run().unwrap_or_else(|e| fail(e)));
    }
    results
}
