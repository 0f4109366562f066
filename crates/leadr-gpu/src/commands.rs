//! Records dispatches, draws and timestamps. Binding, barriers and copies are in separate files.

use std::any::Any;
use std::ffi::CString;
use std::ops::Range;
use std::sync::Arc;

use super::image::ImageInner;
use super::pipeline_layout::PipelineCore;
use super::timestamps::TimestampsInner;
use super::{ComputePipeline, Gpu, GpuError, Image, ImageView, Result, Timestamps, Use};
use ash::vk;

/// The content of a colour attachment at the start of rendering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// Clears the attachment to this colour.
    Clear([f32; 4]),
    /// Clears the attachment to these integers, for integer formats.
    ClearUint([u32; 4]),
    /// Keeps the previous content.
    Keep,
    /// Leaves the content undefined, for passes that draw every pixel.
    Discard,
}

/// A colour attachment, which is a view of one mip of one layer in [`Use::ColorTarget`].
#[derive(Clone, Copy)]
pub struct ColorTarget<'a> {
    /// The attachment.
    pub view: &'a ImageView,
    /// The content at the start of rendering.
    pub load: Load,
}

/// A depth attachment, which must be in [`Use::DepthTarget`].
#[derive(Clone, Copy)]
pub struct DepthTarget<'a> {
    /// The attachment.
    pub view: &'a ImageView,
    /// The depth to clear to, where 0 is farthest for reversed depth. `None` keeps the previous content.
    pub clear: Option<f32>,
}

/// A list of commands that is being recorded. The submission reports the first misuse, so recording code needs no error handling.
/// All recorded objects stay alive until the device has finished the commands.
pub struct Commands {
    gpu: Arc<Gpu>,
    raw: vk::CommandBuffer,
    pub(super) pipeline: Option<Arc<PipelineCore>>,
    /// A bit mask of the sets that are bound to the pipeline.
    pub(super) bound: u32,
    pub(super) keep: Vec<Arc<dyn Any + Send + Sync>>,
    effects: Effects,
    rendering: bool,
    error: Option<GpuError>,
}

/// Changes to the state of objects that take effect only when the commands are submitted.
#[derive(Default)]
pub(crate) struct Effects {
    /// The use of each image after the commands have run.
    uses: Vec<(Arc<ImageInner>, Use)>,
    /// The names of the marks that were recorded in each [`Timestamps`].
    marks: Vec<(Arc<TimestampsInner>, Vec<String>)>,
}

impl Effects {
    /// Applies the changes. The commands must have been submitted.
    pub(crate) fn commit(&mut self) {
        for (image, last) in self.uses.drain(..) {
            image.set_last_use(last);
        }
        for (timestamps, names) in self.marks.drain(..) {
            timestamps.set_names(names);
        }
    }
}

/// The objects that recorded commands need until they are done, and the state changes of the commands.
pub(crate) struct Recorded {
    pub(crate) keep: Vec<Arc<dyn Any + Send + Sync>>,
    pub(crate) effects: Effects,
}

impl Commands {
    pub(crate) fn new(gpu: &Arc<Gpu>, raw: vk::CommandBuffer) -> Self {
        Self {
            gpu: gpu.clone(),
            raw,
            pipeline: None,
            bound: 0,
            keep: Vec::new(),
            effects: Effects::default(),
            rendering: false,
            error: None,
        }
    }

    /// Returns the recorded objects and state changes, or the first misuse as an error.
    pub(crate) fn finish(self) -> Result<Recorded> {
        self.error.map_or(Ok(Recorded { keep: self.keep, effects: self.effects }), Err)
    }

    /// Returns the use of the whole image after the commands recorded so far.
    pub(crate) fn use_of(&self, image: &Image) -> Use {
        let recorded = self.effects.uses.iter().find(|(known, _)| Arc::ptr_eq(known, &image.inner));
        recorded.map_or_else(|| image.last_use(), |(_, last)| *last)
    }

    pub(crate) fn set_use(&mut self, image: &Image, last: Use) {
        match self.effects.uses.iter_mut().find(|(known, _)| Arc::ptr_eq(known, &image.inner)) {
            Some((_, recorded)) => *recorded = last,
            None => self.effects.uses.push((image.inner.clone(), last)),
        }
    }

    /// Returns the raw command buffer.
    pub fn raw(&self) -> vk::CommandBuffer {
        self.raw
    }

    /// Returns the device.
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// Makes the submission fail with this error, unless an earlier error was recorded.
    pub fn fail(&mut self, error: GpuError) {
        self.error.get_or_insert(error);
    }

    /// Keeps an object alive until the commands are done.
    pub fn keep<T: Any + Send + Sync>(&mut self, object: &Arc<T>) {
        self.keep.push(object.clone());
    }

    /// Records commands in a region that captures and validation messages show under this name.
    pub fn label<R>(&mut self, name: &str, record: impl FnOnce(&mut Self) -> R) -> R {
        let text = CString::new(name).unwrap_or_default();
        if let Some(debug) = &self.gpu.debug {
            let info = vk::DebugUtilsLabelEXT::default().label_name(&text);
            let _labels = self.gpu.lock_labels();
            // SAFETY: the command buffer is being recorded, and the text outlives the call.
            unsafe { debug.cmd_begin_debug_utils_label(self.raw, &info) };
        }
        let result = record(self);
        if let Some(debug) = &self.gpu.debug {
            let _labels = self.gpu.lock_labels();
            // SAFETY: the command buffer is being recorded, with the region that was begun above.
            unsafe { debug.cmd_end_debug_utils_label(self.raw) };
        }
        result
    }

