//! The pass that marks edge samples that lie on the same surface as their pixel.

use std::sync::Arc;

use super::rays::EdgeRays;
use crate::passes::targets::{SampleTargets, VisibleSurface};
use crate::surfaces::numbering::Numbering;
use leadr_gpu::{AddressMode, Commands, ComputePipeline, Descriptor, Filter, Gpu, Result, Sampler, SharedStruct, Use};

/// The pass that marks the edge samples that need no shading.
#[derive(Clone)]
pub struct EdgePass {
    pipeline: ComputePipeline,
    nearest: Sampler,
}

impl EdgePass {
    /// Creates the pass.
    pub fn new(gpu: &Arc<Gpu>, numbering: Numbering) -> Result<Self> {
        Ok(Self {
            pipeline: ComputePipeline::new(gpu, "passes/edges/edges.comp", &[numbering.spec()], &[EdgeRays::LAYOUT])?,
            nearest: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Marks the samples of `edges` that lie on the same surface as their pixel, and leaves `edges` readable.
    pub fn record(&self, cmd: &mut Commands, pixels: &SampleTargets, edges: &VisibleSurface, rays: &EdgeRays) {
        let SampleTargets { visible: pixel, gbuffer: filtered, .. } = pixels;
        cmd.transition(&edges.surface, Use::ComputeReadWrite);
        cmd.bind(
            &self.pipeline,
            &[
                ("pixel_surface", Descriptor::Sampled(pixel.surface.whole(), &self.nearest)),
                ("pixel_slopes", Descriptor::Sampled(filtered.slopes.whole(), &self.nearest)),
                ("pixel_depth", Descriptor::Sampled(pixel.depth.whole(), &self.nearest)),
                ("edge_surface", Descriptor::StorageImage(edges.surface.whole())),
                ("edge_depth", Descriptor::Sampled(edges.depth.whole(), &self.nearest)),
                ("pixel_filtered", Descriptor::Sampled(filtered.surface.whole(), &self.nearest)),
            ],
        );
        cmd.push_constants(rays);
        let grid = edges.surface.mip_extent(0)[0] / pixel.surface.mip_extent(0)[0];
        let [left, top, right, bottom] = rays.area;
        // A dispatch needs at least one work group.
        let along = |first: i32, last: i32| grid * (last - first).max(1).unsigned_abs();
        cmd.dispatch_invocations(&self.pipeline, [along(left, right), along(top, bottom), 1]);
        cmd.transition(&edges.surface, Use::Sampled);
    }
}
