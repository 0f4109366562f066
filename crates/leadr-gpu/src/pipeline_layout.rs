//! The parts that compute and graphics pipelines share. The pipeline layout is derived from the shaders. Set 0 holds push
//! descriptors, binding numbers are assigned by resource name, and the push constant range is the largest range of any stage.

use std::ffi::CStr;
use std::hash::Hash;
use std::sync::Arc;
use std::time::Instant;

use ash::vk;

use super::error::Doing;
use super::pipeline_handles::{PipelineHandles, wide_hash};
use super::sets::{SETS, SetLayout, descriptor_layout};
use super::shaders::{ConstantKind, ResourceKind, Shader, Stage, stage_flags};
use super::spirv::{leave_loops_to_driver, specialized};
use super::{DriverCall, Gpu, GpuError, Result, StructLayout, shared_struct};
use leadr_glsl::reflect::{Interface, interface};

/// The empty layout for set numbers that a pipeline does not use.
static EMPTY: SetLayout = SetLayout { number: 1, name: "nothing", resources: &[] };

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

    fn kind(self) -> ConstantKind {
        match self {
            Self::Bool(_) => ConstantKind::Bool,
            Self::U32(_) => ConstantKind::U32,
            Self::I32(_) => ConstantKind::I32,
            Self::F32(_) => ConstantKind::F32,
        }
    }
}

