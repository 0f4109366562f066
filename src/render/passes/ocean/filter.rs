//! The filter of the sea's pixels: slope moments of the waves that each sees, written into the other objects' G-buffer.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use glam::Vec2;

use super::fields::{CascadeGpu, OceanFields};
use crate::gpu::{
    AddressMode, Buffer, ColorTarget, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Load, Memory,
    Result, Sampler, SharedStruct, SpecValue, Topology, Use, shared_struct,
};
use crate::render::passes::targets::{GBuffer, VisibleSurface};
use crate::render::settings::Needs;
use crate::render::surfaces::ocean::mesh::EARTH;
use crate::render::surfaces::ocean::shore::ShoreGpu;
use crate::render::surfaces::ocean::{Ocean, SEA_INDEX};

/// Beckmann roughness of the water itself, below all waves.
const WATER_ROUGHNESS: f32 = 0.01;
/// Reflectance of water at normal incidence.
const WATER_F0: f32 = 0.02;

shared_struct! {
    /// What the filter knows of the water.
    pub struct WaterGpu for "Water" {
        centre: [f32; 4],
        tail: [f32; 4],
        color: [f32; 4],
        foam: [f32; 4],
    }
}

/// Pipelines of the filter, one per set of needs that was asked for, and what they know of the water.
pub struct OceanFilter {
    pipelines: HashMap<Needs, GraphicsPipeline>,
    water: Buffer,
    trilinear: Sampler,
    nearest: Sampler,
}

impl OceanFilter {
    /// The filter, without pipelines yet.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self {
            pipelines: HashMap::new(),
            water: Buffer::new(gpu, "water", size_of::<WaterGpu>() as u64, Memory::Upload)?,
            trilinear: Sampler::new(gpu, "ocean moments", Filter::Trilinear, AddressMode::Repeat)?,
            nearest: Sampler::new(gpu, "ocean pixels", Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Makes the pipeline for what a technique needs, unless it is there, and writes what the water is like below a viewer at `centre`. The
    /// device must be idle.
    ///
    /// # Errors
    /// A failed pipeline or write.
    pub fn update(&mut self, gpu: &Arc<Gpu>, needs: Needs, ocean: &Ocean, centre: Vec2) -> Result<()> {
        if let Entry::Vacant(place) = self.pipelines.entry(needs) {
            let own = vec![("SEA", SpecValue::U32(SEA_INDEX)), ("HAS_BEACH", SpecValue::Bool(ocean.shore.is_some()))];
            place.insert(GraphicsPipeline::new(
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
            )?);
        }
        let threshold = if ocean.foam_threshold > 0.0 { ocean.foam_threshold } else { -1e9 };
        let water = WaterGpu {
            centre: [centre.x, centre.y, 1.0 / EARTH, 0.0],
            tail: ocean.tail.extend(WATER_ROUGHNESS).to_array(),
            color: ocean.color.extend(WATER_F0).to_array(),
            foam: ocean.foam.extend(threshold).to_array(),
        };
        self.water.write(0, &[water])
    }

    /// Begins a G-buffer that holds the other objects already, has `draw` fill the sea's pixels from the block of
    /// `passes/ocean/water.glsl`, and leaves it readable.
    pub fn record(&self, cmd: &mut Commands, target: &GBuffer, draw: impl FnOnce(&mut Commands, &Buffer)) {
        for image in target.colors() {
            cmd.transition(image, Use::ColorTarget);
        }
        let colors = target.colors().map(|image| ColorTarget { view: image.whole(), load: Load::Keep });
        cmd.begin_rendering(&colors, None);
        draw(cmd, &self.water);
        cmd.end_rendering();
        for image in target.colors() {
            cmd.transition(image, Use::Sampled);
        }
    }

    /// Filters the waves under the sea's pixels into the begun G-buffer, with needs of one of the last updates.
    pub fn draw(
        &self,
        cmd: &mut Commands,
        needs: Needs,
        fields: &OceanFields,
        shore: &Buffer,
        visible: &VisibleSurface,
    ) {
        let Some(pipeline) = self.pipelines.get(&needs) else { return };
        cmd.bind(
            pipeline,
            &[
                ("visible_texture", Descriptor::Sampled(visible.texture.whole(), &self.nearest)),
                ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                ("slopes", Descriptor::Sampled(fields.slopes.whole(), &self.trilinear)),
                ("joint", Descriptor::Sampled(fields.joint.whole(), &self.trilinear)),
                ("Cascades", Descriptor::Storage(&fields.cascades)),
                ("water", Descriptor::Uniform(&self.water)),
                ("Beach", Descriptor::Uniform(shore)),
                ("TileRecords", Descriptor::Storage(&visible.tiles.records)),
            ],
        );
        visible.tiles.draw(cmd);
    }
}
