//! Recording: descriptors, dispatches, draws and timestamps. Barriers and copies have files of their own.

use std::any::Any;
use std::ffi::CString;
use std::ops::Range;
use std::sync::Arc;

use ash::vk;
use bytemuck::NoUninit;

use super::pipeline_layout::PipelineCore;
use super::{Buffer, ComputePipeline, Gpu, GpuError, ImageView, Pipeline, Result, Sampler, Timestamps, Use};

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

    /// [`label`](Self::label) around the same commands recorded `times` times, one after the other. What they need to
    /// wait for each other is theirs to record.
    pub fn label_times(&mut self, name: &str, times: u32, record: impl Fn(&mut Self)) {
        self.label(name, |cmd| (0..times).for_each(|_| record(cmd)));
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
        if self.error.is_some() {
            return;
        }
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