/// Values of specialization constants, by their GLSL names. Constants that are not listed keep the shader's defaults.
pub type Spec<'a> = &'a [(&'a str, SpecValue)];

/// The state that compute and graphics pipelines share.
#[doc(hidden)]
pub struct PipelineCore {
    // The handles are dropped before the device.
    handles: Arc<PipelineHandles>,
    gpu: Arc<Gpu>,
    pub(crate) name: String,
    pub(crate) bind_point: vk::PipelineBindPoint,
    /// The resources of set 0 that must be bound. The index of a slot is its binding number.
    pub(crate) slots: Vec<Slot>,
    /// The layouts of the longer-lived sets, by set number. The entry of an unused number is `None`.
    pub(crate) sets: [Option<&'static SetLayout>; SETS],
    /// The names of declared resources that the pipeline does not use with these constants. Binding them has no effect.
    pub(crate) unused: Vec<&'static str>,
    pub(crate) push: Option<PushConstants>,
    /// The work group size of a compute pipeline, with specialization constants at their defaults.
    pub(crate) local_size: [u32; 3],
}

#[derive(Debug)]
pub(crate) struct Slot {
    pub(crate) name: &'static str,
    pub(crate) kind: ResourceKind,
    stages: vk::ShaderStageFlags,
}

pub(crate) struct PushConstants {
    /// The [`StructLayout::rust`] of the push constants' type.
    pub(crate) rust: &'static str,
    /// The stages that use the push constants. There may be none.
    pub(crate) stages: vk::ShaderStageFlags,
    pub(crate) bytes: usize,
}

/// What a pipeline declares to the driver besides its code and its state.
struct Declared {
    slots: Vec<Slot>,
    unused: Vec<&'static str>,
    sets: [Option<&'static SetLayout>; SETS],
    push: Option<PushConstants>,
}

impl PipelineCore {
    /// Creates a pipeline from its stages. `state` is everything else that `create` tells the driver: pipelines with the same stages
    /// and the same state share their handles.
    ///
    /// # Errors
    /// Returns [`GpuError::Shader`] if the stages are inconsistent with each other or with the Rust twins of their structs. Returns
    /// [`GpuError::Usage`] if the push constants are larger than the device supports. Returns the errors of `create`.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        name: &str,
        bind_point: vk::PipelineBindPoint,
        stages: Vec<SpecializedStage>,
        structs: &[StructLayout],
        state: impl Hash,
        create: impl FnOnce(&[StageModule<'_>], vk::PipelineLayout) -> Result<vk::Pipeline>,
    ) -> Result<Self> {
        let shaders: Vec<&Shader> = stages.iter().map(|stage| stage.shader).collect();
        shared_struct::check(name, &shaders, structs)?;
        let (slots, unused) = resources(name, &stages)?;
        let sets = used_sets(gpu, name, &stages)?;
        let push = push_constants(name, &stages, structs)?;
        let declared = Declared { slots, unused, sets, push };
        let stages: Vec<_> = stages.into_iter().map(|stage| NumberedStage::new(gpu, &declared, stage)).collect();
        gpu.faults().check(DriverCall::Pipeline).doing(format!("creating pipeline {name}"))?;
        let code: Vec<_> = stages.iter().map(|stage| (stage.shader.stage, &stage.words)).collect();
        let key = wide_hash(&(bind_point, code, declared.described(), state));
        let handles = gpu.known_pipelines().find_or_make(key, || {
            let mut handles = PipelineHandles::new(gpu);
            declared.create_layouts(gpu, name, &mut handles)?;
            let modules = stages.iter().map(|stage| StageModule::new(gpu, stage)).collect::<Result<Vec<_>>>()?;
            let begun = Instant::now();
            handles.raw = create(&modules, handles.layout)?;
            tracing::trace!("the driver took {:.1} ms for pipeline {name}", begun.elapsed().as_secs_f64() * 1e3);
            gpu.name(handles.raw, name);
            Ok(handles)
        })?;
        let Declared { slots, unused, sets, push } = declared;
        Ok(Self {
            handles,
            gpu: gpu.clone(),
            name: name.to_owned(),
            bind_point,
            slots,
            unused,
            sets,
            push,
            local_size: [1; 3],
        })
    }

    pub(super) fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// Returns the raw pipeline. Pipelines of the same code and state have the same one.
    pub fn raw(&self) -> vk::Pipeline {
        self.handles.raw
    }

    pub(crate) fn layout(&self) -> vk::PipelineLayout {
        self.handles.layout
    }

    /// Returns the names of the resources that may be bound, for error messages.
    pub(crate) fn resource_names(&self) -> String {
        let names: Vec<&str> = self.slots.iter().map(|slot| slot.name).chain(self.unused.iter().copied()).collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    }
}

impl Declared {
    /// Returns all that the layouts depend on.
    fn described(&self) -> impl Hash {
        let slots: Vec<_> = self.slots.iter().map(|slot| (slot.kind, slot.stages)).collect();
        // One number may have several layouts, each of which is a constant of the program.
        let sets = self.sets.map(|layout| layout.map(std::ptr::from_ref));
        let push = self.push.as_ref().map(|push| (push.stages, push.bytes));
        (slots, sets, push)
    }

    fn create_layouts(&self, gpu: &Gpu, name: &str, handles: &mut PipelineHandles) -> Result<()> {
        let (used, most) = (self.slots.len(), gpu.most_resources());
        if used > most {
            return Err(GpuError::usage(name, format!("its {used} resources exceed the device limit of {most}")));
        }
        self.check_textures(gpu, name)?;
        let resources = self.slots.iter().map(|slot| (slot.kind, slot.stages));
        let flags = vk::DescriptorSetLayoutCreateFlags::PUSH_DESCRIPTOR_KHR;
        handles.set_layout = descriptor_layout(gpu, name, flags, resources)?;
        // Vulkan requires a layout for every set number up to the highest number in use.
        let last = self.sets.iter().rposition(Option::is_some).unwrap_or(0);
        let mut sets = vec![handles.set_layout];
        for layout in &self.sets[1..=last] {
            sets.push(gpu.set_layouts().raw(gpu, layout.unwrap_or(&EMPTY))?);
        }
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
        let mut ranges = Vec::new();
        if let Some(push) = self.push.as_ref().filter(|push| push.bytes > 0) {
            let (bytes, most) = (push.bytes as u32, gpu.limits().max_push_constants_size);
            if bytes > most {
                let fault = format!("{bytes} bytes of push constants exceed the device limit of {most}");
                return Err(GpuError::usage(name, fault));
            }
            ranges.push(vk::PushConstantRange::default().stage_flags(push.stages).size(bytes));
            info = info.push_constant_ranges(&ranges);
        }
        // SAFETY: the device and the set layouts are alive, and everything `info` points to outlives the call.
        handles.layout = unsafe { gpu.raw().create_pipeline_layout(&info, None) }
            .doing(format!("creating the pipeline layout of {name}"))?;
        gpu.name(handles.layout, name);
        Ok(())
    }

    /// Checks that all textures, including unused ones, are within the device's limit per stage.
    fn check_textures(&self, gpu: &Gpu, name: &str) -> Result<()> {
        let lasting = self.sets.iter().flatten().flat_map(|layout| layout.resources).map(|(_, kind)| *kind);
        let kinds = self.slots.iter().map(|slot| slot.kind).chain(lasting);
        let textures = kinds.filter(|kind| *kind == ResourceKind::Sampled).count();
        let limits = gpu.limits();
        let most = limits.max_per_stage_descriptor_sampled_images.min(limits.max_per_stage_descriptor_samplers);
        if textures > most as usize {
            return Err(GpuError::usage(name, format!("its {textures} textures exceed the device limit of {most}")));
        }
        Ok(())
    }

    /// Returns the binding number of a resource.
    fn binding(&self, set: u32, name: &str) -> Option<u32> {
        if let Some(layout) = self.sets[set as usize] {
            return layout.binding(name);
        }
        self.slots.iter().position(|slot| slot.name == name).map(|index| index as u32)
    }
}

pub(crate) struct SpecializedStage {
    shader: &'static Shader,
    words: Vec<u32>,
    /// The declarations that are left in the shader after specialisation.
    left: Interface,
}

impl SpecializedStage {
    /// Specialises a shader with these constants.
    ///
    /// # Errors
    /// Returns [`GpuError::Shader`] for unsupported SPIR-V.
    pub(crate) fn new(shader: &'static Shader, spec: Spec<'_>) -> Result<Self> {
        let words = specialized(&shader.words(), |id| {
            let constant = shader.interface().constants.iter().find(|constant| constant.id == id)?;
            spec.iter().find(|(name, _)| *name == constant.name).map(|(_, value)| value.bits())
        });
        let left = interface(&words).map_err(|fault| GpuError::Shader { name: shader.name.to_owned(), fault })?;
        Ok(Self { shader, words, left })
    }

    fn stage(&self) -> vk::ShaderStageFlags {
        stage_flags(self.shader.stage)
    }
}

/// A stage whose resources have the binding numbers of its pipeline.
struct NumberedStage {
    shader: &'static Shader,
    words: Vec<u32>,
}

impl NumberedStage {
    fn new(gpu: &Gpu, declared: &Declared, stage: SpecializedStage) -> Self {
        let SpecializedStage { shader, mut words, left } = stage;
        for resource in &left.resources {
            if let (Some(word), Some(number)) = (resource.binding_word, declared.binding(resource.set, &resource.name))
            {
                words[word] = number;
            }
        }
        if shader.stage == Stage::Fragment && !gpu.is_software() {
            // With unrolled loops, the shaders that filter and shade are so long that GPUs lose a fifth of a frame. Software
            // drivers keep loop variables in memory (docs/measurements/gpu.md, performance.md).
            leave_loops_to_driver(&mut words);
        }
        Self { shader, words }
    }
}

/// A stage of a pipeline while the pipeline is being created.
pub(crate) struct StageModule<'a> {
    gpu: &'a Gpu,
    module: vk::ShaderModule,
    stage: vk::ShaderStageFlags,
}

impl Drop for StageModule<'_> {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules after creation.
        unsafe { self.gpu.raw().destroy_shader_module(self.module, None) };
    }
}

impl<'a> StageModule<'a> {
    fn new(gpu: &'a Gpu, stage: &NumberedStage) -> Result<Self> {
        let NumberedStage { shader, words } = stage;
        let info = vk::ShaderModuleCreateInfo::default().code(words);
        // SAFETY: shaderc compiled the words for Vulkan 1.3. Only binding numbers and loop controls were changed, constants were
        // specialised, and unreachable blocks were removed. The validation layer checks the result in every test that creates a
        // pipeline.
        let module =
            unsafe { gpu.raw().create_shader_module(&info, None) }.doing(format!("creating shader {}", shader.name))?;
        gpu.name(module, shader.name);
        Ok(Self { gpu, module, stage: stage_flags(shader.stage) })
    }

    pub(crate) fn info(&self) -> vk::PipelineShaderStageCreateInfo<'_> {
        const MAIN: &CStr = c"main";
        vk::PipelineShaderStageCreateInfo::default().stage(self.stage).module(self.module).name(MAIN)
    }
}

/// Returns the shader of this stage with this name.
///
/// # Errors
/// Returns [`GpuError::NoShader`] for an unknown name, or [`GpuError::Shader`] if the shader belongs to another stage.
pub(crate) fn shader(gpu: &Gpu, name: &str, stage: Stage) -> Result<&'static Shader> {
    let shader = gpu.shaders().find(name)?;
    if shader.stage == stage {
        return Ok(shader);
    }
    let fault = format!("it is a {:?} shader, but a {stage:?} shader is needed", shader.stage);
    Err(GpuError::Shader { name: name.to_owned(), fault })
}

