//! The cube mip pass: makes every level of a float cube map from its finest, by means weighted by solid angle.

use std::sync::Arc;

use crate::gpu::{Commands, ComputePipeline, Descriptor, Gpu, ImageView, Result, Use};

/// The pass.
pub struct CubeMips {
    pipeline: ComputePipeline,
}

impl CubeMips {
    /// Creates the pipeline.
    ///
    /// # Errors
    /// A failed Vulkan call.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self { pipeline: ComputePipeline::new(gpu, "passes/light/cube_mips.comp", &[], &[])? })
    }

    /// Fills `levels[1..]` from `levels[0]`, which a compute pass has just written. The levels are array views of the
    /// single mips of an RGBA32F cube whose size is a power of two, in [`Use::ComputeReadWrite`].
    pub fn record(&self, cmd: &mut Commands, levels: &[ImageView]) {
        for pair in levels.windows(2) {
            let [width, height] = pair[1].extent();
            cmd.memory_barrier(Use::ComputeWrite, Use::ComputeRead);
            cmd.bind(
                &self.pipeline,
                &[("fine", Descriptor::StorageImage(&pair[0])), ("coarse", Descriptor::StorageImage(&pair[1]))],
            );
            cmd.dispatch_invocations(&self.pipeline, [width, height, 6]);
        }
    }
}
