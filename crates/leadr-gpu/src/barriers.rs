//! This is the only module that emits barriers. A barrier changes a resource from one use to another.

use std::ops::Range;

use ash::vk;

use super::{Commands, Image, Use};

impl Commands {
    /// Changes the use of the whole image. Has no effect if the image already has this use and the use only reads.
    pub fn transition(&mut self, image: &Image, to: Use) {
        let from = self.use_of(image);
        let reads = [Use::CopySource, Use::Sampled, Use::ComputeRead, Use::GraphicsRead, Use::Present];
        if from == to && reads.contains(&to) {
            return;
        }
        self.image_barrier(image, from, to);
    }

    /// Changes the use of the whole image from `from` to `to`. If `from` is [`Use::Undefined`], the content is discarded.
    pub fn image_barrier(&mut self, image: &Image, from: Use, to: Use) {
        let desc = *image.desc();
        self.mip_barrier(image, 0..desc.mips, 0..desc.layers, from, to);
        self.set_use(image, to);
    }

    /// Changes the use of some mips and layers. The image's recorded use stays the same, so the caller must restore it for all mips
    /// and layers.
    pub fn mip_barrier(&mut self, image: &Image, mips: Range<u32>, layers: Range<u32>, from: Use, to: Use) {
        self.keep(&image.inner);
        let barrier = vk::ImageMemoryBarrier2::default()
            .src_stage_mask(from.stages())
            .src_access_mask(from.access())
            .dst_stage_mask(to.stages())
            .dst_access_mask(to.access())
            .old_layout(from.layout())
            .new_layout(to.layout())
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image.raw())
            .subresource_range(subresources(image, mips, layers));
        self.barrier(&vk::DependencyInfo::default().image_memory_barriers(&[barrier]));
    }

    /// Orders all earlier accesses before all later accesses, including reads by the CPU after the submission.
    pub fn full_barrier(&mut self) {
        let all = vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE;
        let barrier = vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS | vk::PipelineStageFlags2::HOST)
            .dst_access_mask(all | vk::AccessFlags2::HOST_READ);
        self.barrier(&vk::DependencyInfo::default().memory_barriers(&[barrier]));
    }

    /// Orders all earlier accesses of use `from` before all later accesses of use `to`. The barrier applies to all buffers.
    pub fn memory_barrier(&mut self, from: Use, to: Use) {
        let barrier = vk::MemoryBarrier2::default()
            .src_stage_mask(from.stages())
            .src_access_mask(from.access())
            .dst_stage_mask(to.stages())
            .dst_access_mask(to.access());
        self.barrier(&vk::DependencyInfo::default().memory_barriers(&[barrier]));
    }

    fn barrier(&mut self, dependency: &vk::DependencyInfo<'_>) {
        // SAFETY: the command buffer is being recorded and keeps the barrier's image alive.
        unsafe { self.gpu().raw().cmd_pipeline_barrier2(self.raw(), dependency) };
    }
}

/// Returns the Vulkan range of the given mips and layers of an image.
fn subresources(image: &Image, mips: Range<u32>, layers: Range<u32>) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange::default()
        .aspect_mask(image.aspect())
        .base_mip_level(mips.start)
        .level_count(mips.len() as u32)
        .base_array_layer(layers.start)
        .layer_count(layers.len() as u32)
}
