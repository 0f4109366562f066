//! Binds pipelines, their resources by name, and their push constants.

use std::any::Any;
use std::sync::Arc;

use ash::vk;

use super::pipeline_layout::PipelineCore;
use super::shaders::{ResourceKind, descriptor_type};
use super::{Buffer, Commands, GpuError, ImageView, Pipeline, Result, Sampler, SharedStruct, Use};

/// An object that can be bound to a resource of a shader.
#[derive(Clone, Copy)]
pub enum Descriptor<'a> {
    /// A whole uniform buffer.
    Uniform(&'a Buffer),
    /// A whole storage buffer.
    Storage(&'a Buffer),
    /// A texture in [`Use::Sampled`], with its sampler.
    Sampled(&'a ImageView, &'a Sampler),
    /// A storage image in one of the compute uses.
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

    /// Converts the descriptor to its Vulkan form. Calls `keep` with each object that the descriptor refers to.
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

/// Returns the Vulkan structure that writes a descriptor to binding `number`.
pub(crate) fn write(number: u32, kind: ResourceKind, info: &Info) -> vk::WriteDescriptorSet<'_> {
    let write = vk::WriteDescriptorSet::default().dst_binding(number).descriptor_type(descriptor_type(kind));
    match info {
        Info::Buffer(info) => write.buffer_info(std::slice::from_ref(info)),
        Info::Image(info) => write.image_info(std::slice::from_ref(info)),
    }
}

impl Commands {
    /// Binds a pipeline, and all resources of its set 0 by their names in the shaders. A block is named by its instance name or, if
    /// it has none, by its block name. Names that the shaders declare but do not use have no effect. Bind the longer-lived sets
    /// afterwards, with [`bind_set`](Self::bind_set).
    ///
    /// The submission fails if a resource is missing or given twice, or if no stage declares its name.
    pub fn bind(&mut self, pipeline: &impl Pipeline, resources: &[(&str, Descriptor<'_>)]) {
        let core = pipeline.core();
        // SAFETY: the command buffer is being recorded; `keep` and `self.pipeline` hold the pipeline.
        unsafe { self.gpu().raw().cmd_bind_pipeline(self.raw(), core.bind_point, core.raw()) };
        self.keep(&core);
        self.pipeline = Some(core.clone());
        self.bound = 0;
        if let Err(error) = self.push_descriptors(&core, resources) {
            self.fail(error);
        }
    }

    /// Writes the descriptor of every slot of the pipeline.
    fn push_descriptors(&mut self, core: &PipelineCore, resources: &[(&str, Descriptor<'_>)]) -> Result<()> {
        let slots = core.slots.iter().map(|slot| (slot.name, slot.kind));
        let stranger = |name: &str| {
            format!("no resource {name} is declared by its shaders; they declare {}", core.resource_names())
        };
        let descriptors = in_order(&core.name, slots, resources, |name| core.unused.contains(&name), stranger)?;
        let infos: Vec<_> =
            descriptors.iter().map(|given| (given.kind(), given.info(&mut |it| self.keep.push(it)))).collect();
        let numbered = (0u32..).zip(&infos);
        let writes: Vec<_> = numbered.map(|(number, (kind, info))| write(number, *kind, info)).collect();
        if !writes.is_empty() {
            let push = &self.gpu().push_descriptor;
            // SAFETY: the command buffer is being recorded, the writes fit the layout, and `keep` holds what they refer to.
            unsafe { push.cmd_push_descriptor_set(self.raw(), core.bind_point, core.layout(), 0, &writes) };
        }
        Ok(())
    }

    /// Sets the push constants of the bound pipeline. `T` must be the struct that was passed when the pipeline was created.
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
            unsafe { device.cmd_push_constants(self.raw(), core.layout(), push.stages, 0, bytes) };
        }
    }
}

/// A descriptor in Vulkan's form.
pub(crate) enum Info {
    Buffer(vk::DescriptorBufferInfo),
    Image(vk::DescriptorImageInfo),
}

/// Returns the descriptors in the order of the slots. `ignored` returns whether a name without a slot is allowed. `stranger`
/// returns the error message for any other name.
///
/// # Errors
/// Returns [`GpuError::Usage`], which names `owner`, if a resource is missing, given twice or of the wrong kind, or if its name is
/// unknown.
pub(crate) fn in_order<'d>(
    owner: &str,
    slots: impl ExactSizeIterator<Item = (&'static str, ResourceKind)> + Clone,
    resources: &[(&str, Descriptor<'d>)],
    ignored: impl Fn(&str) -> bool,
    stranger: impl Fn(&str) -> String,
) -> Result<Vec<Descriptor<'d>>> {
    let fault = |fault: String| Err(GpuError::usage(owner, fault));
    let mut descriptors = Vec::with_capacity(slots.len());
    let is_slot = |name: &str| slots.clone().any(|(slot, _)| slot == name);
    if let Some((name, _)) = resources.iter().find(|(name, _)| !is_slot(name) && !ignored(name)) {
        return fault(stranger(name));
    }
    let twice =
        |(index, (name, _)): &(usize, &(&str, Descriptor<'d>))| resources[..*index].iter().any(|(n, _)| n == name);
    if let Some((_, (name, _))) = resources.iter().enumerate().find(twice) {
        return fault(format!("{name} was given twice"));
    }
    for (name, kind) in slots.clone() {
        match resources.iter().find(|(given, _)| *given == name) {
            Some((_, descriptor)) if descriptor.kind() == kind => descriptors.push(*descriptor),
            Some((_, other)) => return fault(format!("{name} is {}, not {}", kind.words(), other.kind().words())),
            None => return fault(format!("{name} ({}) was not given", kind.words())),
        }
    }
    Ok(descriptors)
}
