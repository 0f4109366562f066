//! Compute and graphics pipelines.

use std::hash::Hash;
use std::sync::{Arc, PoisonError, RwLock};

use ash::vk;

use super::error::Doing;
use super::pipeline_layout::{PipelineCore, Spec, SpecValue, SpecializedStage, StageModule, check_constants, shader};
use super::reload::{Put, Remake};
use super::shaders::{Shader, Stage};
use super::{Gpu, GpuError, Result, StructLayout};

/// A compute or graphics pipeline.
pub trait Pipeline {
    /// Returns the current state that compute and graphics pipelines share.
    #[doc(hidden)]
    fn core(&self) -> Arc<PipelineCore>;
}

/// A function that creates a pipeline from the current shaders.
type Make = dyn Fn(&Arc<Gpu>) -> Result<PipelineCore> + Send + Sync;

/// The inputs of a pipeline, from which it can be re-created with other shaders.
struct Recipe {
    shaders: Vec<String>,
    make: Box<Make>,
    made: RwLock<Arc<PipelineCore>>,
}

impl Recipe {
    /// Creates a pipeline and its recipe. The device can re-create the pipeline as long as the recipe exists.
    fn new(
        gpu: &Arc<Gpu>,
        shaders: Vec<String>,
        make: impl Fn(&Arc<Gpu>) -> Result<PipelineCore> + Send + Sync + 'static,
    ) -> Result<Arc<Self>> {
        let made = RwLock::new(Arc::new(make(gpu)?));
        let recipe = Arc::new(Self { shaders, make: Box::new(make), made });
        let known: Arc<dyn Remake> = recipe.clone();
        gpu.register(Arc::downgrade(&known));
        Ok(recipe)
    }

    fn core(&self) -> Arc<PipelineCore> {
        self.made.read().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Remake for Recipe {
    fn uses(&self, names: &[&str]) -> bool {
        self.shaders.iter().any(|shader| names.contains(&shader.as_str()))
    }

    fn make_again(self: Arc<Self>) -> Result<Put> {
        let gpu = self.core().gpu().clone();
        let core = Arc::new((self.make)(&gpu)?);
        Ok(Box::new(move || *self.made.write().unwrap_or_else(PoisonError::into_inner) = core))
    }
}

/// Copies specialization constants, so that they outlive the call.
fn owned(spec: Spec<'_>) -> Vec<(String, SpecValue)> {
    spec.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
}

fn borrowed(spec: &[(String, SpecValue)]) -> Vec<(&str, SpecValue)> {
    spec.iter().map(|(name, value)| (name.as_str(), *value)).collect()
}

/// A compute pipeline. Clones share the same pipeline.
#[derive(Clone)]
pub struct ComputePipeline {
    recipe: Arc<Recipe>,
}

impl Pipeline for ComputePipeline {
    fn core(&self) -> Arc<PipelineCore> {
        self.recipe.core()
    }
}

impl ComputePipeline {
    /// Creates a pipeline for the compute entry point `name`, such as `"passes/sky.comp"`. `structs` holds the layouts of all
    /// structs in the shader's buffers and push constants.
    ///
    /// # Errors
    /// Returns [`GpuError::NoShader`] for an unknown entry point. Returns [`GpuError::Shader`] if the shader does not declare a
    /// given constant or struct or declares it differently, or if a struct of the shader is missing from `structs`.
    pub fn new(gpu: &Arc<Gpu>, name: &str, spec: Spec<'_>, structs: &[StructLayout]) -> Result<Self> {
        let (entry, spec, structs) = (name.to_owned(), owned(spec), structs.to_vec());
        let make = move |gpu: &Arc<Gpu>| Self::make(gpu, &entry, &borrowed(&spec), &structs);
        Ok(Self { recipe: Recipe::new(gpu, vec![name.to_owned()], make)? })
    }

    fn make(gpu: &Arc<Gpu>, name: &str, spec: Spec<'_>, structs: &[StructLayout]) -> Result<PipelineCore> {
        let shader = shader(gpu, name, Stage::Compute)?;
        check_constants(name, &[shader], spec)?;
        let stages = vec![SpecializedStage::new(shader, spec)?];
        let mut core =
            PipelineCore::new(gpu, name, vk::PipelineBindPoint::COMPUTE, stages, structs, (), |stages, layout| {
                let info = vk::ComputePipelineCreateInfo::default().stage(stages[0].info()).layout(layout);
                // SAFETY: everything the description points to outlives the call.
                let made = unsafe { gpu.raw().create_compute_pipelines(gpu.pipeline_cache(), &[info], None) };
                first(name, made)
            })?;
        core.local_size = shader.interface().local_size;
        Ok(core)
    }

    /// Returns the work group size that the shader declares, with specialization constants at their defaults.
    pub fn local_size(&self) -> [u32; 3] {
        self.core().local_size
    }
}

/// How vertices are assembled into primitives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Topology {
    /// Every three vertices form a triangle.
    Triangles,
    /// Every vertex is a point.
    Points,
    /// Every group of this many vertices is a patch for the tessellation stages.
    Patches(u32),
}

/// How a pipeline uses the depth attachment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth {
    /// The format of the attachment, normally `D32_SFLOAT`.
    pub format: vk::Format,
    /// The comparison that passing fragments satisfy, which is `GREATER_OR_EQUAL` for reversed depth. `ALWAYS` disables the test.
    pub compare: vk::CompareOp,
    /// Whether passing fragments write their depth.
    pub write: bool,
    /// The constant and the slope factor of the depth bias, if any.
    pub bias: Option<[f32; 2]>,
}

