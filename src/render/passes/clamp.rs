//! Clamp pass: keeps the mean of the samples from becoming negative.

use std::sync::Arc;

use crate::gpu::{Commands, ComputePipeline, Descriptor, Gpu, Image, Result, Use};

/// The pass.
pub struct ClampPass(ComputePipeline);

impl ClampPass {
    /// The pass.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self(ComputePipeline::new(gpu, "passes/clamp.comp", &[], &[])?))
    }

    /// Clamps `mean`.
    pub fn record(&self, cmd: &mut Commands, mean: &Image) {
        cmd.transition(mean, Use::ComputeReadWrite);
        cmd.bind(&self.0, &[("mean_image", Descriptor::StorageImage(mean.whole()))]);
        let [width, height] = mean.whole().extent();
        cmd.dispatch_invocations(&self.0, [width, height, 1]);
    }
}
