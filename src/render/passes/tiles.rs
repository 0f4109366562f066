//! Tile pass: records what each tile of the screen shows.

use std::sync::Arc;

use super::targets::VisibleSurface;
use crate::gpu::{Commands, ComputePipeline, Descriptor, Filter, Gpu, Result, Sampler, Use, Wrap};

/// The pass that writes the records.
pub struct TilePass {
    pipeline: ComputePipeline,
    nearest: Sampler,
}

impl TilePass {
    /// The pass.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self {
            pipeline: ComputePipeline::new(gpu, "passes/tiles.comp", &[])?,
            nearest: Sampler::new(gpu, "tiles", Filter::Nearest, Wrap::Clamp)?,
        })
    }

    /// Records what the tiles of a finished geometry pass show.
    pub fn record(&self, cmd: &mut Commands, visible: &VisibleSurface) {
        let tiles = &visible.tiles;
        cmd.memory_barrier(Use::GraphicsRead, Use::ComputeWrite);
        cmd.bind(
            &self.pipeline,
            &[
                (0, Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                (1, Descriptor::Storage(&tiles.records)),
            ],
        );
        let [columns, rows] = tiles.extent();
        cmd.dispatch([columns, rows, 1]);
        cmd.memory_barrier(Use::ComputeWrite, Use::GraphicsRead);
    }
}
