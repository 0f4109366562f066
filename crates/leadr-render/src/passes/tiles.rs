//! The tile pass, which records the content of each screen tile.

use std::sync::Arc;

use super::targets::VisibleSurface;
use crate::surfaces::numbering::Numbering;
use leadr_gpu::{AddressMode, Commands, ComputePipeline, Descriptor, Filter, Gpu, Result, Sampler, Use};

/// The pass that writes the records.
pub struct TilePass {
    pipeline: ComputePipeline,
    nearest: Sampler,
}

impl TilePass {
    /// Creates the pass.
    pub fn new(gpu: &Arc<Gpu>, numbering: Numbering) -> Result<Self> {
        Ok(Self {
            pipeline: ComputePipeline::new(gpu, "passes/tiles.comp", &[numbering.spec()], &[])?,
            nearest: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Records which objects each tile contains. Call it after the geometry passes.
    pub fn record(&self, cmd: &mut Commands, visible: &VisibleSurface) {
        let tiles = &visible.tiles;
        cmd.memory_barrier(Use::GraphicsRead, Use::ComputeWrite);
        cmd.bind(
            &self.pipeline,
            &[
                ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                ("Tiles", Descriptor::Storage(&tiles.records)),
            ],
        );
        let [columns, rows] = tiles.extent();
        cmd.dispatch([columns, rows, 1]);
        cmd.memory_barrier(Use::ComputeWrite, Use::GraphicsRead);
    }
}
