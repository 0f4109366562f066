//! Binding: pipelines, their resources by name, and their push constants.

use std::any::Any;
use std::sync::Arc;

use ash::vk;

use super::pipeline_layout::{PipelineCore, Slot};
use super::shaders::{ResourceKind, descriptor_type};
use super::{Buffer, Commands, GpuError, ImageView, Pipeline, Result, Sampler, SharedStruct, Use};

/// What a shader's resource is bound to.
#[derive(Clone, Copy)]
pub enum Descriptor<'a> {
    /// A whole uniform buffer.
    Uniform(&'a Buffer),
    /// A whole storage buffer.
    Storage(&'a Buffer),
    /// A texture, in [`Use::Sampled`].
    Sampled(&'a ImageView, &'a Sampler),
    /// A storage image, in one of the compute uses.
    StorageImage(&'a ImageView),
}

impl Descriptor<'_> {
    pub(crate) fn kind(&self) -> ResourceKind {
        match self {
            Self::Uniform(_) => ResourceKind::Uniform,
            Self::Storage(_) => ResourceKind::Storage,
            Self::Sampled(..) => ResourceKind::Sampled,
            Self::StorageImage(_) => ResourceKind::StorageImage,
        }
    }

    /// The descriptor in Vulkan's form; hands what it refers to to `keep`.
    pub(crate) fn info(&self, keep: &mut dyn FnMut(Arc<dyn Any + Send + Sync>)) -> Info {
        match self {
            Self::Uniform(buffer) | Self::Storage(buffer) => {
                keep(buffer.inner.clone());
                Info::Buffer(vk::DescriptorBufferInfo::default().buffer(buffer.raw()).range(vk::WHOLE_SIZE))
            }
            Self::Sampled(view, sampler) => {
                keep(view.inner.clone());
                keep(sampler.inner.clone());
                let info = vk::DescriptorImageInfo::default().image_view(view.raw()).sampler(sampler.raw());
                Info::Image(info.image_layout(Use::Sampled.layout()))
            }
            Self::StorageImage(view) => {
                keep(view.inner.clone());
                let info = vk::DescriptorImageInfo::default().image_view(view.raw());
                Info::Image(info.image_layout(vk::ImageLayout::GENERAL))
            }
        }
    }
}

/// Writes a descriptor to a binding.
pub(crate) fn write(number: u32, kind: ResourceKind, info: &Info) -> vk::WriteDescriptorSet<'_> {
    let write = vk::WriteDescriptorSet::default().dst_binding(number).descriptor_type(descriptor_type(kind));
    match info {
        Info::Buffer(info) => write.buffer_info(std::slice::from_ref(info)),
        Info::Image(info) => write.image_info(std::slice::from_ref(info)),
    }
}

impl Commands {
    /// Binds a pipeline and all resources of its set 0, by their names in its shaders. The name of a block is its instance name or,
    /// if it has none, the block's own. Names that the shaders declare but do not use have no effect. The sets that outlast a pipeline
    /// are bound after it, by [`bind_set`](Self::bind_set).
    ///
    /// The submission fails if a name is missing, is not declared in any stage, or is given twice.
    pub fn bind(&mut self, pipeline: &impl Pipeline, resources: &[(&str, Descriptor<'_>)]) {
        let core = pipeline.core();
        // SAFETY: the command buffer is being recorded; `keep` and `self.pipeline` hold the pipeline.
        unsafe { self.gpu().raw().cmd_bind_pipeline(self.raw(), core.bind_point, core.raw) };
        self.keep(&core);
        self.pipeline = Some(core.clone());
        self.bound = 0;
        if let Err(error) = check_names(&core, resources) {
            return self.fail(error);
        }
        self.push_descriptors(&core, resources);
    }

    /// Writes the descriptor of every slot of the pipeline.
    fn push_descriptors(&mut self, core: &PipelineCore, resources: &[(&str, Descriptor<'_>)]) {
        let mut infos = Vec::with_capacity(core.slots.len());
        for slot in &core.slots {
            let Some((_, descriptor)) = resources.iter().find(|(name, _)| *name == slot.name) else { continue };
            if let Err(error) = check_kind(core, slot, descriptor) {
                return self.fail(error);
            }
            infos.push(descriptor.info(&mut |object| self.keep.push(object)));
        }
        let numbered = (0u32..).zip(core.slots.iter().zip(&infos));
        let writes: Vec<_> = numbered.map(|(number, (slot, info))| write(number, slot.kind, info)).collect();
        if writes.is_empty() {
            return;
        }
        let push = &self.gpu().push_descriptor;
        // SAFETY: the command buffer is being recorded, the writes fit the layout, and `keep` holds what they refer to.
        unsafe { push.cmd_push_descriptor_set(self.raw(), core.bind_point, core.layout, 0, &writes) };
    }

    /// Sets the push constants of the bound pipeline; the type must be the one that the pipeline was made with.
    pub fn push_constants<T: SharedStruct>(&mut self, value: &T) {
        let Some(core) = self.pipeline.clone() else {
            return self.fail(GpuError::usage("push constants", "no pipeline is bound"));
        };
        let Some(push) = core.push.as_ref().filter(|push| push.rust == T::LAYOUT.rust) else {
            let wanted = core.push.as_ref().map_or("none", |push| push.rust);
            let fault = format!("its push constants are {wanted}, but {} was given", T::LAYOUT.rust);
            return self.fail(GpuError::usage(&core.name, fault));
        };
        if push.bytes > 0 {
            let (device, bytes) = (self.gpu().raw(), &bytemuck::bytes_of(value)[..push.bytes]);
            // SAFETY: the command buffer is being recorded, and the layout has a range of these bytes and stages.
            unsafe { device.cmd_push_constants(self.raw(), core.layout, push.stages, 0, bytes) };
        }
    }
}

/// A descriptor in Vulkan's form.
pub(crate) enum Info {
    Buffer(vk::DescriptorBufferInfo),
    Image(vk::DescriptorImageInfo),
}

/// Checks that every slot is given, and that the shaders declare every name.
fn check_names(core: &PipelineCore, resources: &[(&str, Descriptor<'_>)]) -> Result<()> {
    let given = |name: &str| resources.iter().filter(|(given, _)| *given == name).count();
    if let Some(missing) = core.slots.iter().find(|slot| given(slot.name) == 0) {
        let fault = format!("{} ({}) was not given", missing.name, missing.kind.words());
        return Err(GpuError::usage(&core.name, fault));
    }
    if resources.len() == core.slots.len() {
        return Ok(());
    }
    for (name, _) in resources {
        let declared = core.slots.iter().map(|slot| slot.name).chain(core.unused.iter().copied());
        if !declared.into_iter().any(|known| known == *name) {
            let fault =
                format!("no resource {name} is declared by its shaders; they declare {}", core.resource_names());
            return Err(GpuError::usage(&core.name, fault));
        }
        if given(name) > 1 {
            return Err(GpuError::usage(&core.name, format!("{name} was given twice")));
        }
    }
    Ok(())
}

fn check_kind(core: &PipelineCore, slot: &Slot, descriptor: &Descriptor<'_>) -> Result<()> {
    if slot.kind == descriptor.kind() {
        return Ok(());
    }
    let fault = format!("{} is {}, not {}", slot.name, slot.kind.words(), descriptor.kind().words());
    Err(GpuError::usage(&core.name, fault))
}
