//! The filter for the sea's pixels: writes the slope moments of the waves under each pixel into the G-buffer.

use std::sync::Arc;

use glam::Vec2;

use super::fields::{CascadeGpu, OceanFields};
use crate::gpu::{
    AddressMode, Buffer, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Result, Sampler,
    SharedStruct, SpecValue, Topology, shared_struct,
};
use crate::render::passes::targets::{GBuffer, VisibleSurface};
use crate::render::settings::Needs;
use crate::render::surfaces::ocean::Ocean;
use crate::render::surfaces::ocean::mesh::EARTH;
use crate::render::surfaces::ocean::shore::ShoreGpu;

/// Beckmann roughness of the water surface itself, without any waves.
const WATER_ROUGHNESS: f32 = 0.01;
/// Reflectance of water at normal incidence.
const WATER_F0: f32 = 0.02;

shared_struct! {
    /// The water as the shaders read it (`passes/ocean/water.glsl`).
    pub struct WaterGpu for "Water" {
        centre: [f32; 4],
        tail: [f32; 4],
        color: [f32; 4],
        foam: [f32; 4],
    }
}

impl WaterGpu {
    /// The water of a sea for a viewer above `centre`.
    pub fn new(ocean: &Ocean, centre: Vec2) -> Self {
        let threshold = if ocean.foam_threshold > 0.0 { ocean.foam_threshold } else { -1e9 };
        Self {
            centre: [centre.x, centre.y, 1.0 / EARTH, 0.0],
            tail: ocean.tail.extend(WATER_ROUGHNESS).to_array(),
            color: ocean.color.extend(WATER_F0).to_array(),
            foam: ocean.foam.extend(threshold).to_array(),
        }
    }
}

/// The filter's inputs from the sea. The last two are the blocks of [`WaterGpu`] and
/// [`ShoreGpu`](crate::render::surfaces::ocean::shore::ShoreGpu).
#[derive(Clone, Copy)]
pub struct SeaInputs<'a> {
    /// The waves.
    pub fields: &'a OceanFields,
    /// The water.
    pub water: &'a Buffer,
    /// The shore.
    pub shore: &'a Buffer,
}

/// The pipeline of the filter for the inputs that a technique needs.
#[derive(Clone)]
pub struct OceanFilterPass {
    pipeline: GraphicsPipeline,
    trilinear: Sampler,
    nearest: Sampler,
}

impl OceanFilterPass {
    /// The pass, with or without a shore.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>, needs: Needs, shore: bool) -> Result<Self> {
        let own = vec![("HAS_BEACH", SpecValue::Bool(shore))];
        Ok(Self {
            pipeline: GraphicsPipeline::new(
                gpu,
                "ocean filter",
                &GraphicsDesc {
                    vertex: "passes/ocean/filter.vert",
                    topology: Topology::Points,
                    fragment: Some("passes/ocean/filter.frag"),
                    colors: &GBuffer::FORMATS,
                    spec: &[needs.spec(), own].concat(),
                    structs: &[WaterGpu::LAYOUT, ShoreGpu::LAYOUT, CascadeGpu::LAYOUT],
                    ..Default::default()
                },
            )?,
            trilinear: Sampler::new(gpu, "ocean moments", Filter::Trilinear, AddressMode::Repeat)?,
            nearest: Sampler::new(gpu, "ocean pixels", Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Filters the waves under the sea's pixels into the begun G-buffer.
    pub fn draw(&self, cmd: &mut Commands, visible: &VisibleSurface, sea: SeaInputs<'_>) {
        let SeaInputs { fields, water, shore } = sea;
        cmd.bind(
            &self.pipeline,
            &[
                ("visible_footprint", Descriptor::Sampled(visible.footprint.whole(), &self.nearest)),
                ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                ("slopes", Descriptor::Sampled(fields.slopes.whole(), &self.trilinear)),
                ("joint", Descriptor::Sampled(fields.joint.whole(), &self.trilinear)),
                ("Cascades", Descriptor::Storage(&fields.cascades)),
                ("water", Descriptor::Uniform(water)),
                ("Beach", Descriptor::Uniform(shore)),
                ("TileRecords", Descriptor::Storage(&visible.tiles.records)),
            ],
        );
        visible.tiles.draw(cmd);
    }
}
