//! Geometry pass: tessellates, displaces and rasterises into the G-buffer.

use std::sync::Arc;

use ash::vk;

use super::object::{GpuObject, ViewBuffers};
use super::settings::Technique;
use crate::gpu::{
    ColorTarget, Commands, Cull, Depth, DepthTarget, Descriptor, Gpu, GraphicsDesc, GraphicsPipeline, Image, ImageDesc,
    Load, Result, SpecValue, Topology, Use,
};

/// The G-buffer: everything a pixel needs to be shaded, 48 bytes.
pub struct GBuffer {
    /// Octahedral displacement direction (xy), mean slope in its frame (zw); RGBA32F.
    pub frame: Image,
    /// Slope covariance `sxx, syy, sxy` and LOD; RGBA32F.
    pub covariance: Image,
    /// Linear albedo and Beckmann roughness; RGBA16F.
    pub material: Image,
    /// Specular f0, accessibility, inside marker; RGBA8.
    pub surface: Image,
    /// Reversed depth, 0 where nothing is; D32F.
    pub depth: Image,
}

const FORMATS: [vk::Format; 4] = [
    vk::Format::R32G32B32A32_SFLOAT,
    vk::Format::R32G32B32A32_SFLOAT,
    vk::Format::R16G16B16A16_SFLOAT,
    vk::Format::R8G8B8A8_UNORM,
];

impl GBuffer {
    /// A G-buffer of `size` pixels.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let color = |name: &str, format| Image::new(gpu, name, ImageDesc::new(format, size.0, size.1).color_target());
        Ok(Self {
            frame: color("g-buffer frame", FORMATS[0])?,
            covariance: color("g-buffer covariance", FORMATS[1])?,
            material: color("g-buffer material", FORMATS[2])?,
            surface: color("g-buffer surface", FORMATS[3])?,
            depth: Image::new(
                gpu,
                "g-buffer depth",
                ImageDesc::new(vk::Format::D32_SFLOAT, size.0, size.1).depth_target(),
            )?,
        })
    }

    fn colors(&self) -> [&Image; 4] {
        [&self.frame, &self.covariance, &self.material, &self.surface]
    }

    /// Makes all of it readable by the shading pass.
    pub fn make_readable(&self, cmd: &mut Commands) {
        for image in self.colors() {
            cmd.transition(image, Use::Sampled);
        }
        cmd.transition(&self.depth, Use::Sampled);
    }
}

/// Pipelines of the geometry pass.
pub struct GeometryPass {
    pipeline: GraphicsPipeline,
}

impl GeometryPass {
    /// The pass for one technique. Nothing is culled by facing: a closed surface hides its own inside.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>, technique: Technique) -> Result<Self> {
        let pipeline = GraphicsPipeline::new(
            gpu,
            "geometry",
            &GraphicsDesc {
                vertex: "passes/geometry/geometry.vert",
                tessellation: Some(["passes/geometry/geometry.tesc", "passes/geometry/geometry.tese"]),
                fragment: Some("passes/geometry/geometry.frag"),
                colors: &FORMATS,
                depth: Some(Depth::default()),
                cull: Cull::None,
                clockwise_front: true,
                topology: Topology::Patches(4),
                spec: &[(0, SpecValue::I32(technique.geometry_code()))],
                ..Default::default()
            },
        )?;
        Ok(Self { pipeline })
    }

    /// Clears the G-buffer and draws the objects.
    pub fn record(
        &self,
        cmd: &mut Commands,
        target: &GBuffer,
        objects: &[(&GpuObject, &ViewBuffers)],
        height_scale: f32,
        mark_inside: bool,
    ) {
        for image in target.colors() {
            cmd.image_barrier(image, Use::Undefined, Use::ColorTarget);
        }
        cmd.image_barrier(&target.depth, Use::Undefined, Use::DepthTarget);
        let colors = target.colors().map(|image| ColorTarget { view: image.whole(), load: Load::Clear([0.0; 4]) });
        cmd.begin_rendering(&colors, Some(DepthTarget { view: target.depth.whole(), clear: Some(0.0) }));
        for (object, view) in objects {
            draw_object(cmd, &self.pipeline, object, view, height_scale, mark_inside);
        }
        cmd.end_rendering();
    }
}

/// Binds and draws one object; shared with the shadow pass.
pub(super) fn draw_object(
    cmd: &mut Commands,
    pipeline: &GraphicsPipeline,
    object: &GpuObject,
    view: &ViewBuffers,
    height_scale: f32,
    mark_inside: bool,
) {
    if view.draws.is_empty() {
        return;
    }
    cmd.bind(
        pipeline,
        &[
            (0, Descriptor::Uniform(&view.view)),
            (1, Descriptor::Storage(&view.vertices)),
            (2, Descriptor::Storage(&object.patches)),
            (3, Descriptor::Storage(&view.edge_factors)),
            (4, Descriptor::Storage(&object.edge_heights)),
            (5, Descriptor::Storage(&object.vertex_heights)),
            (6, Descriptor::Storage(&view.visible)),
            (7, Descriptor::Sampled(object.maps.slopes().whole(), &object.sampler)),
            (8, Descriptor::Sampled(object.maps.joint().whole(), &object.sampler)),
            (9, Descriptor::Sampled(object.color.whole(), &object.sampler)),
        ],
    );
    cmd.push_constants(&object.constants(height_scale, mark_inside));
    for &(first, count) in &view.draws {
        cmd.draw(first * 4..(first + count) * 4, 0..1);
    }
}
