//! The pass that joins the edge samples of each pixel.

use std::sync::Arc;

use super::rays::EdgeRays;
use crate::passes::shade::LightingGpu;
use crate::passes::targets::{GBuffer, JoinedEdges, SampleTargets};
use crate::settings::Needs;
use leadr_gpu::{
    AddressMode, Commands, ComputePipeline, Descriptor, Filter, Gpu, ResourceSet, Result, Sampler, SharedStruct,
    SpecValue, Use,
};

/// The key that selects the pipeline of the join pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct JoinKind {
    /// The slope statistics that the technique needs.
    pub needs: Needs,
    /// The number of suns with shadow maps.
    pub shadow_maps: u32,
}

/// The pass that joins the edge samples of each pixel.
#[derive(Clone)]
pub struct JoinPass {
    pipeline: ComputePipeline,
    nearest: Sampler,
}

impl JoinPass {
    /// Creates the pass for one kind.
    pub fn new(gpu: &Arc<Gpu>, kind: JoinKind) -> Result<Self> {
        let spec = [kind.needs.spec(), vec![("SHADOW_MAPS", SpecValue::I32(kind.shadow_maps as i32))]].concat();
        Ok(Self {
            pipeline: ComputePipeline::new(
                gpu,
                "passes/edges/join.comp",
                &spec,
                &[EdgeRays::LAYOUT, LightingGpu::LAYOUT],
            )?,
            nearest: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Adds an image of shaded edge samples to the sums in `joined` and to the pixels' G-buffer. All images stay readable.
    pub fn record(
        &self,
        cmd: &mut Commands,
        edges: &SampleTargets,
        pixel: &GBuffer,
        joined: &JoinedEdges,
        scene: &ResourceSet,
        rays: &EdgeRays,
    ) {
        let SampleTargets { visible: edge, gbuffer: filtered, radiance } = edges;
        cmd.transition(radiance, Use::Sampled);
        for image in [&joined.others, &joined.shares, &joined.more_suns] {
            if rays.edge[3] == 0.0 {
                cmd.image_barrier(image, Use::Undefined, Use::ComputeReadWrite);
            } else {
                cmd.transition(image, Use::ComputeReadWrite);
            }
        }
        let written = [&pixel.slopes, &pixel.material];
        for image in written {
            cmd.transition(image, Use::ComputeReadWrite);
        }
        cmd.bind(
            &self.pipeline,
            &[
                ("edge_surface", Descriptor::Sampled(edge.surface.whole(), &self.nearest)),
                ("edge_radiance", Descriptor::Sampled(radiance.whole(), &self.nearest)),
                ("edge_slopes", Descriptor::Sampled(filtered.slopes.whole(), &self.nearest)),
                ("edge_material", Descriptor::Sampled(filtered.material.whole(), &self.nearest)),
                ("edge_joined", Descriptor::Sampled(filtered.surface.whole(), &self.nearest)),
                ("others", Descriptor::StorageImage(joined.others.whole())),
                ("shares", Descriptor::StorageImage(joined.shares.whole())),
                ("more_suns", Descriptor::StorageImage(joined.more_suns.whole())),
                ("slopes", Descriptor::StorageImage(pixel.slopes.whole())),
                ("material", Descriptor::StorageImage(pixel.material.whole())),
                ("edge_depth", Descriptor::Sampled(edge.depth.whole(), &self.nearest)),
                ("pixel_surface", Descriptor::Sampled(pixel.surface.whole(), &self.nearest)),
            ],
        );
        cmd.bind_set(scene);
        cmd.push_constants(rays);
        let [width, height] = joined.others.mip_extent(0);
        cmd.dispatch_invocations(&self.pipeline, [width, height, 1]);
        for image in written.into_iter().chain([&joined.others, &joined.shares, &joined.more_suns]) {
            cmd.transition(image, Use::Sampled);
        }
    }
}
