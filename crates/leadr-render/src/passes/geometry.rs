//! The geometry pass, which tessellates, displaces and rasterises the surfaces, and stores the visible surface of each pixel.

use std::sync::Arc;

use super::targets::GeometryTargets;
use crate::constants::{
    GUARD_BAND, HEIGHT_SCALED_BY_MAP, HEIGHT_SCALED_BY_VERTEX, HEIGHT_WITH_DETAIL, PIXELS_ARE_EDGES,
    PIXELS_ARE_MULTISAMPLED, PIXELS_ARE_SAMPLES,
};
use crate::surfaces::numbering::Numbering;
use crate::surfaces::object::{ChartsGpu, SurfaceKind};
use crate::surfaces::object_view::{DrawnObject, GEOMETRY_STRUCTS};
use crate::view::Samples;
use leadr_gpu::{
    Commands, Depth, Descriptor, Gpu, GraphicsDesc, GraphicsPipeline, Image, Result, SharedStruct, SpecValue, Topology,
};

/// What the geometry pass stores for the samples of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GeometryKind {
    /// Stores the surface at each pixel's sample.
    Pixels,
    /// Stores the surface at each of this many samples per pixel.
    Multisampled(u32),
    /// Stores the surface at each edge sample, with the data for joining the samples.
    Edges,
    /// Stores only triangle edges.
    Wires,
}

impl GeometryKind {
    /// Returns the kind for the samples that a view has.
    pub fn of(samples: Samples) -> Self {
        match samples {
            Samples::Pixels => Self::Pixels,
            Samples::Multisampled { count } => Self::Multisampled(count),
            Samples::Edges { .. } => Self::Edges,
        }
    }

    /// Returns the number of samples per texel of the targets.
    pub fn samples(self) -> u32 {
        match self {
            Self::Multisampled(count) => count,
            Self::Pixels | Self::Edges | Self::Wires => 1,
        }
    }

    /// Returns the specialisation constant `PIXELS` of the shaders.
    pub fn pixels(self) -> (&'static str, SpecValue) {
        let kind = match self {
            Self::Pixels | Self::Wires => PIXELS_ARE_SAMPLES,
            Self::Multisampled(_) => PIXELS_ARE_MULTISAMPLED,
            Self::Edges => PIXELS_ARE_EDGES,
        };
        ("PIXELS", SpecValue::I32(kind))
    }
}

/// The geometry pass for one kind of output.
#[derive(Clone)]
pub struct GeometryPass(PatchPipelines);

/// The pipelines that draw patches into one kind of target. The shadow passes use this type too.
#[derive(Clone)]
pub(crate) struct PatchPipelines(Vec<(DrawnAs, PipelineSet)>);

/// The fragment stage that writes only the depth of cutout surfaces.
pub(crate) const CUTOUT_DEPTH: &str = "passes/geometry/depth_cutout.frag";

/// How the patches of a surface are tessellated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Shape {
    /// The patches are quads of any shape.
    #[default]
    Curved,
    /// The patches are quads of a plane.
    Flat,
    /// The patches are triangles.
    Triangles,
}

impl Shape {
    const ALL: [Self; 3] = [Self::Curved, Self::Flat, Self::Triangles];
}

/// The properties of a surface that select its pipeline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct DrawnAs {
    /// Whether only the front of the surface is drawn.
    pub front_only: bool,
    /// Whether the surface has an alpha mask or partial coverage.
    pub cutout: bool,
    /// Whether the surface's maps are tiled by example.
    pub by_example: bool,
    /// How the surface's patches are tessellated.
    pub shape: Shape,
    /// What scales and adds to the heights of the map, as `HEIGHT_` bits.
    pub height_terms: u32,
}

impl DrawnAs {
    /// Returns the properties of this kind, with both sides drawn.
    fn both_sides(kind: SurfaceKind) -> Self {
        let shape = match kind {
            SurfaceKind { flat: true, .. } => Shape::Flat,
            SurfaceKind { triangles: true, .. } => Shape::Triangles,
            _ => Shape::Curved,
        };
        let (cutout, by_example) = (kind.features.cutout.is_some(), kind.displaced_by_example());
        Self { front_only: false, cutout, by_example, shape, height_terms: kind.height_terms }
    }
}

/// The kinds of shadow casters in a scene. Both sides of a surface cast shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct CasterKinds {
    /// A bit mask with one bit for each kind in [`all`](Self::all).
    present: u128,
}