/// Checks that the shaders declare every given constant with the type of its value.
///
/// # Errors
/// Returns [`GpuError::Shader`], which names the pipeline and the constant.
pub(crate) fn check_constants(pipeline: &str, shaders: &[&Shader], spec: Spec<'_>) -> Result<()> {
    let fault = |fault: String| Err(GpuError::Shader { name: pipeline.to_owned(), fault });
    let all = || shaders.iter().flat_map(|shader| &shader.interface().constants);
    for (i, (name, value)) in spec.iter().enumerate() {
        if spec[..i].iter().any(|(earlier, _)| earlier == name) {
            return fault(format!("constant {name} is given twice"));
        }
        let mut declared = all().filter(|c| c.name == *name).peekable();
        if declared.peek().is_none() {
            let mut names: Vec<&str> = all().map(|c| c.name.as_str()).collect();
            names.sort_unstable();
            names.dedup();
            let names = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            return fault(format!("no constant {name} is declared by its shaders; they declare {names}"));
        }
        if let Some(other) = declared.find(|constant| constant.kind != value.kind()) {
            return fault(format!("constant {name} is {:?}, not {:?}", other.kind, value.kind()));
        }
    }
    Ok(())
}

/// Returns the resources that any stage uses, and the names of the unused resources.
fn resources(pipeline: &str, stages: &[SpecializedStage]) -> Result<(Vec<Slot>, Vec<&'static str>)> {
    let mut all: Vec<Slot> = Vec::new();
    for stage @ SpecializedStage { shader, left, .. } in stages {
        for resource in shader.interface().resources.iter().filter(|resource| resource.set == 0) {
            let is_used = left.resources.iter().any(|r| r.name == resource.name && r.binding_word.is_some());
            let used = if is_used { stage.stage() } else { vk::ShaderStageFlags::empty() };
            match all.iter_mut().find(|known| known.name == resource.name) {
                Some(known) if known.kind == resource.kind => known.stages |= used,
                Some(known) => {
                    let (name, one, other) = (&resource.name, known.kind.words(), resource.kind.words());
                    let fault = format!("{name} is {one} in one stage and {other} in {}", shader.name);
                    return Err(GpuError::Shader { name: pipeline.to_owned(), fault });
                }
                None => all.push(Slot { name: &resource.name, kind: resource.kind, stages: used }),
            }
        }
    }
    let (slots, unused): (Vec<Slot>, Vec<Slot>) = all.into_iter().partition(|slot| !slot.stages.is_empty());
    Ok((slots, unused.into_iter().map(|slot| slot.name).collect()))
}

