//! The cube mip pass, which computes all levels of a float cube map from the finest level, weighted by solid angle.

use std::sync::Arc;

use leadr_gpu::{Commands, ComputePipeline, Descriptor, Gpu, ImageView, Result, SpecValue, Use};

/// The cube mip pass.
pub struct CubeMips {
    /// The pipelines for large and for small texels. In a single shader, software rasterisers would compute both variants of the
    /// solid angle.
    pipelines: [ComputePipeline; 2],
}

impl CubeMips {
    /// Creates the pipelines.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let pipeline =
            |small| ComputePipeline::new(gpu, "passes/light/cube_mips.comp", &[("SMALL", SpecValue::Bool(small))], &[]);
        Ok(Self { pipelines: [pipeline(false)?, pipeline(true)?] })
    }

    /// Fills `levels[1..]` from `levels[0]`, which an earlier compute pass wrote. The levels are array views of the single mips of
    /// an RGBA32F cube in [`Use::ComputeReadWrite`]. The size of the cube is a power of two.
    pub fn record(&self, cmd: &mut Commands, levels: &[ImageView]) {
        for pair in levels.windows(2) {
            let [width, height] = pair[1].extent();
            cmd.memory_barrier(Use::ComputeWrite, Use::ComputeRead);
            let pipeline = &self.pipelines[usize::from(width > 10)];
            cmd.bind(
                pipeline,
                &[("fine", Descriptor::StorageImage(&pair[0])), ("coarse", Descriptor::StorageImage(&pair[1]))],
            );
            cmd.dispatch_invocations(pipeline, [width, height, 6]);
        }
    }
}
