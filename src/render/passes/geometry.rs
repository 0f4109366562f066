//! Geometry pass: tessellates, displaces and rasterises; for each pixel it stores the visible surface.

use std::sync::Arc;

use super::targets::GeometryTargets;
use crate::gpu::{
    Commands, Depth, Descriptor, Gpu, GraphicsDesc, GraphicsPipeline, Image, Result, SharedStruct, SpecValue, Topology,
};
use crate::render::constants::{GUARD_BAND, PIXELS_ARE_EDGES, PIXELS_ARE_MULTISAMPLED, PIXELS_ARE_SAMPLES};
use crate::render::surfaces::object::{ChartsGpu, SurfaceKind};
use crate::render::surfaces::object_view::{DrawnObject, GEOMETRY_STRUCTS};
use crate::render::surfaces::posed::PosedObject;
use crate::render::view::Samples;

/// What the geometry pass writes for the samples of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GeometryKind {
    /// What each pixel sees in its middle.
    Pixels,
    /// The same for each of several samples of a pixel.
    Multisampled(u32),
    /// The same for edge samples, with what joins them.
    Edges,
    /// What each pixel sees of the edges of triangles alone.
    Wires,
}

impl GeometryKind {
    /// The kind for the samples of a view.
    #[must_use]
    pub fn of(samples: Samples) -> Self {
        match samples {
            Samples::Pixels => Self::Pixels,
            Samples::Multisampled { count } => Self::Multisampled(count),
            Samples::Edges { .. } => Self::Edges,
        }
    }

    /// Samples of each texel of the targets.
    #[must_use]
    pub fn samples(self) -> u32 {
        match self {
            Self::Multisampled(count) => count,
            Self::Pixels | Self::Edges | Self::Wires => 1,
        }
    }

    /// The constant of that name in the shaders.
    #[must_use]
    pub fn pixels(self) -> (&'static str, SpecValue) {
        let kind = match self {
            Self::Pixels | Self::Wires => PIXELS_ARE_SAMPLES,
            Self::Multisampled(_) => PIXELS_ARE_MULTISAMPLED,
            Self::Edges => PIXELS_ARE_EDGES,
        };
        ("PIXELS", SpecValue::I32(kind))
    }
}

/// The geometry pass of one kind.
#[derive(Clone)]
pub struct GeometryPass(PatchPipelines);

/// The pipelines that draw patches into one kind of target; shared with the shadow passes.
#[derive(Clone)]
pub(crate) struct PatchPipelines(Vec<(DrawnAs, PipelineSet)>);

/// The fragment stage of depths of surfaces with holes.
pub(crate) const DEPTH_OF_HOLES: &str = "passes/geometry/depth_holes.frag";

/// What tells the pipelines of surfaces apart, beside how they are divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct DrawnAs {
    /// Only the front is drawn.
    pub front_only: bool,
    /// It has holes.
    pub holes: bool,
    /// Its maps are shown without their repeats.
    pub by_example: bool,
}

impl DrawnAs {
    /// Casters of these kinds: both their sides throw shadows.
    pub fn casters(kinds: CasterKinds) -> impl Iterator<Item = Self> {
        let CasterKinds { holes, by_example } = kinds;
        let drawn = |holes, by_example| Self { holes, by_example, front_only: false };
        [(holes, false), (false, by_example), (holes && by_example, holes && by_example)]
            .into_iter()
            .filter(|&(holes, by_example)| holes || by_example)
            .map(move |(holes, by_example)| drawn(holes, by_example))
    }
}

/// What there is among the casters of a scene that is not drawn as others are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct CasterKinds {
    /// Some have holes.
    pub holes: bool,
    /// The maps of some are shown without their repeats.
    pub by_example: bool,
}

impl CasterKinds {
    /// What there is in either.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self { holes: self.holes || other.holes, by_example: self.by_example || other.by_example }
    }
}

/// For what patches are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PatchMode {
    /// To be seen; back faces in a marker colour or not.
    Seen { mark_inside: bool },
    /// To throw shadows.
    Caster,
}

#[derive(Clone)]
struct PipelineSet {
    undivided: GraphicsPipeline,
    curved: GraphicsPipeline,
    flat: GraphicsPipeline,
    triangles: GraphicsPipeline,
    at_texels: GraphicsPipeline,
}

