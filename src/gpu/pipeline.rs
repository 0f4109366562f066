//! Compute and graphics pipelines.

use std::sync::Arc;

use ash::vk;

use super::error::Doing;
use super::pipeline_layout::{Constants, PipelineCore, Spec, Stage, layout};
use super::reflect::Interface;
use super::{Gpu, GpuError, Result};

/// What can be bound: a compute or a graphics pipeline.
pub trait Pipeline {
    /// The common part.
    #[doc(hidden)]
    fn core(&self) -> &Arc<PipelineCore>;
}

/// A compute pipeline. Clones share the one pipeline.
#[derive(Clone)]
pub struct ComputePipeline {
    core: Arc<PipelineCore>,
    local_size: [u32; 3],
}

impl Pipeline for ComputePipeline {
    fn core(&self) -> &Arc<PipelineCore> {
        &self.core
    }
}

impl ComputePipeline {
    /// A pipeline of the compute entry point `shader`, such as `"passes/prefilter.comp"`.
    ///
    /// # Errors
    /// [`GpuError::NoShader`], [`GpuError::Shader`], or a failed Vulkan call.
    pub fn new(gpu: &Arc<Gpu>, shader: &str, spec: Spec<'_>) -> Result<Self> {
        let stage = Stage::load(gpu, shader, vk::ShaderStageFlags::COMPUTE)?;
        let mut core = layout(gpu, shader, vk::PipelineBindPoint::COMPUTE, &[&stage.interface])?;
        let constants = Constants::new(spec);
        let special = constants.info();
        let info = vk::ComputePipelineCreateInfo::default().stage(stage.info(&special)).layout(core.layout);
        // SAFETY: everything the description points to outlives the call.
        let made = unsafe { gpu.raw().create_compute_pipelines(gpu.pipeline_cache(), &[info], None) };
        core.raw = made.map_err(|(_, result)| result).doing(format!("creating pipeline {shader}"))?[0];
        gpu.name(core.raw, shader);
        Ok(Self { core: Arc::new(core), local_size: stage.interface.local_size })
    }

    /// The work group size in the shader (specialization constants at their defaults).
    pub fn local_size(&self) -> [u32; 3] {
        self.local_size
    }
}

/// Which sides of triangles are thrown away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cull {
    /// None.
    None,
    /// Those that face away: clockwise on the screen (y down) unless [`GraphicsDesc::clockwise_front`].
    Back,
    /// Those that face the viewer.
    Front,
}

/// How polygons are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PolygonMode {
    /// Filled.
    Fill,
    /// Their edges only; needs [`Gpu::can_draw_lines`].
    Line,
}

/// What vertices form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topology {
    /// Every three a triangle.
    Triangles,
    /// Every one a triangle with the two before.
    TriangleStrip,
    /// Every two a line.
    Lines,
    /// Every one a point.
    Points,
    /// Every this many a patch for the tessellation stages.
    Patches(u32),
}

/// What happens to the colour that is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// It is replaced.
    Replace,
    /// `source.rgb * source.a + there * (1 - source.a)`.
    Alpha,
    /// `source.rgb + there * (1 - source.a)`.
    PremultipliedAlpha,
    /// `source + there`.
    Add,
}

/// The depth attachment's part in a pipeline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Depth {
    /// Format of the attachment, normally `D32_SFLOAT`.
    pub format: vk::Format,
    /// Which fragments pass: `GREATER_OR_EQUAL` for reversed depth; `ALWAYS` switches the test off.
    pub compare: vk::CompareOp,
    /// Whether passing fragments write their depth.
    pub write: bool,
    /// Constant and slope factor of the depth bias.
    pub bias: Option<[f32; 2]>,
}

impl Default for Depth {
    /// Reversed depth in `D32_SFLOAT` (clear to 0), tested and written.
    fn default() -> Self {
        Self { format: vk::Format::D32_SFLOAT, compare: vk::CompareOp::GREATER_OR_EQUAL, write: true, bias: None }
    }
}

/// What a graphics pipeline is made of. There are no vertex attributes: vertex shaders pull from storage buffers.
#[derive(Clone, Copy, Debug)]
pub struct GraphicsDesc<'a> {
    /// Vertex entry point, such as `"passes/gbuffer.vert"`.
    pub vertex: &'a str,
    /// Tessellation control and evaluation entry points.
    pub tessellation: Option<[&'a str; 2]>,
    /// Fragment entry point; `None` writes depth only.
    pub fragment: Option<&'a str>,
    /// Formats of the colour attachments in order.
    pub colors: &'a [vk::Format],
    /// Blending of all colour attachments.
    pub blend: Blend,
    /// Depth attachment, if any.
    pub depth: Option<Depth>,
    /// Triangles thrown away.
    pub cull: Cull,
    /// Whether triangles that run clockwise on the screen (y down) face the viewer.
    pub clockwise_front: bool,
    /// Filled or lines.
    pub polygon: PolygonMode,
    /// What vertices form.
    pub topology: Topology,
    /// Specialization constants of all stages.
    pub spec: Spec<'a>,
}

impl Default for GraphicsDesc<'_> {
    /// Filled triangles, no attachments, no culling, counter-clockwise front.
    fn default() -> Self {
        Self {
            vertex: "",
            tessellation: None,
            fragment: None,
            colors: &[],
            blend: Blend::Replace,
            depth: None,
            cull: Cull::None,
            clockwise_front: false,
            polygon: PolygonMode::Fill,
            topology: Topology::Triangles,
            spec: &[],
        }
    }
}

