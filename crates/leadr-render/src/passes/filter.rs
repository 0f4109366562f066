//! Filter pass: fetches the slope statistics and the material under each pixel, once per pixel, and shades it if nothing else needs
//! them.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::object_depth::OBJECT_TEST;
use super::shade::{SCENE_STRUCTS, ShadeKind};
use super::targets::{GBuffer, RADIANCE_FORMAT, VisibleSurface};
use crate::surfaces::numbering::Numbering;
use leadr_gpu::vk;
use rayon::prelude::*;

use crate::pixel_area::PixelArea;
use crate::settings::{Needs, ShadingOptions};
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

/// What becomes of what a filter pass finds under the pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FilterInto {
    /// It goes into the G-buffer, where edge samples are joined to it and other passes shade it.
    GBuffer,
    /// The pass shades it.
    Radiance(ShadeKind),
}

impl FilterInto {
    /// Formats of the images that the pass writes.
    pub fn formats(self) -> &'static [vk::Format] {
        match self {
            Self::GBuffer => &GBuffer::FORMATS,
            Self::Radiance(_) => &[RADIANCE_FORMAT],
        }
    }

    /// How it picks the pixels of its surface; into the G-buffer its fragment stage does.
    #[must_use]
    pub fn depth(self) -> Option<Depth> {
        match self {
            Self::GBuffer => None,
            Self::Radiance(_) => Some(OBJECT_TEST),
        }
    }

    /// What its vertices form: the tiles that show its surface, or a triangle that covers the screen.
    #[must_use]
    pub fn topology(self) -> Topology {
        match self {
            Self::GBuffer => Topology::Points,
            Self::Radiance(_) => Topology::Triangles,
        }
    }

    /// Structs that its fragment stage reads, but for those about the surface.
    pub fn structs(self) -> &'static [StructLayout] {
        match self {
            Self::GBuffer => &[],
            Self::Radiance(_) => &SCENE_STRUCTS,
        }
    }

    /// Specialization constants of its fragment stage, but for those about the surface. `bases`: those of what it
    /// filters; `relief_color`: whether its colours follow its relief.
    #[must_use]
    pub fn spec(self, needs: Needs, bases: Bases, relief_color: bool) -> Vec<(&'static str, SpecValue)> {
        match self {
            Self::GBuffer => needs.spec(),
            Self::Radiance(kind) => {
                let needed = |options: ShadingOptions| ShadingOptions {
                    relief_color: options.relief_color && relief_color,
                    ..options
                };
                ShadeKind { bases: kind.bases.within(bases), shading: kind.shading.adjusted(needed), ..kind }.spec()
            }
        }
    }

    /// Of two names, of shaders or of pipelines, the one for this.
    pub fn choose(self, gbuffer: &'static str, radiance: &'static str) -> &'static str {
        match self {
            Self::GBuffer => gbuffer,
            Self::Radiance(_) => radiance,
        }
    }
}

/// Rows of taps across the footprint, in the maps of slopes and of the material. One row blurs a pixel with its neighbours, which
/// shows where two roughnesses meet.
fn tap_rows(kind: SurfaceKind) -> i32 {
    if kind.has.bases.mixed { 3 } else { 1 }
}

/// Pipelines of the filter pass.
#[derive(Clone)]
pub struct FilterPass {
    pipelines: HashMap<SurfaceKind, GraphicsPipeline>,
    nearest: Sampler,
}

impl FilterPass {
    /// The pass for the inputs that a technique needs, and for objects of these kinds. `relief_drawn`: whether the geometry
    /// is displaced by as much as the maps say.
    pub fn new(
        gpu: &Arc<Gpu>,
        needs: Needs,
        relief_drawn: bool,
        into: FilterInto,
        objects: impl Iterator<Item = SurfaceKind>,
        numbering: Numbering,
    ) -> Result<Self> {
        // Drivers take a quarter of a second and more for a pipeline that shades.
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
            ("REFLECTS_BY_MAP", SpecValue::Bool(kind.has.f0)),
            ("HORIZON", SpecValue::Bool(kind.horizon)),
            ("TAP_ROWS", SpecValue::I32(tap_rows(kind))),
            ("COLOR_BY_HEIGHT", SpecValue::Bool(kind.follows.heights)),
            ("COLOR_BY_SLOPE", SpecValue::Bool(kind.follows.slopes)),
            ("FLAT", SpecValue::Bool(kind.flat)),
            ("TRIANGLES", SpecValue::Bool(kind.triangles)),
            ("TRIPLANAR", SpecValue::Bool(kind.triplanar)),
            ("BY_EXAMPLE", SpecValue::Bool(kind.by_example)),
            ("GROUND", SpecValue::Bool(kind.ground)),
            ("RISE_OVER_RUN", SpecValue::Bool(kind.rise_over_run)),
            ("PLAIN", SpecValue::Bool(kind.plain)),
            ("RELIEF_DRAWN", SpecValue::Bool(relief_drawn)),
            ("EDGE_SAMPLES", SpecValue::Bool(into == FilterInto::GBuffer)),
            ("DETAIL", SpecValue::U32(kind.detail.mapping)),
            ("DETAIL_COLORS", SpecValue::U32(kind.detail.colors)),
            ("DETAIL_MASKED", SpecValue::Bool(kind.detail.masked)),
            ("EMITS", SpecValue::Bool(kind.has.emission)),
            ("OCCLUDED", SpecValue::Bool(kind.has.occlusion)),
            ("CHARTED", SpecValue::Bool(kind.charted)),
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
            // Where it shades, that says so.
            has.extend(kind.has.bases.spec());
        }
        let desc = GraphicsDesc {
            vertex: into.choose("passes/filter/filter.vert", "passes/filter/object.vert"),
            fragment: Some(into.choose("passes/filter/filter.frag", "passes/filter/filter_shade.frag")),
            colors: into.formats(),
            depth: into.depth(),
            topology: into.topology(),
            spec: &[&into.spec(needs, kind.has.bases, kind.follows.any())[..], &has].concat(),
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

    /// Filters the maps of `objects` into the begun targets, at the pixels of a view that see them. `light` is the set of the scene, where
    /// the pass shades. The pass must know the kinds of all objects.
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
            // Who shades covers the screen, and needs no tiles.
            cmd.bind(&self.pipelines[&posed.object.kind], if light.is_some() { &pixels[..6] } else { &pixels });
            cmd.bind_set(&posed.object.set);
            if let Some(scene) = light {
                cmd.bind_set(scene);
            }
            cmd.push_constants(&records.draw(posed));
            match light {
                None => visible.tiles.draw(cmd),
                Some(_) => {
                    cmd.scissor(PixelArea::of_spheres(&[posed.bounds()], &view.camera, view.picture).scissor(1));
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