/// Returns the device's layouts for the longer-lived sets that the stages use.
fn used_sets(gpu: &Gpu, pipeline: &str, stages: &[SpecializedStage]) -> Result<[Option<&'static SetLayout>; SETS]> {
    let mut used = [None; SETS];
    for SpecializedStage { shader, left, .. } in stages {
        for resource in left.resources.iter().filter(|resource| resource.set > 0 && resource.binding_word.is_some()) {
            let layout = gpu.set_layouts().numbered(resource.set);
            let known = layout.and_then(|layout| layout.resources.iter().find(|(name, _)| *name == resource.name));
            match (layout, known) {
                (Some(layout), Some((_, kind))) if *kind == resource.kind => used[resource.set as usize] = Some(layout),
                _ => {
                    let (name, kind, set) = (&resource.name, resource.kind.words(), resource.set);
                    let fault =
                        format!("{name} is {kind} of set {set} in {}, for which the device has no layout", shader.name);
                    return Err(GpuError::Shader { name: pipeline.to_owned(), fault });
                }
            }
        }
    }
    Ok(used)
}

/// Returns the push constants of all stages, which share one block.
fn push_constants(
    pipeline: &str,
    stages: &[SpecializedStage],
    structs: &[StructLayout],
) -> Result<Option<PushConstants>> {
    let mut found: Option<(&str, PushConstants)> = None;
    for stage @ SpecializedStage { shader, left, .. } in stages {
        let Some(push) = &shader.interface().push else { continue };
        let Some(twin) = structs.iter().find(|twin| twin.glsl == push.block) else { continue };
        let empty = PushConstants { rust: twin.rust, stages: vk::ShaderStageFlags::empty(), bytes: 0 };
        let (block, constants) = found.get_or_insert((&push.block, empty));
        if *block != push.block {
            let fault = format!("one stage has push constants {block}, {} has {}", shader.name, push.block);
            return Err(GpuError::Shader { name: pipeline.to_owned(), fault });
        }
        if left.push.as_ref().is_some_and(|push| push.used) {
            constants.stages |= stage.stage();
            constants.bytes = constants.bytes.max((push.bytes as usize).next_multiple_of(4));
        }
    }
    Ok(found.map(|(_, constants)| constants))
}
