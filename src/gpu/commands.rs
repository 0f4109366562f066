//! Recording: descriptors, dispatches, draws, copies, and the one place that emits barriers.

use std::any::Any;
use std::ffi::CString;
use std::ops::Range;
use std::sync::Arc;

use ash::vk;
use bytemuck::NoUninit;

use super::pipeline::PipelineCore;
use super::{Buffer, ComputePipeline, Gpu, GpuError, Image, ImageView, Pipeline, Result, Sampler, Timestamps, Use};

/// What a binding number stands for.
#[derive(Clone, Copy)]
pub enum Descriptor<'a> {
    /// A whole uniform buffer.
    Uniform(&'a Buffer),
    /// Bytes of a uniform buffer: offset and size. The offset obeys `minUniformBufferOffsetAlignment`.
    UniformRange(&'a Buffer, u64, u64),
    /// A whole storage buffer.
    Storage(&'a Buffer),
    /// Bytes of a storage buffer: offset and size. The offset obeys `minStorageBufferOffsetAlignment`.
    StorageRange(&'a Buffer, u64, u64),
    /// A texture, in [`Use::Sampled`].
    Sampled(&'a ImageView, &'a Sampler),
    /// A storage image, in one of the compute uses.
    StorageImage(&'a ImageView),
}

impl Descriptor<'_> {
    fn kind(&self) -> vk::DescriptorType {
        match self {
            Self::Uniform(_) | Self::UniformRange(..) => vk::DescriptorType::UNIFORM_BUFFER,
            Self::Storage(_) | Self::StorageRange(..) => vk::DescriptorType::STORAGE_BUFFER,
            Self::Sampled(..) => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::StorageImage(_) => vk::DescriptorType::STORAGE_IMAGE,
        }
    }
}

/// What a colour attachment holds when rendering begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// This colour.
    Clear([f32; 4]),
    /// These integers, for integer formats.
    ClearUint([u32; 4]),
    /// What was there.
    Keep,
    /// Anything: every pixel will be drawn.
    Discard,
}

/// A colour attachment: a view of one mip of one layer, in [`Use::ColorTarget`].
#[derive(Clone, Copy)]
pub struct ColorTarget<'a> {
    /// The attachment.
    pub view: &'a ImageView,
    /// What it holds at the beginning.
    pub load: Load,
}

/// A depth attachment, in [`Use::DepthTarget`].
#[derive(Clone, Copy)]
pub struct DepthTarget<'a> {
    /// The attachment.
    pub view: &'a ImageView,
    /// The depth everywhere at the beginning (0 is farthest when reversed); `None` keeps what was there.
    pub clear: Option<f32>,
}

/// Commands being recorded. Misuse is remembered and reported by the submission, so that recording reads straight.
/// Everything that is recorded is kept alive until the commands are done.
pub struct Commands {
    gpu: Arc<Gpu>,
    raw: vk::CommandBuffer,
    pipeline: Option<Arc<PipelineCore>>,
    keep: Vec<Arc<dyn Any + Send + Sync>>,
    error: Option<GpuError>,
}

impl Commands {
    pub(crate) fn new(gpu: &Arc<Gpu>, raw: vk::CommandBuffer) -> Self {
        Self { gpu: gpu.clone(), raw, pipeline: None, keep: Vec::new(), error: None }
    }

    /// What the commands use, or the first misuse.
    pub(crate) fn finish(self) -> Result<Vec<Arc<dyn Any + Send + Sync>>> {
        self.error.map_or(Ok(self.keep), Err)
    }

    /// The raw command buffer.
    pub fn raw(&self) -> vk::CommandBuffer {
        self.raw
    }

    /// The device.
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// Makes the submission fail with this error unless an earlier one does.
    pub fn fail(&mut self, error: GpuError) {
        self.error.get_or_insert(error);
    }

    /// Keeps an object alive until the commands are done.
    pub fn keep<T: Any + Send + Sync>(&mut self, object: &Arc<T>) {
        self.keep.push(object.clone());
    }

