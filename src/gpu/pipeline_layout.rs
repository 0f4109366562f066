//! What pipelines share. Layouts come from the shaders: set 0 holds push descriptors, the push constant range is the
//! largest of the stages'.

use std::ffi::CStr;
use std::sync::Arc;

use ash::vk;

use super::error::Doing;
use super::reflect::{self, Binding, Interface};
use super::{Gpu, GpuError, Result, shaders};

/// The value of a specialization constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpecValue {
    /// `bool`
    Bool(bool),
    /// `uint`
    U32(u32),
    /// `int`
    I32(i32),
    /// `float`
    F32(f32),
}

impl SpecValue {
    fn bits(self) -> u32 {
        match self {
            Self::Bool(value) => u32::from(value),
            Self::U32(value) => value,
            Self::I32(value) => value.cast_unsigned(),
            Self::F32(value) => value.to_bits(),
        }
    }
}

/// Specialization constants: `constant_id` and value. Identifiers that a shader does not have are ignored.
pub type Spec<'a> = &'a [(u32, SpecValue)];

/// What compute and graphics pipelines share.
#[doc(hidden)]
pub struct PipelineCore {
    gpu: Arc<Gpu>,
    pub(crate) name: String,
    pub(crate) bind_point: vk::PipelineBindPoint,
    pub(crate) raw: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    set_layout: vk::DescriptorSetLayout,
    pub(crate) bindings: Vec<Binding>,
    pub(crate) push_stages: vk::ShaderStageFlags,
    pub(crate) push_bytes: u32,
}

impl Drop for PipelineCore {
    fn drop(&mut self) {
        let device = self.gpu.raw();
        // SAFETY: commands that use the pipeline hold an Arc of it until they are done; null handles are ignored.
        unsafe {
            device.destroy_pipeline(self.raw, None);
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

/// A shader module that lives while its pipeline is made.
pub(crate) struct Stage<'a> {
    gpu: &'a Gpu,
    module: vk::ShaderModule,
    pub(crate) interface: Interface,
}

impl Drop for Stage<'_> {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules once made.
        unsafe { self.gpu.raw().destroy_shader_module(self.module, None) };
    }
}

impl<'a> Stage<'a> {
    pub(crate) fn load(gpu: &'a Gpu, name: &str, stage: vk::ShaderStageFlags) -> Result<Self> {
        let spirv = shaders::spirv(name)?;
        let interface = reflect::interface(name, spirv)?;
        if interface.stage != stage {
            let fault = format!("it is a {:?} shader where a {stage:?} shader is needed", interface.stage);
            return Err(GpuError::Shader { name: name.to_owned(), fault });
        }
        let info = vk::ShaderModuleCreateInfo::default().code(spirv);
        // SAFETY: the words were compiled by shaderc for Vulkan 1.3.
        let module = unsafe { gpu.raw().create_shader_module(&info, None) }.doing(format!("creating shader {name}"))?;
        gpu.name(module, name);
        Ok(Self { gpu, module, interface })
    }

    pub(crate) fn info<'b>(&'b self, special: &'b vk::SpecializationInfo<'b>) -> vk::PipelineShaderStageCreateInfo<'b> {
        const MAIN: &CStr = c"main";
        vk::PipelineShaderStageCreateInfo::default()
            .stage(self.interface.stage)
            .module(self.module)
            .name(MAIN)
            .specialization_info(special)
    }
}

/// Specialization constants in Vulkan's form: all are four bytes wide.
pub(crate) struct Constants {
    entries: Vec<vk::SpecializationMapEntry>,
    data: Vec<u8>,
}

impl Constants {
    pub(crate) fn new(spec: Spec<'_>) -> Self {
        let entry = |(i, (id, _)): (usize, &(u32, SpecValue))| {
            vk::SpecializationMapEntry::default().constant_id(*id).offset(4 * i as u32).size(4)
        };
        Self {
            entries: spec.iter().enumerate().map(entry).collect(),
            data: spec.iter().flat_map(|(_, value)| value.bits().to_ne_bytes()).collect(),
        }
    }

    pub(crate) fn info(&self) -> vk::SpecializationInfo<'_> {
        vk::SpecializationInfo::default().map_entries(&self.entries).data(&self.data)
    }
}

/// The layouts that serve all stages, in a core that has no pipeline yet.
pub(crate) fn layout(
    gpu: &Arc<Gpu>,
    name: &str,
    bind_point: vk::PipelineBindPoint,
    interfaces: &[&Interface],
) -> Result<PipelineCore> {
    let bindings = merge(name, interfaces)?;
    let push_bytes = interfaces.iter().map(|i| i.push_constant_bytes).max().unwrap_or(0).next_multiple_of(4);
    if push_bytes > gpu.limits().max_push_constants_size {
        let most = gpu.limits().max_push_constants_size;
        return Err(GpuError::usage(name, format!("{push_bytes} bytes of push constants exceed the device's {most}")));
    }
    let push_stages = interfaces
        .iter()
        .filter(|i| i.push_constant_bytes > 0)
        .fold(vk::ShaderStageFlags::empty(), |stages, i| stages | i.stage);
    let mut core = PipelineCore {
        gpu: gpu.clone(),
        name: name.to_owned(),
        bind_point,
        raw: vk::Pipeline::null(),
        layout: vk::PipelineLayout::null(),
        set_layout: vk::DescriptorSetLayout::null(),
        bindings,
        push_stages,
        push_bytes,
    };
    let slots: Vec<_> = core
        .bindings
        .iter()
        .map(|b| {
            vk::DescriptorSetLayoutBinding::default()
                .binding(b.binding)
                .descriptor_type(b.kind)
                .descriptor_count(b.count)
                .stage_flags(b.stages)
        })
        .collect();
    let info = vk::DescriptorSetLayoutCreateInfo::default()
        .flags(vk::DescriptorSetLayoutCreateFlags::PUSH_DESCRIPTOR_KHR)
        .bindings(&slots);
    // SAFETY: the device is alive; `core` destroys whatever was created.
    core.set_layout = unsafe { gpu.raw().create_descriptor_set_layout(&info, None) }
        .doing(format!("creating the descriptor layout of {name}"))?;
    gpu.name(core.set_layout, name);
    let sets = [core.set_layout];
    let ranges = [vk::PushConstantRange::default().stage_flags(push_stages).size(push_bytes)];
    let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
    if push_bytes > 0 {
        info = info.push_constant_ranges(&ranges);
    }
    core.layout = unsafe { gpu.raw().create_pipeline_layout(&info, None) }
        .doing(format!("creating the pipeline layout of {name}"))?;
    gpu.name(core.layout, name);
    Ok(core)
}

/// The union of the stages' bindings.
fn merge(name: &str, interfaces: &[&Interface]) -> Result<Vec<Binding>> {
    let mut merged: Vec<Binding> = Vec::new();
    for binding in interfaces.iter().flat_map(|interface| &interface.bindings) {
        if binding.count != 1 {
            let fault = format!("binding {} is an array; use an array texture", binding.binding);
            return Err(GpuError::Shader { name: name.to_owned(), fault });
        }
        match merged.iter_mut().find(|known| known.binding == binding.binding) {
            Some(known) if known.kind == binding.kind => known.stages |= binding.stages,
            Some(known) => {
                let fault = format!("binding {} is {:?} and {:?}", binding.binding, known.kind, binding.kind);
                return Err(GpuError::Shader { name: name.to_owned(), fault });
            }
            None => merged.push(*binding),
        }
    }
    merged.sort_by_key(|binding| binding.binding);
    Ok(merged)
}
