//! Filter pass: fetches the slope statistics and the material under each pixel, once per pixel.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use super::targets::{GBuffer, VisibleSurface};
use crate::gpu::{
    AddressMode, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Result, Sampler, SharedStruct,
    SpecValue, Topology,
};
use crate::render::settings::Needs;
use crate::render::surfaces::atlas::{AtlasHeadGpu, PatchLinkGpu};
use crate::render::surfaces::object::{FilteredObjectGpu, GpuObject, MapSet};
use crate::render::view::View;

/// Pipelines of the filter pass.
#[derive(Clone)]
pub struct FilterPass {
    pipelines: HashMap<MapSet, GraphicsPipeline>,
    nearest: Sampler,
    linear: Sampler,
}

impl FilterPass {
    /// The pass for the inputs that a technique needs, and for objects with these maps.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>, needs: Needs, objects: impl Iterator<Item = MapSet>) -> Result<Self> {
        let mut pipelines = HashMap::new();
        for maps in objects {
            if let Entry::Vacant(place) = pipelines.entry(maps) {
                place.insert(Self::pipeline(gpu, needs, maps)?);
            }
        }
        Ok(Self {
            pipelines,
            nearest: Sampler::new(gpu, "filter", Filter::Nearest, AddressMode::ClampToEdge)?,
            linear: Sampler::new(gpu, "coarse levels", Filter::Bilinear, AddressMode::ClampToEdge)?,
        })
    }

    fn pipeline(gpu: &Arc<Gpu>, needs: Needs, maps: MapSet) -> Result<GraphicsPipeline> {
        let has = [
            ("ATLAS", SpecValue::Bool(maps.tiled)),
            ("DISPLACED", SpecValue::Bool(maps.displaced)),
            ("COLORED", SpecValue::Bool(maps.colored)),
            ("HORIZON", SpecValue::Bool(maps.horizon)),
        ];
        let desc = GraphicsDesc {
            vertex: "passes/filter/filter.vert",
            fragment: Some("passes/filter/filter.frag"),
            colors: &GBuffer::FORMATS,
            topology: Topology::Points,
            spec: &[&needs.spec()[..], &has].concat(),
            structs: &[FilteredObjectGpu::LAYOUT, AtlasHeadGpu::LAYOUT, PatchLinkGpu::LAYOUT],
            ..Default::default()
        };
        GraphicsPipeline::new(gpu, if maps.tiled { "filter atlas" } else { "filter" }, &desc)
    }

    /// Filters the maps of `objects` into the begun G-buffer, at the pixels of a view that see them. `height_scale`
    /// multiplies the height scale of every object. The pass must know their maps.
    pub fn draw<'a>(
        &self,
        cmd: &mut Commands,
        visible: &VisibleSurface,
        view: &View,
        objects: impl Iterator<Item = &'a GpuObject>,
        height_scale: f32,
    ) {
        for object in objects {
            cmd.bind(
                &self.pipelines[&object.map_set()],
                &[
                    ("visible_texture", Descriptor::Sampled(visible.texture.whole(), &self.nearest)),
                    ("visible_tangent", Descriptor::Sampled(visible.tangent.whole(), &self.nearest)),
                    ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                    ("moments_a", Descriptor::Sampled(object.maps.slopes().whole(), &object.sampler)),
                    ("moments_b", Descriptor::Sampled(object.maps.joint().whole(), &object.sampler)),
                    ("horizon_a", Descriptor::Sampled(object.horizons.leans().whole(), &object.sampler)),
                    ("horizon_b", Descriptor::Sampled(object.horizons.correlations().whole(), &object.sampler)),
                    ("color_map", Descriptor::Sampled(object.color.whole(), &object.sampler)),
                    ("Atlas", Descriptor::Storage(&object.atlas.links)),
                    ("TileRecords", Descriptor::Storage(&visible.tiles.records)),
                    ("coarse_a", Descriptor::Sampled(object.atlas.slopes.whole(), &self.linear)),
                    ("coarse_b", Descriptor::Sampled(object.atlas.joint.whole(), &self.linear)),
                    ("coarse_color", Descriptor::Sampled(object.atlas.color.whole(), &self.linear)),
                    ("visible_depth", Descriptor::Sampled(visible.depth.whole(), &self.nearest)),
                ],
            );
            cmd.push_constants(&FilteredObjectGpu::new(object.constants(height_scale, false), view));
            visible.tiles.draw(cmd);
        }
    }
}