impl Default for Depth {
    /// Describes reversed depth in `D32_SFLOAT`, tested and written. Clear it to 0.
    fn default() -> Self {
        Self { format: vk::Format::D32_SFLOAT, compare: vk::CompareOp::GREATER_OR_EQUAL, write: true, bias: None }
    }
}

/// The description of a graphics pipeline. Vertex shaders read vertices from storage buffers. Triangles are drawn without blending,
/// and both of their sides are visible by default.
#[derive(Clone, Copy, Debug)]
pub struct GraphicsDesc<'a> {
    /// The vertex entry point, such as `"passes/gbuffer.vert"`.
    pub vertex: &'a str,
    /// The tessellation control and evaluation entry points, if any.
    pub tessellation: Option<[&'a str; 2]>,
    /// The fragment entry point. With `None`, the pipeline writes only depth.
    pub fragment: Option<&'a str>,
    /// The formats of the colour attachments in order.
    pub colors: &'a [vk::Format],
    /// The number of attachments at the end of `colors` that the fragment stage does not write.
    pub kept_colors: usize,
    /// The depth attachment, if any.
    pub depth: Option<Depth>,
    /// The number of samples per texel of the attachments.
    pub samples: u32,
    /// Whether front faces (`gl_FrontFacing`) are the triangles that run clockwise on the screen, where y points down. By default,
    /// front faces run counter-clockwise.
    pub clockwise_front: bool,
    /// Whether back faces are culled.
    pub front_only: bool,
    /// Whether triangles are drawn as wireframes with lines of one pixel. Some devices do not support wireframes.
    pub wires: bool,
    /// How vertices are assembled into primitives.
    pub topology: Topology,
    /// The specialization constants of all stages.
    pub spec: Spec<'a>,
    /// The layouts of all structs in the stages' buffers and push constants.
    pub structs: &'a [StructLayout],
}

impl GraphicsDesc<'_> {
    /// Returns all that the pipeline depends on besides its shaders and their resources.
    fn state(&self) -> impl Hash {
        let Self { colors, kept_colors, samples, clockwise_front, front_only, wires, topology, .. } = *self;
        let bits = |bias: [f32; 2]| bias.map(f32::to_bits);
        let depth = self.depth.map(|depth| (depth.format, depth.compare, depth.write, depth.bias.map(bits)));
        (colors.to_vec(), kept_colors, depth, samples, clockwise_front, front_only, wires, topology)
    }
}

