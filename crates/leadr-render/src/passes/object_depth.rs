//! The object depth, which stores the object of each pixel as a depth. When a pass draws a single object, the early depth test then
//! skips the pixels of all other objects.

use std::sync::Arc;

use crate::surfaces::numbering::Numbering;
use leadr_gpu::vk;

use super::targets::{MultisampleTargets, OBJECT_FORMAT, VisibleSurface};
use leadr_gpu::{
    AddressMode, Commands, Depth, DepthTarget, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Result,
    Sampler, Use,
};

/// The depth test for passes that draw one object.
pub const OBJECT_TEST: Depth = Depth { format: OBJECT_FORMAT, compare: vk::CompareOp::EQUAL, write: false, bias: None };

/// The depth test for passes that draw all objects, which skips the sky.
pub const ANY_OBJECT_TEST: Depth = Depth { compare: vk::CompareOp::NOT_EQUAL, ..OBJECT_TEST };

/// The pass that writes the object depth.
pub struct ObjectDepthPass {
    pixels: GraphicsPipeline,
    slots: GraphicsPipeline,
    nearest: Sampler,
}

impl ObjectDepthPass {
    /// Creates the pass.
    pub fn new(gpu: &Arc<Gpu>, numbering: Numbering) -> Result<Self> {
        let pipeline = |fragment: &str| {
            let desc = GraphicsDesc {
                vertex: "passes/fullscreen.vert",
                fragment: Some(fragment),
                depth: Some(Depth { format: OBJECT_FORMAT, compare: vk::CompareOp::ALWAYS, write: true, bias: None }),
                spec: &[numbering.spec()],
                ..Default::default()
            };
            GraphicsPipeline::new(gpu, "object depth", &desc)
        };
        Ok(Self {
            pixels: pipeline("passes/object_depth.frag")?,
            slots: pipeline("passes/slot_depth.frag")?,
            nearest: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Writes the object depth. Record it after the geometry passes. `seen` are the multisampled targets, if any.
    pub fn record(&self, cmd: &mut Commands, visible: &VisibleSurface, seen: Option<&MultisampleTargets>) {
        cmd.image_barrier(&visible.objects, Use::Undefined, Use::DepthTarget);
        cmd.begin_rendering(&[], Some(DepthTarget { view: visible.objects.whole(), clear: Some(0.0) }));
        let surface = ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest));
        let [width, height] = visible.objects.mip_extent(0);
        let pixels = if seen.is_some() { height / 2 } else { height };
        cmd.scissor([0, 0, width, pixels]);
        cmd.bind(&self.pixels, &[surface]);
        cmd.draw(0..3, 0..1);
        if let Some(seen) = seen {
            cmd.scissor([0, pixels, width, height - pixels]);
            cmd.bind(&self.slots, &[surface, ("FilledSlots", Descriptor::Storage(&seen.filled))]);
            cmd.draw(0..3, 0..1);
        }
        cmd.end_rendering();
        cmd.transition(&visible.objects, Use::DepthTarget);
    }
}
