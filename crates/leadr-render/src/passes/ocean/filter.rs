//! The filter pass of the sea, which computes the slope moments of the waves under each pixel.

use std::sync::Arc;

use glam::Vec2;

use super::fields::{CascadeGpu, OceanFields};
use crate::passes::filter::FilterInto;
use crate::passes::targets::VisibleSurface;
use crate::settings::Needs;
use crate::surfaces::material::Bases;
use crate::surfaces::numbering::Numbering;
use crate::surfaces::ocean::Ocean;
use crate::surfaces::ocean::mesh::EARTH;
use crate::surfaces::ocean::shore::ShoreGpu;
use leadr_gpu::{
    AddressMode, Buffer, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, ResourceSet, Result,
    Sampler, SharedStruct, SpecValue, shared_struct,
};

/// The Beckmann roughness of the water surface without any waves.
const WATER_ROUGHNESS: f32 = 0.01;
/// The reflectance of water at normal incidence.
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
    /// Returns the water of a sea. `centre` is the point below the viewer.
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

/// The inputs of the filter pass. `water` and `shore` are the blocks of [`WaterGpu`] and [`ShoreGpu`].
#[derive(Clone, Copy)]
pub struct SeaInputs<'a> {
    /// The maps of the waves.
    pub fields: &'a OceanFields,
    /// The [`WaterGpu`] block.
    pub water: &'a Buffer,
    /// The [`ShoreGpu`] block.
    pub shore: &'a Buffer,
}

/// The pipeline that filters the sea for the inputs of a technique.
#[derive(Clone)]
pub struct OceanFilterPass {
    pipeline: GraphicsPipeline,
    trilinear: Sampler,
    nearest: Sampler,
}

impl OceanFilterPass {
    /// Creates the pass, with or without a shore.
    pub fn new(gpu: &Arc<Gpu>, needs: Needs, into: FilterInto, shore: bool, numbering: Numbering) -> Result<Self> {
        let own = vec![("HAS_BEACH", SpecValue::Bool(shore)), numbering.spec()];
        Ok(Self {
            pipeline: GraphicsPipeline::new(
                gpu,
                into.choose("ocean filter", "ocean filter and shade"),
                &GraphicsDesc {
                    vertex: into.choose("passes/ocean/filter.vert", "passes/ocean/object.vert"),
                    topology: into.topology(),
                    fragment: Some(into.choose("passes/ocean/filter.frag", "passes/ocean/filter_shade.frag")),
                    colors: into.formats(),
                    depth: into.depth(),
                    spec: &[into.spec(needs, Bases::default()), own].concat(),
                    structs: &[&[WaterGpu::LAYOUT, ShoreGpu::LAYOUT, CascadeGpu::LAYOUT], into.structs()].concat(),
                    ..Default::default()
                },
            )?,
            trilinear: Sampler::new(gpu, Filter::Trilinear, AddressMode::Repeat)?,
            nearest: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Filters the waves at the pixels of the sea into the active targets. If the pass shades, `light` is the descriptor set of the
    /// scene.
    pub fn draw(&self, cmd: &mut Commands, visible: &VisibleSurface, sea: SeaInputs<'_>, light: Option<&ResourceSet>) {
        let SeaInputs { fields, water, shore } = sea;
        let mut bindings = vec![
            ("visible_footprint", Descriptor::Sampled(visible.footprint.whole(), &self.nearest)),
            ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
            ("slopes", Descriptor::Sampled(fields.slopes.whole(), &self.trilinear)),
            ("joint", Descriptor::Sampled(fields.joint.whole(), &self.trilinear)),
            ("Cascades", Descriptor::Storage(&fields.cascades)),
            ("water", Descriptor::Uniform(water)),
            ("Beach", Descriptor::Uniform(shore)),
        ];
        bindings.push(match light {
            None => ("TileRecords", Descriptor::Storage(&visible.tiles.records)),
            Some(_) => ("visible_depth", Descriptor::Sampled(visible.depth.whole(), &self.nearest)),
        });
        cmd.bind(&self.pipeline, &bindings);
        if let Some(scene) = light {
            cmd.bind_set(scene);
        }
        match light {
            None => visible.tiles.draw(cmd),
            Some(_) => cmd.draw(0..3, 0..1),
        }
    }
}