impl CasterKinds {
    /// Returns all possible kinds.
    fn all() -> impl Iterator<Item = DrawnAs> {
        let tiled = |shape| [false, true].map(|by_example| (shape, by_example));
        let drawn = |(shape, by_example), cutout, height_terms| DrawnAs {
            front_only: false,
            cutout,
            by_example,
            shape,
            height_terms,
        };
        let of_scales = move |height_terms| {
            let of_tiled = move |tiled| [false, true].map(|cutout| drawn(tiled, cutout, height_terms));
            Shape::ALL.into_iter().flat_map(tiled).flat_map(of_tiled)
        };
        (0..=HEIGHT_SCALED_BY_VERTEX | HEIGHT_SCALED_BY_MAP | HEIGHT_WITH_DETAIL).flat_map(of_scales)
    }

    /// Returns the set that contains only this kind.
    pub fn of(kind: SurfaceKind) -> Self {
        let drawn = DrawnAs::both_sides(kind);
        Self { present: Self::all().position(|other| other == drawn).map_or(0, |bit| 1 << bit) }
    }

    /// Returns the union of two sets.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self { present: self.present | other.present }
    }

    /// Whether the set is empty.
    pub fn is_empty(self) -> bool {
        self.present == 0
    }

    pub(crate) fn iter(self) -> impl Iterator<Item = DrawnAs> {
        Self::all().enumerate().filter(move |(bit, _)| self.present >> bit & 1 == 1).map(|(_, drawn)| drawn)
    }
}

/// Why patches are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PatchMode {
    /// Draws visible surfaces. Back faces can be drawn in a marker colour.
    Seen { mark_inside: bool },
    /// Draws shadow casters.
    Caster,
}

#[derive(Clone)]
struct PipelineSet {
    undivided: GraphicsPipeline,
    divided: GraphicsPipeline,
    /// The pipeline for planes with one vertex per height texel. Only quads have it.
    at_texels: Option<GraphicsPipeline>,
}

impl PatchPipelines {
    /// Creates pipelines with the stages that draw patches, for surfaces of these kinds. `cutout` is the fragment stage of cutout
    /// surfaces.
    pub(crate) fn new(
        gpu: &Arc<Gpu>,
        name: &str,
        desc: &GraphicsDesc<'_>,
        cutout: &str,
        kinds: impl Iterator<Item = DrawnAs>,
    ) -> Result<Self> {
        let mut sets = Vec::new();
        for drawn in kinds {
            if sets.iter().any(|(other, _)| *other == drawn) {
                continue;
            }
            let fragment = if drawn.cutout { Some(cutout) } else { desc.fragment };
            let count = [("SAMPLES", SpecValue::I32(desc.samples as i32))];
            let multisampled = drawn.cutout && cutout != CUTOUT_DEPTH;
            // Only the stages of quads have this constant.
            let by_example = [("BY_EXAMPLE", SpecValue::Bool(true))];
            let height_terms = [("HEIGHT_TERMS", SpecValue::U32(drawn.height_terms))];
            let spec = [
                desc.spec,
                if multisampled { &count } else { &[] },
                if drawn.by_example { &by_example } else { &[] },
                if drawn.height_terms != 0 { &height_terms } else { &[] },
            ]
            .concat();
            let structs = [&GEOMETRY_STRUCTS[..], if drawn.cutout { &[ChartsGpu::LAYOUT] } else { &[] }].concat();
            let desc = GraphicsDesc { fragment, front_only: drawn.front_only, spec: &spec, structs: &structs, ..*desc };
            sets.push((drawn, PipelineSet::new(gpu, name, &desc, drawn.shape)?));
        }
        Ok(Self(sets))
    }

    /// Binds and draws one object. The pipelines must have been made for the object's kind.
    pub(crate) fn draw(&self, cmd: &mut Commands, drawn: DrawnObject<'_>, mode: PatchMode) {
        let kind = drawn.posed.object.kind;
        let front_only = kind.front_only && mode == PatchMode::Seen { mark_inside: false };
        let wanted = DrawnAs { front_only, ..DrawnAs::both_sides(kind) };
        let found = self.0.iter().find(|(drawn, _)| *drawn == wanted);
        debug_assert!(found.is_some(), "no pipelines draw {wanted:?}");
        if let Some((_, set)) = found {
            set.draw(cmd, drawn);
        }
    }
}