/// A graphics pipeline for dynamic rendering; viewport and scissor are set while recording. Clones share the one pipeline.
#[derive(Clone)]
pub struct GraphicsPipeline {
    core: Arc<PipelineCore>,
}

impl Pipeline for GraphicsPipeline {
    fn core(&self) -> &Arc<PipelineCore> {
        &self.core
    }
}

impl GraphicsPipeline {
    /// A pipeline named `name` in captures and messages.
    ///
    /// # Errors
    /// [`GpuError::NoShader`], [`GpuError::Shader`], [`GpuError::Usage`] when the description contradicts itself or the
    /// device cannot do it, or a failed Vulkan call.
    pub fn new(gpu: &Arc<Gpu>, name: &str, desc: &GraphicsDesc<'_>) -> Result<Self> {
        if desc.polygon == PolygonMode::Line && !gpu.can_draw_lines() {
            return Err(GpuError::usage(name, format!("{} cannot draw polygons as lines", gpu.device_name())));
        }
        if desc.tessellation.is_some() != matches!(desc.topology, Topology::Patches(_)) {
            return Err(GpuError::usage(name, "tessellation stages and patches must come together"));
        }
        let mut stages = vec![Stage::load(gpu, desc.vertex, vk::ShaderStageFlags::VERTEX)?];
        if let Some([control, evaluation]) = desc.tessellation {
            stages.push(Stage::load(gpu, control, vk::ShaderStageFlags::TESSELLATION_CONTROL)?);
            stages.push(Stage::load(gpu, evaluation, vk::ShaderStageFlags::TESSELLATION_EVALUATION)?);
        }
        if let Some(fragment) = desc.fragment {
            stages.push(Stage::load(gpu, fragment, vk::ShaderStageFlags::FRAGMENT)?);
        }
        let interfaces: Vec<&Interface> = stages.iter().map(|stage| &stage.interface).collect();
        let mut core = layout(gpu, name, vk::PipelineBindPoint::GRAPHICS, &interfaces)?;
        core.raw = create_graphics(gpu, name, desc, &stages, core.layout)?;
        gpu.name(core.raw, name);
        Ok(Self { core: Arc::new(core) })
    }
}

fn create_graphics(
    gpu: &Gpu,
    name: &str,
    desc: &GraphicsDesc<'_>,
    stages: &[Stage],
    layout: vk::PipelineLayout,
) -> Result<vk::Pipeline> {
    let constants = Constants::new(desc.spec);
    let special = constants.info();
    let stages: Vec<_> = stages.iter().map(|stage| stage.info(&special)).collect();
    let vertex_input = vk::PipelineVertexInputStateCreateInfo::default();
    let (topology, patch_points) = match desc.topology {
        Topology::Triangles => (vk::PrimitiveTopology::TRIANGLE_LIST, 0),
        Topology::TriangleStrip => (vk::PrimitiveTopology::TRIANGLE_STRIP, 0),
        Topology::Lines => (vk::PrimitiveTopology::LINE_LIST, 0),
        Topology::Points => (vk::PrimitiveTopology::POINT_LIST, 0),
        Topology::Patches(points) => (vk::PrimitiveTopology::PATCH_LIST, points),
    };
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(topology);
    let tessellation = vk::PipelineTessellationStateCreateInfo::default().patch_control_points(patch_points);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let bias = desc.depth.and_then(|depth| depth.bias);
    let rasterization = vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(match desc.polygon {
            PolygonMode::Fill => vk::PolygonMode::FILL,
            PolygonMode::Line => vk::PolygonMode::LINE,
        })
        .cull_mode(match desc.cull {
            Cull::None => vk::CullModeFlags::NONE,
            Cull::Back => vk::CullModeFlags::BACK,
            Cull::Front => vk::CullModeFlags::FRONT,
        })
        .front_face(match desc.clockwise_front {
            true => vk::FrontFace::CLOCKWISE,
            false => vk::FrontFace::COUNTER_CLOCKWISE,
        })
        .depth_bias_enable(bias.is_some())
        .depth_bias_constant_factor(bias.map_or(0.0, |[constant, _]| constant))
        .depth_bias_slope_factor(bias.map_or(0.0, |[_, slope]| slope))
        .line_width(1.0);
    let multisample =
        vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let mut depth = vk::PipelineDepthStencilStateCreateInfo::default();
    if let Some(wanted) = desc.depth {
        depth = depth.depth_test_enable(true).depth_compare_op(wanted.compare).depth_write_enable(wanted.write);
    }
    let blends = vec![blend(desc.blend); desc.colors.len()];
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
    let made = unsafe { gpu.raw().create_graphics_pipelines(gpu.pipeline_cache(), &[info], None) };
    Ok(made.map_err(|(_, result)| result).doing(format!("creating pipeline {name}"))?[0])
}

fn blend(kind: Blend) -> vk::PipelineColorBlendAttachmentState {
    use vk::BlendFactor as F;
    let (source, there) = match kind {
        Blend::Replace => (F::ONE, F::ZERO),
        Blend::Alpha => (F::SRC_ALPHA, F::ONE_MINUS_SRC_ALPHA),
        Blend::PremultipliedAlpha => (F::ONE, F::ONE_MINUS_SRC_ALPHA),
        Blend::Add => (F::ONE, F::ONE),
    };
    let source_alpha = if kind == Blend::Alpha { F::ONE } else { source };
    vk::PipelineColorBlendAttachmentState::default()
        .blend_enable(kind != Blend::Replace)
        .src_color_blend_factor(source)
        .dst_color_blend_factor(there)
        .src_alpha_blend_factor(source_alpha)
        .dst_alpha_blend_factor(there)
        .color_write_mask(vk::ColorComponentFlags::RGBA)
}