impl Default for GraphicsDesc<'_> {
    /// Describes a pipeline for triangles with counter-clockwise front faces, without attachments.
    fn default() -> Self {
        Self {
            vertex: "",
            tessellation: None,
            fragment: None,
            colors: &[],
            kept_colors: 0,
            depth: None,
            samples: 1,
            clockwise_front: false,
            front_only: false,
            wires: false,
            topology: Topology::Triangles,
            spec: &[],
            structs: &[],
        }
    }
}

/// A graphics pipeline for dynamic rendering. The viewport and the scissor are set while recording. Clones share the same pipeline.
#[derive(Clone)]
pub struct GraphicsPipeline {
    recipe: Arc<Recipe>,
}

impl Pipeline for GraphicsPipeline {
    fn core(&self) -> Arc<PipelineCore> {
        self.recipe.core()
    }
}

/// A copy of a [`GraphicsDesc`] that outlives the call.
struct OwnedDesc {
    vertex: String,
    tessellation: Option<[String; 2]>,
    fragment: Option<String>,
    colors: Vec<vk::Format>,
    spec: Vec<(String, SpecValue)>,
    structs: Vec<StructLayout>,
    /// The fields of the description that borrow nothing.
    rest: GraphicsDesc<'static>,
}

impl OwnedDesc {
    fn of(desc: &GraphicsDesc<'_>) -> Self {
        let GraphicsDesc { kept_colors, depth, samples, clockwise_front, front_only, wires, topology, .. } = *desc;
        Self {
            vertex: desc.vertex.to_owned(),
            tessellation: desc.tessellation.map(|names| names.map(str::to_owned)),
            fragment: desc.fragment.map(str::to_owned),
            colors: desc.colors.to_vec(),
            spec: owned(desc.spec),
            structs: desc.structs.to_vec(),
            rest: GraphicsDesc {
                kept_colors,
                depth,
                samples,
                clockwise_front,
                front_only,
                wires,
                topology,
                ..GraphicsDesc::default()
            },
        }
    }

    fn shaders(&self) -> Vec<String> {
        let tessellation = self.tessellation.iter().flatten();
        std::iter::once(&self.vertex).chain(tessellation).chain(&self.fragment).cloned().collect()
    }

    fn with<R>(&self, make: impl FnOnce(&GraphicsDesc<'_>) -> R) -> R {
        let spec = borrowed(&self.spec);
        make(&GraphicsDesc {
            vertex: &self.vertex,
            tessellation: self.tessellation.as_ref().map(|names| names.each_ref().map(String::as_str)),
            fragment: self.fragment.as_deref(),
            colors: &self.colors,
            spec: &spec,
            structs: &self.structs,
            ..self.rest
        })
    }
}

impl GraphicsPipeline {
    /// Creates a pipeline. Captures and messages show it under the name `name`.
    ///
    /// # Errors
    /// Returns [`GpuError::NoShader`] for an unknown entry point. Returns [`GpuError::Shader`] if no stage declares a given
    /// constant or struct, if a stage declares it differently, if a struct has no description, or if the stages are inconsistent.
    /// Returns [`GpuError::Usage`] for patches without tessellation stages, or for wireframes on a device that does not support
    /// them.
    pub fn new(gpu: &Arc<Gpu>, name: &str, desc: &GraphicsDesc<'_>) -> Result<Self> {
        let (desc, named) = (OwnedDesc::of(desc), name.to_owned());
        let shaders = desc.shaders();
        let make = move |gpu: &Arc<Gpu>| desc.with(|desc| Self::make(gpu, &named, desc));
        Ok(Self { recipe: Recipe::new(gpu, shaders, make)? })
    }