impl PipelineSet {
    fn new(gpu: &Arc<Gpu>, name: &str, desc: &GraphicsDesc<'_>, shape: Shape) -> Result<Self> {
        let quads = |kind: &str, flat: bool, at_texels: bool| {
            let divided = GraphicsDesc {
                vertex: "passes/geometry/geometry.vert",
                tessellation: Some(["passes/geometry/geometry.tesc", "passes/geometry/geometry.tese"]),
                topology: Topology::Patches(4),
                // The tessellator runs along v in the opposite direction.
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
        Ok(Self {
            undivided: GraphicsPipeline::new(gpu, &format!("{name}, undivided"), &undivided)?,
            divided: match shape {
                Shape::Curved => quads("curved", false, false)?,
                Shape::Flat => quads("flat", true, false)?,
                Shape::Triangles => GraphicsPipeline::new(gpu, &format!("{name}, triangles"), &triangles)?,
            },
            at_texels: match shape {
                Shape::Flat => Some(quads("at texels", true, true)?),
                Shape::Curved | Shape::Triangles => None,
            },
        })
    }

    fn draw(&self, cmd: &mut Commands, drawn: DrawnObject<'_>) {
        let DrawnObject { posed, divided, view, records } = drawn;
        let [objects, views] = records.bindings();
        let bindings = [
            ("Vertices", Descriptor::Storage(&divided.buffers.vertices)),
            ("EdgeFactors", Descriptor::Storage(&divided.buffers.edge_factors)),
            ("VisiblePatches", Descriptor::Storage(&view.visible)),
            objects,
            views,
        ];
        let at_texels = self.at_texels.as_ref().filter(|_| divided.at_texels);
        let divided = at_texels.unwrap_or(&self.divided);
        let draws = [(&self.undivided, &view.draws.undivided, 6), (divided, &view.draws.divided, 4)];
        for (pipeline, draws, vertices) in draws.into_iter().filter(|(_, draws, _)| !draws.is_empty()) {
            cmd.bind(pipeline, &bindings);
            cmd.bind_set(&posed.object.set);
            cmd.push_constants(&records.draw(posed));
            for &(first, count) in draws {
                cmd.draw(first * vertices..(first + count) * vertices, 0..1);
            }
        }
    }
}

impl GeometryPass {
    /// Creates the pass for objects of these kinds. Both sides of a surface are drawn, unless the object is front-only. A closed
    /// surface hides its own back faces.
    pub fn new(gpu: &Arc<Gpu>, kind: GeometryKind, objects: &[SurfaceKind], numbering: Numbering) -> Result<Self> {
        let desc = GraphicsDesc {
            fragment: Some("passes/geometry/geometry.frag"),
            colors: &GeometryTargets::FORMATS,
            // Geometry with a single sample per pixel stores no footprint.
            kept_colors: usize::from(matches!(kind, GeometryKind::Pixels | GeometryKind::Wires)),
            depth: Some(Depth::default()),
            samples: kind.samples(),
            wires: kind == GeometryKind::Wires,
            spec: &[kind.pixels(), numbering.spec()],
            ..Default::default()
        };
        let name = match kind {
            GeometryKind::Pixels => "geometry",
            GeometryKind::Multisampled(_) => "multisampled geometry",
            GeometryKind::Edges => "geometry of edges",
            GeometryKind::Wires => "wires",
        };
        // Back faces are drawn if they have to be marked.
        let sides = |kind: &SurfaceKind| {
            let both = DrawnAs::both_sides(*kind);
            [kind.front_only, false].map(|front_only| DrawnAs { front_only, ..both })
        };
        let kinds = objects.iter().flat_map(sides);
        Ok(Self(PatchPipelines::new(gpu, name, &desc, "passes/geometry/geometry_cutout.frag", kinds)?))
    }

    /// Draws objects into the active targets. `mark_inside` paints back faces in a marker colour.
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

/// Sets a viewport that is [`GUARD_BAND`] times as large as the target, and a scissor of the target's size.
pub(crate) fn guard_band(cmd: &mut Commands, target: &Image) {
    let [width, height] = target.mip_extent(0);
    let (w, h) = (width as f32, height as f32);
    let margin = (GUARD_BAND - 1.0) / 2.0;
    cmd.viewport([-margin * w, -margin * h, GUARD_BAND * w, GUARD_BAND * h]);
    cmd.scissor([0, 0, width, height]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn caster_kinds_are_separate() {
        let all: Vec<DrawnAs> = CasterKinds::all().collect();
        assert_eq!(all.len(), 96);
        for (bit, drawn) in all.iter().enumerate() {
            let kind = CasterKinds { present: 1 << bit };
            assert_eq!(kind.iter().collect::<Vec<_>>(), [*drawn]);
            assert!(!all[..bit].contains(drawn) && !kind.is_empty());
        }
        let [first, last] = [0, 95].map(|bit| CasterKinds { present: 1 << bit });
        assert_eq!(first.or(last).iter().collect::<Vec<_>>(), [all[0], all[95]]);
        assert!(CasterKinds::default().is_empty());
    }
}
