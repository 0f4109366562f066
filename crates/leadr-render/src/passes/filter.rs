//! The filter pass, which fetches the slope statistics and the material under each pixel. If no other pass needs these inputs, it
//! also shades the pixel.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::object_depth::OBJECT_TEST;
use super::shade::{Edges, SCENE_STRUCTS, ShadeKind};
use super::targets::{GBuffer, RADIANCE_FORMAT, VisibleSurface};
use crate::surfaces::numbering::Numbering;
use leadr_gpu::vk;
use rayon::prelude::*;

use crate::pixel_area::PixelArea;
use crate::settings::Needs;
use crate::surfaces::atlas::{AtlasHeadGpu, PatchLinkGpu};
use crate::surfaces::detail::{DetailHeadGpu, RestVertexGpu};
use crate::surfaces::divided::VertexGpu;
use crate::surfaces::material::Bases;
use crate::surfaces::object::{ChartsGpu, PatchGpu, SurfaceKind};
use crate::surfaces::object_view::DrawnObject;
use crate::surfaces::records::{DrawGpu, ObjectRecordGpu, ViewRecordGpu};
use crate::view::{Samples, View};
use leadr_gpu::{
    AddressMode, Commands, Depth, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, ResourceSet, Result,
    Sampler, SharedStruct, SpecValue, StructLayout, Topology,
};

/// The output of a filter pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FilterInto {
    /// The pass writes the G-buffer, where edge samples are joined before shading.
    GBuffer,
    /// The pass writes shaded radiance.
    Radiance(ShadeKind),
}

impl FilterInto {
    /// Returns the formats of the output images.
    pub fn formats(self) -> &'static [vk::Format] {
        match self {
            Self::GBuffer => &GBuffer::FORMATS,
            Self::Radiance(_) => &[RADIANCE_FORMAT],
        }
    }

    /// Returns the depth test that selects the pixels of the surface, or `None` for the G-buffer, where the fragment stage selects
    /// the pixels.
    #[must_use]
    pub fn depth(self) -> Option<Depth> {
        match self {
            Self::GBuffer => None,
            Self::Radiance(_) => Some(OBJECT_TEST),
        }
    }

    /// Returns the primitives of the pass: points for the tiles that contain the surface, or a triangle that covers the screen.
    #[must_use]
    pub fn topology(self) -> Topology {
        match self {
            Self::GBuffer => Topology::Points,
            Self::Radiance(_) => Topology::Triangles,
        }
    }

    /// Returns the structs of the fragment stage, without the structs that belong to the surface.
    pub fn structs(self) -> &'static [StructLayout] {
        match self {
            Self::GBuffer => &[],
            Self::Radiance(_) => &SCENE_STRUCTS,
        }
    }

    /// Returns the specialisation constants of the fragment stage, without those that belong to the surface. `bases` are the base
    /// materials.
    #[must_use]
    pub fn spec(self, needs: Needs, bases: Bases) -> Vec<(&'static str, SpecValue)> {
        match self {
            Self::GBuffer => needs.spec(),
            Self::Radiance(kind) => ShadeKind { bases: kind.bases.within(bases), ..kind }.spec(),
        }
    }

    /// Whether the pass reads edge samples.
    fn reads_edges(self) -> bool {
        matches!(self, Self::GBuffer | Self::Radiance(ShadeKind { edges: Edges::Shaded, .. }))
    }

    /// Returns the name of a shader or pipeline for this output.
    pub fn choose(self, gbuffer: &'static str, radiance: &'static str) -> &'static str {
        match self {
            Self::GBuffer => gbuffer,
            Self::Radiance(_) => radiance,
        }
    }
}

/// The pipelines of the filter pass.
#[derive(Clone)]
pub struct FilterPass {
    pipelines: HashMap<SurfaceKind, GraphicsPipeline>,
    nearest: Sampler,
}