impl PatchPipelines {
    /// Pipelines whose vertex and tessellation stages are those of patches, for surfaces without holes that are seen from both sides and
    /// for others. `holes`: the fragment stage of what has holes.
    ///
    /// # Errors
    /// A failed pipeline.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        name: &str,
        desc: &GraphicsDesc<'_>,
        holes: &str,
        others: impl Iterator<Item = DrawnAs>,
    ) -> Result<Self> {
        let mut sets = Vec::new();
        for drawn in std::iter::once(DrawnAs::default()).chain(others) {
            if sets.iter().any(|(other, _)| *other == drawn) {
                continue;
            }
            let fragment = if drawn.holes { Some(holes) } else { desc.fragment };
            let count = [("SAMPLES", SpecValue::I32(desc.samples as i32))];
            let multisampled = drawn.holes && holes != DEPTH_OF_HOLES;
            // Only stages of quads have it.
            let by_example = [("BY_EXAMPLE", SpecValue::Bool(true))];
            let spec =
                [desc.spec, if multisampled { &count } else { &[] }, if drawn.by_example { &by_example } else { &[] }]
                    .concat();
            let structs = [&GEOMETRY_STRUCTS[..], if drawn.holes { &[ChartsGpu::LAYOUT] } else { &[] }].concat();
            let desc = GraphicsDesc { fragment, front_only: drawn.front_only, spec: &spec, structs: &structs, ..*desc };
            sets.push((drawn, PipelineSet::new(gpu, name, &desc, drawn.by_example)?));
        }
        Ok(Self(sets))
    }

    /// Binds and draws one object.
    pub(crate) fn draw(&self, cmd: &mut Commands, drawn: DrawnObject<'_>, mode: PatchMode) {
        let kind = drawn.posed.object.kind;
        let front_only = kind.front_only && mode == PatchMode::Seen { mark_inside: false };
        let wanted = DrawnAs { front_only, holes: kind.has.holes.is_some(), by_example: kind.displaced_by_example() };
        let found = self.0.iter().find(|(drawn, _)| *drawn == wanted).or(self.0.first());
        if let Some((drawn_as, set)) = found {
            set.draw(cmd, drawn, drawn_as.holes, mode == PatchMode::Seen { mark_inside: true });
        }
    }
}

impl PipelineSet {
    /// `quads`: whether they draw no triangles.
    fn new(gpu: &Arc<Gpu>, name: &str, desc: &GraphicsDesc<'_>, quads: bool) -> Result<Self> {
        let divided = |kind: &str, flat: bool, at_texels: bool| {
            let divided = GraphicsDesc {
                vertex: "passes/geometry/geometry.vert",
                tessellation: Some(["passes/geometry/geometry.tesc", "passes/geometry/geometry.tese"]),
                topology: Topology::Patches(4),
                // The tessellator counts v downward.
                clockwise_front: true,
                spec: &[desc.spec, &[("FLAT", SpecValue::Bool(flat)), ("AT_TEXELS", SpecValue::Bool(at_texels))]]
                    .concat(),
                ..*desc
            };
            GraphicsPipeline::new(gpu, &format!("{name}, {kind}"), &divided)
        };
        let triangles = GraphicsDesc {
            vertex: "passes/geometry/geometry.vert",
            tessellation: Some(["passes/geometry/triangle.tesc", "passes/geometry/triangle.tese"]),
            topology: Topology::Patches(4),
            clockwise_front: true,
            ..*desc
        };
        let undivided = GraphicsDesc { vertex: "passes/geometry/undivided.vert", ..*desc };
        let curved = divided("curved", false, false)?;
        Ok(Self {
            undivided: GraphicsPipeline::new(gpu, &format!("{name}, undivided"), &undivided)?,
            triangles: if quads {
                curved.clone()
            } else {
                GraphicsPipeline::new(gpu, &format!("{name}, triangles"), &triangles)?
            },
            curved,
            flat: divided("flat", true, false)?,
            at_texels: divided("at texels", true, true)?,
        })
    }

