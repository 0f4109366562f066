//! Multisampling, which finds the surfaces at the samples of each pixel, so that each surface is shaded once per pixel.
//!
//! The geometry is drawn with several samples per pixel. Most pixels show one surface. At an outline, a pixel shows several
//! surfaces, and each of them covers some of the samples. The surface with the most samples stays at the position of the pixel.
//! Further surfaces go into slots below the image, so the same draws filter and shade pixels and slots.
//! [`AccumulatePass`](super::accumulate::AccumulatePass) then combines the surfaces of a pixel, weighted by their coverage. A
//! surface is evaluated at the centre of the pixel, as with a single sample.

use std::sync::Arc;

use super::targets::{MultisampleTargets, VisibleSurface};
use crate::surfaces::numbering::Numbering;
use crate::view::View;
use leadr_gpu::{
    AddressMode, Commands, ComputePipeline, Descriptor, Filter, Gpu, Result, Sampler, SharedStruct, SpecValue, Use,
    shared_struct,
};

shared_struct! {
    /// The rays through the pixels, as in [`Camera::rays`](crate::camera::Camera::rays).
    struct MsaaRays for "MsaaRays" {
        x: [f32; 4],
        y: [f32; 4],
        /// The z axis of the rays. The near distance is in w.
        middle: [f32; 4],
    }
}

/// The multisampling pass for one number of samples per pixel.
#[derive(Clone)]
pub struct MsaaPass {
    pipeline: ComputePipeline,
    nearest: Sampler,
}

impl MsaaPass {
    /// Creates the pass for this many samples per pixel.
    pub fn new(gpu: &Arc<Gpu>, samples: u32, numbering: Numbering) -> Result<Self> {
        let spec = [("SAMPLES", SpecValue::I32(samples.cast_signed())), numbering.spec()];
        Ok(Self {
            pipeline: ComputePipeline::new(gpu, "passes/msaa.comp", &spec, &[MsaaRays::LAYOUT])?,
            nearest: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Writes the pixels and slots of `visible` from the output of the geometry passes, and leaves them readable.
    pub fn record(&self, cmd: &mut Commands, seen: &MultisampleTargets, visible: &VisibleSurface, view: &View) {
        let written = [&visible.surface, &visible.footprint, &visible.depth, &seen.others];
        for image in written {
            cmd.image_barrier(image, Use::Undefined, Use::ComputeWrite);
        }
        cmd.memory_barrier(Use::GraphicsRead, Use::CopyTarget);
        cmd.fill_buffer(&seen.filled, 0);
        cmd.memory_barrier(Use::CopyTarget, Use::ComputeReadWrite);
        cmd.bind(
            &self.pipeline,
            &[
                ("seen_surface", Descriptor::Sampled(seen.geometry.surface.whole(), &self.nearest)),
                ("seen_footprint", Descriptor::Sampled(seen.geometry.footprint.whole(), &self.nearest)),
                ("seen_depth", Descriptor::Sampled(seen.geometry.depth.whole(), &self.nearest)),
                ("surface", Descriptor::StorageImage(visible.surface.whole())),
                ("footprint", Descriptor::StorageImage(visible.footprint.whole())),
                ("depth", Descriptor::StorageImage(visible.depth.whole())),
                ("FilledSlots", Descriptor::Storage(&seen.filled)),
                ("others", Descriptor::StorageImage(seen.others.whole())),
            ],
        );
        let [x, y, middle] = view.rays();
        cmd.push_constants(&MsaaRays {
            x: x.extend(0.0).to_array(),
            y: y.extend(0.0).to_array(),
            middle: middle.extend(view.camera.near).to_array(),
        });
        let [width, height] = visible.surface.mip_extent(0);
        cmd.dispatch_invocations(&self.pipeline, [width, height / 2, 1]);
        for image in written {
            cmd.transition(image, Use::Sampled);
        }
        cmd.memory_barrier(Use::ComputeReadWrite, Use::GraphicsRead);
    }
}