impl FilterPass {
    /// Creates the pass for the inputs of a technique and for these kinds of objects. `relief_drawn` is whether the geometry is
    /// displaced by the full heights of the maps.
    pub fn new(
        gpu: &Arc<Gpu>,
        needs: Needs,
        relief_drawn: bool,
        into: FilterInto,
        objects: impl Iterator<Item = SurfaceKind>,
        numbering: Numbering,
    ) -> Result<Self> {
        // Pipelines are made in parallel, because drivers take a quarter of a second or more for a pipeline that shades.
        let kinds: HashSet<SurfaceKind> = objects.collect();
        let pipeline = |kind| Ok((kind, Self::pipeline(gpu, needs, relief_drawn, into, kind, numbering)?));
        Ok(Self {
            pipelines: kinds.into_par_iter().map(pipeline).collect::<Result<_>>()?,
            nearest: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    fn pipeline(
        gpu: &Arc<Gpu>,
        needs: Needs,
        relief_drawn: bool,
        into: FilterInto,
        kind: SurfaceKind,
        numbering: Numbering,
    ) -> Result<GraphicsPipeline> {
        let mut has = vec![
            numbering.spec(),
            ("ATLAS", SpecValue::Bool(kind.tiled)),
            ("DISPLACED", SpecValue::Bool(kind.displaced)),
            ("COLORED", SpecValue::Bool(kind.colored)),
            ("REFLECTS_BY_MAP", SpecValue::Bool(kind.features.f0)),
            ("HORIZON", SpecValue::Bool(kind.horizon)),
            ("TAP_ROWS", SpecValue::I32(kind.tap_rows)),
            ("CLASS_COLORS", SpecValue::Bool(kind.class_colors)),
            ("CLASSES_HIDE", SpecValue::Bool(kind.displaced)),
            ("FLAT", SpecValue::Bool(kind.flat)),
            ("TRIANGLES", SpecValue::Bool(kind.triangles)),
            ("TRIPLANAR", SpecValue::Bool(kind.triplanar)),
            ("BY_EXAMPLE", SpecValue::Bool(kind.by_example)),
            ("GROUND", SpecValue::Bool(kind.ground)),
            ("RISE_OVER_RUN", SpecValue::Bool(kind.rise_over_run)),
            ("PLAIN", SpecValue::Bool(kind.plain)),
            ("RELIEF_DRAWN", SpecValue::Bool(relief_drawn)),
            ("JOINS_EDGES", SpecValue::Bool(kind.tiled && !kind.has_classes())),
            ("EDGE_SAMPLES", SpecValue::Bool(into.reads_edges())),
            ("DETAIL", SpecValue::U32(kind.detail.mapping)),
            ("DETAIL_COLORS", SpecValue::U32(kind.detail.colors)),
            ("DETAIL_MASKED", SpecValue::Bool(kind.detail.masked)),
            ("EMITS", SpecValue::Bool(kind.features.emission)),
            ("OCCLUDED", SpecValue::Bool(kind.features.occlusion)),
            ("CHARTED", SpecValue::Bool(kind.charted)),
            ("COAT_MAP", SpecValue::Bool(kind.features.coat)),
            ("HEIGHT_TERMS", SpecValue::U32(kind.height_terms)),
        ];
        let structs = [
            ObjectRecordGpu::LAYOUT,
            ViewRecordGpu::LAYOUT,
            DrawGpu::LAYOUT,
            AtlasHeadGpu::LAYOUT,
            PatchLinkGpu::LAYOUT,
            VertexGpu::LAYOUT,
            PatchGpu::LAYOUT,
            ChartsGpu::LAYOUT,
            DetailHeadGpu::LAYOUT,
            RestVertexGpu::LAYOUT,
        ];
        if into == FilterInto::GBuffer {
            // For a pass that shades, the shading already sets these constants. The G-buffer holds one class.
            has.extend(Bases { classes: 1, ..kind.features.bases }.spec());
        }
        let desc = GraphicsDesc {
            vertex: into.choose("passes/filter/filter.vert", "passes/filter/object.vert"),
            fragment: Some(into.choose("passes/filter/filter.frag", "passes/filter/filter_shade.frag")),
            colors: into.formats(),
            depth: into.depth(),
            topology: into.topology(),
            spec: &[&into.spec(needs, kind.features.bases)[..], &has].concat(),
            structs: &[&structs[..], into.structs()].concat(),
            ..Default::default()
        };
        let name = match (kind.tiled, into) {
            (false, FilterInto::GBuffer) => "filter",
            (true, FilterInto::GBuffer) => "filter atlas",
            (false, FilterInto::Radiance(_)) => "filter and shade",
            (true, FilterInto::Radiance(_)) => "filter and shade atlas",
        };
        GraphicsPipeline::new(gpu, name, &desc)
    }

    /// Filters the maps of `objects` into the active targets, at the pixels that show the objects in a view. If the pass shades,
    /// `light` is the descriptor set of the scene. The pass must have been made for the kinds of all objects.
    pub fn draw<'a>(
        &self,
        cmd: &mut Commands,
        visible: &VisibleSurface,
        view: &View,
        objects: impl Iterator<Item = DrawnObject<'a>>,
        light: Option<&ResourceSet>,
    ) {
        for DrawnObject { posed, divided, records, .. } in objects {
            let [objects, views] = records.bindings();
            let pixels = [
                ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
                ("visible_footprint", Descriptor::Sampled(visible.footprint.whole(), &self.nearest)),
                ("visible_depth", Descriptor::Sampled(visible.depth.whole(), &self.nearest)),
                ("Vertices", Descriptor::Storage(&divided.buffers.vertices)),
                objects,
                views,
                ("TileRecords", Descriptor::Storage(&visible.tiles.records)),
            ];
            // A pass that shades covers the screen, so it needs no tiles.
            let (kind, set) = posed
                .by_class()
                .map_or((posed.object.kind, &posed.object.set), |by_class| (by_class.kind, &by_class.set));
            cmd.bind(&self.pipelines[&kind], if light.is_some() { &pixels[..6] } else { &pixels });
            cmd.bind_set(set);
            if let Some(scene) = light {
                cmd.bind_set(scene);
            }
            cmd.push_constants(&records.draw(posed));
            match light {
                None => visible.tiles.draw(cmd),
                Some(_) => {
                    cmd.scissor(
                        PixelArea::of_spheres(&[posed.bounds()], &view.camera, view.picture).scissor(view.grid()),
                    );
                    cmd.draw(0..3, 0..1);
                    if let Samples::Multisampled { .. } = view.samples {
                        let [width, height] = visible.surface.mip_extent(0);
                        cmd.scissor([0, height / 2, width, height / 2]);
                        cmd.draw(0..3, 0..1);
                    }
                }
            }
        }
    }
}