    fn make(gpu: &Arc<Gpu>, name: &str, desc: &GraphicsDesc<'_>) -> Result<PipelineCore> {
        if desc.tessellation.is_some() != matches!(desc.topology, Topology::Patches(_)) {
            return Err(GpuError::usage(name, "tessellation stages and patches must come together"));
        }
        if desc.wires && !gpu.draws_wires() {
            return Err(GpuError::usage(name, "this device cannot draw wireframes (fillModeNonSolid)"));
        }
        let mut shaders: Vec<&'static Shader> = vec![shader(gpu, desc.vertex, Stage::Vertex)?];
        if let Some([control, evaluation]) = desc.tessellation {
            shaders.push(shader(gpu, control, Stage::TessellationControl)?);
            shaders.push(shader(gpu, evaluation, Stage::TessellationEvaluation)?);
        }
        if let Some(fragment) = desc.fragment {
            shaders.push(shader(gpu, fragment, Stage::Fragment)?);
        }
        check_constants(name, &shaders, desc.spec)?;
        let specialized = |shader: &&'static Shader| SpecializedStage::new(shader, desc.spec);
        let stages = shaders.iter().map(specialized).collect::<Result<Vec<_>>>()?;
        let point = vk::PipelineBindPoint::GRAPHICS;
        PipelineCore::new(gpu, name, point, stages, desc.structs, desc.state(), |stages, layout| {
            create_graphics(gpu, name, desc, stages, layout)
        })
    }
}

fn create_graphics(
    gpu: &Gpu,
    name: &str,
    desc: &GraphicsDesc<'_>,
    stages: &[StageModule<'_>],
    layout: vk::PipelineLayout,
) -> Result<vk::Pipeline> {
    let stages: Vec<_> = stages.iter().map(StageModule::info).collect();
    let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
    let (topology, patch_points) = match desc.topology {
        Topology::Triangles => (vk::PrimitiveTopology::TRIANGLE_LIST, 0),
        Topology::Points => (vk::PrimitiveTopology::POINT_LIST, 0),
        Topology::Patches(points) => (vk::PrimitiveTopology::PATCH_LIST, points),
    };
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(topology);
    let tessellation = vk::PipelineTessellationStateCreateInfo::default().patch_control_points(patch_points);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let bias = desc.depth.and_then(|depth| depth.bias);
    let rasterization = vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(if desc.wires { vk::PolygonMode::LINE } else { vk::PolygonMode::FILL })
        .cull_mode(if desc.front_only { vk::CullModeFlags::BACK } else { vk::CullModeFlags::NONE })
        .front_face(if desc.clockwise_front { vk::FrontFace::CLOCKWISE } else { vk::FrontFace::COUNTER_CLOCKWISE })
        .depth_bias_enable(bias.is_some())
        .depth_bias_constant_factor(bias.map_or(0.0, |[constant, _]| constant))
        .depth_bias_slope_factor(bias.map_or(0.0, |[_, slope]| slope))
        .line_width(1.0);
    let multisample = vk::PipelineMultisampleStateCreateInfo::default()
        .rasterization_samples(vk::SampleCountFlags::from_raw(desc.samples));
    let mut depth = vk::PipelineDepthStencilStateCreateInfo::default();
    if let Some(wanted) = desc.depth {
        depth = depth.depth_test_enable(true).depth_compare_op(wanted.compare).depth_write_enable(wanted.write);
    }
    let replace = vk::PipelineColorBlendAttachmentState::default().color_write_mask(vk::ColorComponentFlags::RGBA);
    let keep = vk::PipelineColorBlendAttachmentState::default();
    let written = desc.colors.len().saturating_sub(desc.kept_colors);
    let blends: Vec<_> = (0..desc.colors.len()).map(|i| if i < written { replace } else { keep }).collect();
    let color = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
    let dynamic = vk::PipelineDynamicStateCreateInfo::default()
        .dynamic_states(&[vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR]);
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(desc.colors)
        .depth_attachment_format(desc.depth.map_or(vk::Format::UNDEFINED, |depth| depth.format));
    let mut info = vk::GraphicsPipelineCreateInfo::default()
        .stages(&stages)
        .vertex_input_state(&vertex_input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&rasterization)
        .multisample_state(&multisample)
        .depth_stencil_state(&depth)
        .color_blend_state(&color)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut rendering);
    if patch_points > 0 {
        info = info.tessellation_state(&tessellation);
    }
    // SAFETY: everything the description points to outlives the call.
    first(name, unsafe { gpu.raw().create_graphics_pipelines(gpu.pipeline_cache(), &[info], None) })
}

/// Returns the new pipeline.
fn first(
    name: &str,
    made: std::result::Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>,
) -> Result<vk::Pipeline> {
    Ok(made.map_err(|(_, result)| result).doing(format!("creating pipeline {name}"))?[0])
}
