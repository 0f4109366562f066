//! Object depth: which object each pixel shows, as a depth, so that passes which draw one object after the other skip the pixels of
//! others before anything runs for them.

use std::sync::Arc;

use ash::vk;

use super::targets::{OBJECT_FORMAT, VisibleSurface};
use crate::gpu::{
    AddressMode, Commands, Depth, DepthTarget, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Result,
    Sampler, Use,
};

/// How passes over one object test its pixels.
pub const OBJECT_TEST: Depth = Depth { format: OBJECT_FORMAT, compare: vk::CompareOp::EQUAL, write: false, bias: None };

/// How a pass over all objects leaves the sky out.
pub const ANY_OBJECT_TEST: Depth = Depth { compare: vk::CompareOp::NOT_EQUAL, ..OBJECT_TEST };

/// The pass that writes the image of objects.
pub struct ObjectDepthPass {
    pipeline: GraphicsPipeline,
    nearest: Sampler,
}

impl ObjectDepthPass {
    /// The pass.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let desc = GraphicsDesc {
            vertex: "passes/fullscreen.vert",
            fragment: Some("passes/object_depth.frag"),
            depth: Some(Depth { format: OBJECT_FORMAT, compare: vk::CompareOp::ALWAYS, write: true, bias: None }),
            ..Default::default()
        };
        Ok(Self {
            pipeline: GraphicsPipeline::new(gpu, "object depth", &desc)?,
            nearest: Sampler::new(gpu, "object depth", Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Writes the image for a finished geometry pass.
    pub fn record(&self, cmd: &mut Commands, visible: &VisibleSurface) {
        cmd.image_barrier(&visible.objects, Use::Undefined, Use::DepthTarget);
        cmd.begin_rendering(&[], Some(DepthTarget { view: visible.objects.whole(), clear: Some(0.0) }));
        let surface = ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest));
        cmd.bind(&self.pipeline, &[surface]);
        cmd.draw(0..3, 0..1);
        cmd.end_rendering();
        cmd.transition(&visible.objects, Use::DepthTarget);
    }
}