    /// Records the same commands `times` times in sequence, in one [`label`](Self::label). `record` must include the barriers
    /// between the repetitions.
    pub fn label_times(&mut self, name: &str, times: u32, record: impl Fn(&mut Self)) {
        self.label(name, |cmd| (0..times).for_each(|_| record(cmd)));
    }

    /// Dispatches this many work groups of the bound compute pipeline.
    pub fn dispatch(&mut self, groups: [u32; 3]) {
        let most = self.gpu.limits().max_compute_work_group_count;
        if (0..3).any(|axis| groups[axis] > most[axis]) {
            return self.fail(GpuError::usage("dispatch", format!("{groups:?} work groups exceed {most:?}")));
        }
        if self.needs_bound(vk::PipelineBindPoint::COMPUTE) {
            // SAFETY: the command buffer is being recorded, a compute pipeline is bound, and the counts are within limits.
            unsafe { self.gpu.raw().cmd_dispatch(self.raw, groups[0], groups[1], groups[2]) };
        }
    }

    /// Dispatches enough work groups of the bound `pipeline` for at least this many invocations.
    pub fn dispatch_invocations(&mut self, pipeline: &ComputePipeline, invocations: [u32; 3]) {
        let local = pipeline.local_size();
        self.dispatch([0, 1, 2].map(|axis| invocations[axis].div_ceil(local[axis].max(1))));
    }

    /// Begins drawing into attachments of equal size. The viewport and the scissor cover the whole attachments. In clip space, y
    /// points down.
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
        // SAFETY: the command buffer is being recorded and keeps the attachments alive, and all of them have one size.
        unsafe { self.gpu.raw().cmd_begin_rendering(self.raw, &info) };
        self.rendering = true;
        self.viewport([0.0, 0.0, width as f32, height as f32]);
        self.scissor([0, 0, width, height]);
    }

    /// Ends drawing into the attachments.
    pub fn end_rendering(&mut self) {
        if std::mem::take(&mut self.rendering) {
            // SAFETY: the command buffer is being recorded, and rendering was begun.
            unsafe { self.gpu.raw().cmd_end_rendering(self.raw) };
        }
    }

    /// Sets the viewport (x, y, width and height in pixels) with depth from 0 to 1. A negative height flips y.
    pub fn viewport(&mut self, [x, y, width, height]: [f32; 4]) {
        let viewport = vk::Viewport { x, y, width, height, min_depth: 0.0, max_depth: 1.0 };
        // SAFETY: the command buffer is being recorded.
        unsafe { self.gpu.raw().cmd_set_viewport(self.raw, 0, &[viewport]) };
    }

    /// Sets the scissor rectangle (x, y, width and height in pixels).
    pub fn scissor(&mut self, [x, y, width, height]: [u32; 4]) {
        let offset = vk::Offset2D { x: x.cast_signed(), y: y.cast_signed() };
        let scissor = vk::Rect2D { offset, extent: vk::Extent2D { width, height } };
        // SAFETY: the command buffer is being recorded.
        unsafe { self.gpu.raw().cmd_set_scissor(self.raw, 0, &[scissor]) };
    }

    /// Draws ranges of vertices and instances. `gl_VertexIndex` takes the values in `vertices`.
    pub fn draw(&mut self, vertices: Range<u32>, instances: Range<u32>) {
        if self.needs_bound(vk::PipelineBindPoint::GRAPHICS) {
            let (count, instance_count) = (vertices.len() as u32, instances.len() as u32);
            // SAFETY: the command buffer is being recorded, and a graphics pipeline is bound.
            unsafe {
                self.gpu.raw().cmd_draw(self.raw, count, instance_count, vertices.start, instances.start);
            }
        }
    }

    /// Begins a new series of marks. Call it outside rendering, before the first [`timestamp`](Self::timestamp).
    pub fn reset_timestamps(&mut self, timestamps: &Timestamps) {
        self.keep(&timestamps.inner);
        self.effects.marks.retain(|(known, _)| !Arc::ptr_eq(known, &timestamps.inner));
        self.effects.marks.push((timestamps.inner.clone(), Vec::new()));
        timestamps.inner.reset(self.raw);
    }

    /// Records the time at which all earlier commands are done. Call it outside rendering, because drivers do not measure separate
    /// draws inside a rendering.
    pub fn timestamp(&mut self, timestamps: &Timestamps, name: &str) {
        let known = self.effects.marks.iter_mut().find(|(known, _)| Arc::ptr_eq(known, &timestamps.inner));
        let Some((inner, names)) = known else {
            return self.fail(GpuError::usage(name, "the timestamps were not reset in this recording"));
        };
        match inner.mark(self.raw, names.len()) {
            Ok(()) => names.push(name.to_owned()),
            Err(error) => self.fail(error),
        }
    }

    fn needs_bound(&mut self, point: vk::PipelineBindPoint) -> bool {
        if self.error.is_some() {
            return false;
        }
        let Some(core) = self.pipeline.as_ref().filter(|core| core.bind_point == point) else {
            self.fail(GpuError::usage("commands", format!("no {point:?} pipeline is bound")));
            return false;
        };
        let unbound = core.sets.iter().flatten().find(|layout| self.bound >> layout.number & 1 == 0);
        if let Some(layout) = unbound {
            let error = GpuError::usage(&core.name, format!("the set {} was not bound", layout.name));
            self.fail(error);
            return false;
        }
        true
    }
}