    fn draw(&self, cmd: &mut Commands, drawn: DrawnObject<'_>, holes: bool, mark_inside: bool) {
        let DrawnObject { posed, divided, view } = drawn;
        let PosedObject { object, height_scale, .. } = posed;
        let mut bindings = vec![
            ("view", Descriptor::Uniform(&view.buffers.view)),
            ("Vertices", Descriptor::Storage(&divided.buffers.vertices)),
            ("Patches", Descriptor::Storage(&object.patches)),
            ("EdgeFactors", Descriptor::Storage(&divided.buffers.edge_factors)),
            ("EdgeHeights", Descriptor::Storage(&object.edge_heights)),
            ("VertexHeights", Descriptor::Storage(&object.vertex_heights)),
            ("VisiblePatches", Descriptor::Storage(&view.buffers.visible)),
            ("height_map", Descriptor::Sampled(object.maps.leadr.heights().whole(), &object.maps.sampler)),
        ];
        if holes {
            let [.., sampler] = &object.maps.material.samplers;
            bindings.push(("Charts", Descriptor::Storage(&object.maps.charts)));
            bindings.push(("opacity_map", Descriptor::Sampled(object.maps.material.opacity.whole(), sampler)));
        }
        let pipeline = match object.kind {
            _ if view.at_texels => &self.at_texels,
            kind if kind.flat => &self.flat,
            kind if kind.triangles => &self.triangles,
            _ => &self.curved,
        };
        let draws = [(&self.undivided, &view.draws.undivided, 6), (pipeline, &view.draws.divided, 4)];
        for (pipeline, draws, vertices) in draws.into_iter().filter(|(_, draws, _)| !draws.is_empty()) {
            cmd.bind(pipeline, &bindings);
            cmd.push_constants(&object.constants(*height_scale, mark_inside, posed.tiling_shift()));
            for &(first, count) in draws {
                cmd.draw(first * vertices..(first + count) * vertices, 0..1);
            }
        }
    }
}

impl GeometryPass {
    /// The pass for objects of these kinds. It draws both sides of a surface unless that says otherwise: a closed surface hides its own
    /// inside.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>, kind: GeometryKind, objects: &[SurfaceKind]) -> Result<Self> {
        let desc = GraphicsDesc {
            fragment: Some("passes/geometry/geometry.frag"),
            colors: &GeometryTargets::FORMATS,
            // Single samples of a picture have no footprint of their own.
            kept_colors: usize::from(matches!(kind, GeometryKind::Pixels | GeometryKind::Wires)),
            depth: Some(Depth::default()),
            samples: kind.samples(),
            wires: kind == GeometryKind::Wires,
            spec: &[kind.pixels()],
            ..Default::default()
        };
        let name = match kind {
            GeometryKind::Pixels => "geometry",
            GeometryKind::Multisampled(_) => "multisampled geometry",
            GeometryKind::Edges => "geometry of edges",
            GeometryKind::Wires => "wires",
        };
        let others = objects.iter().flat_map(|kind| {
            let holes = kind.has.holes.is_some();
            // Backs are drawn where they are to be marked.
            let by_example = kind.displaced_by_example();
            [kind.front_only, false].map(|front_only| DrawnAs { front_only, holes, by_example })
        });
        Ok(Self(PatchPipelines::new(gpu, name, &desc, "passes/geometry/geometry_holes.frag", others)?))
    }

    /// Draws objects into the begun targets; `mark_inside` paints back faces in a marker colour.
    pub fn draw<'a>(
        &self,
        cmd: &mut Commands,
        target: &GeometryTargets,
        objects: impl Iterator<Item = DrawnObject<'a>>,
        mark_inside: bool,
    ) {
        guard_band(cmd, &target.depth);
        for object in objects {
            self.0.draw(cmd, object, PatchMode::Seen { mark_inside });
        }
    }
}

/// Sets a viewport of [`GUARD_BAND`] times the target's size, and a scissor of the target alone.
pub(crate) fn guard_band(cmd: &mut Commands, target: &Image) {
    let [width, height] = target.mip_extent(0);
    let (w, h) = (width as f32, height as f32);
    let margin = (GUARD_BAND - 1.0) / 2.0;
    cmd.viewport([-margin * w, -margin * h, GUARD_BAND * w, GUARD_BAND * h]);
    cmd.scissor([0, 0, width, height]);
}