    /// Records within a named region of captures and validation messages.
    pub fn label<R>(&mut self, name: &str, record: impl FnOnce(&mut Self) -> R) -> R {
        let text = CString::new(name).unwrap_or_default();
        if let Some(debug) = self.gpu.debug() {
            let info = vk::DebugUtilsLabelEXT::default().label_name(&text);
            // SAFETY: the command buffer is being recorded; so throughout this file.
            unsafe { debug.cmd_begin_debug_utils_label(self.raw, &info) };
        }
        let result = record(self);
        if let Some(debug) = self.gpu.debug() {
            unsafe { debug.cmd_end_debug_utils_label(self.raw) };
        }
        result
    }

    /// Binds a pipeline and all its descriptors, by binding number. Numbers that its shaders do not use are ignored.
    pub fn bind(&mut self, pipeline: &impl Pipeline, descriptors: &[(u32, Descriptor<'_>)]) {
        let core = pipeline.core();
        let given = |binding: u32| descriptors.iter().any(|(number, _)| *number == binding);
        if let Some(missing) = core.bindings.iter().find(|b| !given(b.binding)) {
            let fault = format!("binding {} ({:?}) was not given", missing.binding, missing.kind);
            return self.fail(GpuError::usage(&core.name, fault));
        }
        unsafe { self.gpu.raw().cmd_bind_pipeline(self.raw, core.bind_point, core.raw) };
        self.keep(core);
        self.pipeline = Some(core.clone());
        self.descriptors(descriptors);
    }

    /// Replaces some descriptors of the bound pipeline.
    pub fn descriptors(&mut self, descriptors: &[(u32, Descriptor<'_>)]) {
        let Some(core) = self.pipeline.clone() else {
            return self.fail(GpuError::usage("descriptors", "no pipeline is bound"));
        };
        let mut writes = Vec::with_capacity(descriptors.len());
        let mut buffers = Vec::with_capacity(descriptors.len());
        let mut images = Vec::with_capacity(descriptors.len());
        for (number, descriptor) in descriptors {
            let Some(binding) = core.bindings.iter().find(|b| b.binding == *number) else { continue };
            if binding.kind != descriptor.kind() {
                let fault = format!("binding {number} is {:?}, not {:?}", binding.kind, descriptor.kind());
                return self.fail(GpuError::usage(&core.name, fault));
            }
            let mut buffer = vk::DescriptorBufferInfo::default();
            let mut image = vk::DescriptorImageInfo::default();
            match descriptor {
                Descriptor::Uniform(b) | Descriptor::Storage(b) => {
                    buffer = buffer.buffer(b.raw()).range(vk::WHOLE_SIZE);
                    self.keep(&b.inner);
                }
                Descriptor::UniformRange(b, offset, size) | Descriptor::StorageRange(b, offset, size) => {
                    buffer = buffer.buffer(b.raw()).offset(*offset).range(*size);
                    self.keep(&b.inner);
                }
                Descriptor::Sampled(view, sampler) => {
                    image = image.image_view(view.raw()).sampler(sampler.raw()).image_layout(Use::Sampled.layout());
                    self.keep(&view.inner);
                    self.keep(&sampler.inner);
                }
                Descriptor::StorageImage(view) => {
                    image = image.image_view(view.raw()).image_layout(vk::ImageLayout::GENERAL);
                    self.keep(&view.inner);
                }
            }
            buffers.push([buffer]);
            images.push([image]);
            writes.push((*number, binding.kind));
        }
        let writes: Vec<_> = writes
            .iter()
            .zip(buffers.iter().zip(&images))
            .map(|((number, kind), (buffer, image))| {
                let write = vk::WriteDescriptorSet::default().dst_binding(*number).descriptor_type(*kind);
                match *kind {
                    vk::DescriptorType::UNIFORM_BUFFER | vk::DescriptorType::STORAGE_BUFFER => {
                        write.buffer_info(buffer)
                    }
                    _ => write.image_info(image),
                }
            })
            .collect();
        if writes.is_empty() {
            return;
        }
        unsafe {
            let push = self.gpu.push_descriptor();
            push.cmd_push_descriptor_set(self.raw, core.bind_point, core.layout, 0, &writes);
        }
    }

    /// Sets the push constants of the bound pipeline. Padding at the end of `value` is left out.
    pub fn push_constants<T: NoUninit>(&mut self, value: &T) {
        let Some(core) = self.pipeline.clone() else {
            return self.fail(GpuError::usage("push constants", "no pipeline is bound"));
        };
        let bytes = bytemuck::bytes_of(value);
        let wanted = core.push_bytes as usize;
        if bytes.len() < wanted || bytes.len() >= wanted + 16 {
            let fault = format!("push constants have {wanted} bytes, but {} were given", bytes.len());
            return self.fail(GpuError::usage(&core.name, fault));
        }
        if wanted > 0 {
            let device = self.gpu.raw();
            unsafe { device.cmd_push_constants(self.raw, core.layout, core.push_stages, 0, &bytes[..wanted]) };
        }
    }

    /// Runs the bound compute pipeline on this many work groups.
    pub fn dispatch(&mut self, groups: [u32; 3]) {
        let most = self.gpu.limits().max_compute_work_group_count;
        if (0..3).any(|axis| groups[axis] > most[axis]) {
            return self.fail(GpuError::usage("dispatch", format!("{groups:?} work groups exceed {most:?}")));
        }
        if self.needs_bound(vk::PipelineBindPoint::COMPUTE) {
            unsafe { self.gpu.raw().cmd_dispatch(self.raw, groups[0], groups[1], groups[2]) };
        }
    }

    /// Runs the bound `pipeline` on at least this many invocations.
    pub fn dispatch_invocations(&mut self, pipeline: &ComputePipeline, invocations: [u32; 3]) {
        let local = pipeline.local_size();
        self.dispatch([0, 1, 2].map(|axis| invocations[axis].div_ceil(local[axis].max(1))));
    }

    /// Begins drawing into attachments of one size, with viewport and scissor over all of it. Clip space y points down.
    pub fn begin_rendering(&mut self, colors: &[ColorTarget<'_>], depth: Option<DepthTarget<'_>>) {
        let views = colors.iter().map(|c| c.view).chain(depth.iter().map(|d| d.view));
        let extents: Vec<[u32; 2]> = views.map(ImageView::extent).collect();
        let Some(&[width, height]) = extents.first() else {
            return self.fail(GpuError::usage("rendering", "there is no attachment"));
        };
        if extents.iter().any(|extent| *extent != [width, height]) {
            return self.fail(GpuError::usage("rendering", format!("the attachments differ in size: {extents:?}")));
        }
        let color_infos: Vec<_> = colors
            .iter()
            .map(|target| {
                let (operation, color) = match target.load {
                    Load::Clear(float32) => (vk::AttachmentLoadOp::CLEAR, vk::ClearColorValue { float32 }),
                    Load::ClearUint(uint32) => (vk::AttachmentLoadOp::CLEAR, vk::ClearColorValue { uint32 }),
                    Load::Keep => (vk::AttachmentLoadOp::LOAD, vk::ClearColorValue::default()),
                    Load::Discard => (vk::AttachmentLoadOp::DONT_CARE, vk::ClearColorValue::default()),
                };
                vk::RenderingAttachmentInfo::default()
                    .image_view(target.view.raw())
                    .image_layout(Use::ColorTarget.layout())
                    .load_op(operation)
                    .store_op(vk::AttachmentStoreOp::STORE)
                    .clear_value(vk::ClearValue { color })
            })
            .collect();
        let depth_info = depth.map(|target| {
            let depth_stencil = vk::ClearDepthStencilValue { depth: target.clear.unwrap_or(0.0), stencil: 0 };
            vk::RenderingAttachmentInfo::default()
                .image_view(target.view.raw())
                .image_layout(Use::DepthTarget.layout())
                .load_op(if target.clear.is_some() { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD })
                .store_op(vk::AttachmentStoreOp::STORE)
                .clear_value(vk::ClearValue { depth_stencil })
        });
        for view in colors.iter().map(|c| c.view).chain(depth.iter().map(|d| d.view)) {
            self.keep(&view.inner);
        }
        let area = vk::Rect2D::default().extent(vk::Extent2D { width, height });
        let mut info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&color_infos);
        if let Some(depth_info) = &depth_info {
            info = info.depth_attachment(depth_info);
        }
        unsafe { self.gpu.raw().cmd_begin_rendering(self.raw, &info) };
        self.viewport([0.0, 0.0, width as f32, height as f32]);
        self.scissor([0, 0, width, height]);
    }

    /// Ends drawing into the attachments.
    pub fn end_rendering(&mut self) {
        unsafe { self.gpu.raw().cmd_end_rendering(self.raw) };
    }

    /// Sets the viewport: x, y, width, height in pixels, depth 0 to 1. A negative height turns y upwards.
    pub fn viewport(&mut self, [x, y, width, height]: [f32; 4]) {
        let viewport = vk::Viewport { x, y, width, height, min_depth: 0.0, max_depth: 1.0 };
        unsafe { self.gpu.raw().cmd_set_viewport(self.raw, 0, &[viewport]) };
    }

    /// Sets the scissor: x, y, width, height in pixels.
    pub fn scissor(&mut self, [x, y, width, height]: [u32; 4]) {
        let offset = vk::Offset2D { x: x.cast_signed(), y: y.cast_signed() };
        let scissor = vk::Rect2D { offset, extent: vk::Extent2D { width, height } };
        unsafe { self.gpu.raw().cmd_set_scissor(self.raw, 0, &[scissor]) };
    }

    /// Binds 32-bit indices that start at a byte offset.
    pub fn bind_index_buffer(&mut self, buffer: &Buffer, offset: u64) {
        self.keep(&buffer.inner);
        unsafe { self.gpu.raw().cmd_bind_index_buffer(self.raw, buffer.raw(), offset, vk::IndexType::UINT32) };
    }

    /// Draws vertices (`gl_VertexIndex` runs over the range) of instances.
    pub fn draw(&mut self, vertices: Range<u32>, instances: Range<u32>) {
        if self.needs_bound(vk::PipelineBindPoint::GRAPHICS) {
            let (count, instance_count) = (vertices.len() as u32, instances.len() as u32);
            unsafe {
                self.gpu.raw().cmd_draw(self.raw, count, instance_count, vertices.start, instances.start);
            }
        }
    }

    /// Draws the vertices that a range of the index buffer names, `vertex_offset` added to each index.
    pub fn draw_indexed(&mut self, indices: Range<u32>, vertex_offset: i32, instances: Range<u32>) {
        if self.needs_bound(vk::PipelineBindPoint::GRAPHICS) {
            let (count, instance_count) = (indices.len() as u32, instances.len() as u32);
            let device = self.gpu.raw();
            unsafe {
                device.cmd_draw_indexed(self.raw, count, instance_count, indices.start, vertex_offset, instances.start);
            }
        }
    }

    /// Copies bytes between buffers.
    pub fn copy_buffer(&mut self, source: &Buffer, source_offset: u64, target: &Buffer, target_offset: u64, size: u64) {
        let fits = |offset: u64, buffer: &Buffer| offset.checked_add(size).is_some_and(|end| end <= buffer.size());
        if !fits(source_offset, source) || !fits(target_offset, target) {
            let fault = format!("{size} bytes do not fit {} or {}", source.name(), target.name());
            return self.fail(GpuError::usage("copy", fault));
        }
        if size == 0 {
            return;
        }
        self.keep(&source.inner);
        self.keep(&target.inner);
        let region = vk::BufferCopy { src_offset: source_offset, dst_offset: target_offset, size };
        unsafe { self.gpu.raw().cmd_copy_buffer(self.raw, source.raw(), target.raw(), &[region]) };
    }

    /// Fills a whole buffer with a 32-bit pattern (a last part of fewer than 4 bytes is left alone).
    pub fn fill_buffer(&mut self, buffer: &Buffer, pattern: u32) {
        self.keep(&buffer.inner);
        let size = buffer.size() / 4 * 4;
        unsafe { self.gpu.raw().cmd_fill_buffer(self.raw, buffer.raw(), 0, size, pattern) };
    }

    /// Copies tightly packed rows `rows` of a mip of a layer from a buffer; the image is in [`Use::CopyTarget`].
    pub fn copy_buffer_to_image(
        &mut self,
        source: &Buffer,
        offset: u64,
        target: &Image,
        mip: u32,
        layer: u32,
        rows: Range<u32>,
    ) {
        if let Some(region) = self.region(source, offset, target, mip, layer, rows) {
            let layout = Use::CopyTarget.layout();
            let device = self.gpu.raw();
            unsafe { device.cmd_copy_buffer_to_image(self.raw, source.raw(), target.raw(), layout, &[region]) };
        }
    }

    /// Copies rows `rows` of a mip of a layer into a buffer, tightly packed; the image is in [`Use::CopySource`].
    pub fn copy_image_to_buffer(
        &mut self,
        source: &Image,
        mip: u32,
        layer: u32,
        rows: Range<u32>,
        target: &Buffer,
        offset: u64,
    ) {
        if let Some(region) = self.region(target, offset, source, mip, layer, rows) {
            let layout = Use::CopySource.layout();
            let device = self.gpu.raw();
            unsafe { device.cmd_copy_image_to_buffer(self.raw, source.raw(), layout, target.raw(), &[region]) };
        }
    }

    fn region(
        &mut self,
        buffer: &Buffer,
        offset: u64,
        image: &Image,
        mip: u32,
        layer: u32,
        rows: Range<u32>,
    ) -> Option<vk::BufferImageCopy> {
        let texel = image.check_mip_layer(mip, layer).and_then(|()| image.texel_bytes());
        let texel = match texel {
            Ok(texel) => texel,
            Err(error) => {
                self.fail(error);
                return None;
            }
        };
        let [width, height] = image.mip_extent(mip);
        let bytes = texel * u64::from(width) * rows.len() as u64;
        if rows.is_empty() || rows.end > height || offset.checked_add(bytes).is_none_or(|end| end > buffer.size()) {
            let fault = format!("rows {rows:?} of mip {mip} do not fit the image or buffer {}", buffer.name());
            self.fail(GpuError::usage(image.name(), fault));
            return None;
        }
        self.keep(&buffer.inner);
        self.keep(&image.inner);
        let subresource = vk::ImageSubresourceLayers::default()
            .aspect_mask(image.aspect())
            .mip_level(mip)
            .base_array_layer(layer)
            .layer_count(1);
        Some(
            vk::BufferImageCopy::default()
                .buffer_offset(offset)
                .image_subresource(subresource)
                .image_offset(vk::Offset3D { x: 0, y: rows.start.cast_signed(), z: 0 })
                .image_extent(vk::Extent3D { width, height: rows.len() as u32, depth: 1 }),
        )
    }

    /// Copies mip 0 of layer 0 to an image of another size or format with filtering; from [`Use::CopySource`] to
    /// [`Use::CopyTarget`].
    pub fn blit(&mut self, source: &Image, target: &Image) {
        self.keep(&source.inner);
        self.keep(&target.inner);
        let layers = |image: &Image| {
            vk::ImageSubresourceLayers::default().aspect_mask(image.aspect()).base_array_layer(0).layer_count(1)
        };
        let corners = |image: &Image| {
            let [width, height] = image.mip_extent(0).map(u32::cast_signed);
            [vk::Offset3D::default(), vk::Offset3D { x: width, y: height, z: 1 }]
        };
        let region = vk::ImageBlit::default()
            .src_subresource(layers(source))
            .src_offsets(corners(source))
            .dst_subresource(layers(target))
            .dst_offsets(corners(target));
        let (from, to) = (Use::CopySource.layout(), Use::CopyTarget.layout());
        let filter = vk::Filter::LINEAR;
        let device = self.gpu.raw();
        unsafe { device.cmd_blit_image(self.raw, source.raw(), from, target.raw(), to, &[region], filter) };
    }

    /// Clears all mips and layers of a colour image, in [`Use::CopyTarget`].
    pub fn clear_image(&mut self, image: &Image, color: [f32; 4]) {
        self.keep(&image.inner);
        let color = vk::ClearColorValue { float32: color };
        let desc = image.desc();
        let range = subresources(image, 0..desc.mips, 0..desc.layers);
        let layout = Use::CopyTarget.layout();
        unsafe { self.gpu.raw().cmd_clear_color_image(self.raw, image.raw(), layout, &color, &[range]) };
    }

    /// Brings the whole image from the use it is in to the next. Between two equal uses that only read, nothing happens.
    pub fn transition(&mut self, image: &Image, to: Use) {
        let from = image.last_use();
        let reads = [Use::CopySource, Use::Sampled, Use::ComputeRead, Use::GraphicsRead, Use::Present];
        if from == to && reads.contains(&to) {
            return;
        }
        self.image_barrier(image, from, to);
    }

    /// Brings the whole image from one use to the next; [`Use::Undefined`] throws its content away.
    pub fn image_barrier(&mut self, image: &Image, from: Use, to: Use) {
        let desc = *image.desc();
        self.mip_barrier(image, 0..desc.mips, 0..desc.layers, from, to);
        image.set_last_use(to);
    }

    /// Brings some mips and layers from one use to the next. The image's remembered use does not change: the caller
    /// brings all parts back to one use and says so with [`Image::assume`].
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

    /// Orders everything earlier before everything later, the CPU's reads after the submission included.
    pub fn full_barrier(&mut self) {
        let all = vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE;
        let barrier = vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS | vk::PipelineStageFlags2::HOST)
            .dst_access_mask(all | vk::AccessFlags2::HOST_READ);
        self.barrier(&vk::DependencyInfo::default().memory_barriers(&[barrier]));
    }

    /// Orders all earlier accesses of one use before all later ones of another, for buffers of any kind.
    pub fn memory_barrier(&mut self, from: Use, to: Use) {
        let barrier = vk::MemoryBarrier2::default()
            .src_stage_mask(from.stages())
            .src_access_mask(from.access())
            .dst_stage_mask(to.stages())
            .dst_access_mask(to.access());
        self.barrier(&vk::DependencyInfo::default().memory_barriers(&[barrier]));
    }

    fn barrier(&mut self, dependency: &vk::DependencyInfo<'_>) {
        unsafe { self.gpu.raw().cmd_pipeline_barrier2(self.raw, dependency) };
    }

    /// Forgets the marks of earlier recordings; before the first [`timestamp`](Self::timestamp), outside rendering.
    pub fn reset_timestamps(&mut self, timestamps: &Timestamps) {
        self.keep(&timestamps.inner);
        timestamps.reset(self.raw);
    }

    /// Marks the moment when all earlier commands are done. Outside rendering: within, drivers do not separate draws.
    pub fn timestamp(&mut self, timestamps: &Timestamps, name: &str) {
        self.keep(&timestamps.inner);
        if let Err(error) = timestamps.mark(self.raw, name) {
            self.fail(error);
        }
    }

    fn needs_bound(&mut self, point: vk::PipelineBindPoint) -> bool {
        let bound = self.error.is_none() && self.pipeline.as_ref().is_some_and(|core| core.bind_point == point);
        if !bound {
            self.fail(GpuError::usage("commands", format!("no {point:?} pipeline is bound")));
        }
        bound
    }
}

fn subresources(image: &Image, mips: Range<u32>, layers: Range<u32>) -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange::default()
        .aspect_mask(image.aspect())
        .base_mip_level(mips.start)
        .level_count(mips.len() as u32)
        .base_array_layer(layers.start)
        .layer_count(layers.len() as u32)
}
