//! The sea of a scene.

use std::sync::Arc;

use super::{DrawnSurface, ForViews, PassNames, SurfaceDrawing, inner_segments};
use crate::frame::cache::Cache;
use crate::frame::pool::Pool;
use crate::frame::timing::Passes;
use crate::passes::filter::FilterInto;
use crate::passes::geometry::GeometryKind;
use crate::passes::ocean::fields::{Content, OceanFields};
use crate::passes::ocean::filter::{OceanFilterPass, SeaInputs, WaterGpu};
use crate::passes::ocean::march::{OceanMarch, RaysGpu};
use crate::passes::ocean::surface::{OceanSurfacePass, RingBuffers};
use crate::passes::targets::{GeometryTargets, VisibleSurface};
use crate::scene::FrameState;
use crate::settings::{Needs, RenderSettings};
use crate::surfaces::numbering::Numbering;
use crate::surfaces::object_view::Viewpoint;
use crate::surfaces::ocean::Ocean;
use crate::surfaces::ocean::mesh::{RingLayout, Rings, SeaView};
use crate::surfaces::ocean::shore::ShoreGpu;
use crate::surfaces::tessellation::TessellationSettings;
use crate::view::View;
use leadr_gpu::{Buffer, Commands, Gpu, Memory, ResourceSet, Result};

/// A sea on the device, with its pipelines.
pub struct Sea {
    gpu: Arc<Gpu>,
    water: Water,
    fields: OceanFields,
    buffers: Pool<SeaBuffers>,
    surface: Cache<GeometryKind, OceanSurfacePass>,
    filters: Cache<(Needs, FilterInto), OceanFilterPass>,
    /// Pipelines that march rays through the waves, for the reference.
    march: Cache<(), OceanMarch>,
}

/// Data that stay the same however the sea is drawn. Clones share them.
#[derive(Clone)]
struct Water {
    numbering: Numbering,
    ocean: Arc<Ocean>,
    rings: Arc<Rings>,
    /// The standard deviation of the height of each cascade, in metres.
    deviations: Arc<[f64]>,
}

struct SeaBuffers {
    rings: RingBuffers,
    /// The [`WaterGpu`] block.
    water: Buffer,
    /// The [`ShoreGpu`] block.
    shore: Buffer,
    /// The [`RaysGpu`] block of the reference.
    rays: Buffer,
}

impl SeaBuffers {
    fn new(gpu: &Arc<Gpu>, rings: &Rings) -> Result<Self> {
        let buffer = |name: &str, size: usize| Buffer::new(gpu, name, size as u64, Memory::Upload);
        Ok(Self {
            rings: RingBuffers::new(gpu, rings)?,
            water: buffer("water", size_of::<WaterGpu>())?,
            shore: buffer("shore", size_of::<ShoreGpu>())?,
            rays: buffer("ocean rays", size_of::<RaysGpu>())?,
        })
    }
}

impl Sea {
    /// Uploads a sea.
    ///
    /// # Errors
    /// Returns an error if the waves are invalid, memory is short, or a pipeline fails.
    pub fn new(gpu: &Arc<Gpu>, ocean: Ocean, numbering: Numbering) -> Result<Self> {
        Ok(Self {
            gpu: gpu.clone(),
            fields: OceanFields::new(gpu, &ocean.cascades, Content::Moments)?,
            buffers: Pool::default(),
            surface: Cache::default(),
            filters: Cache::default(),
            march: Cache::default(),
            water: Water {
                numbering,
                deviations: ocean.cascades.iter().map(|c| c.deviations()[0]).collect(),
                ocean: Arc::new(ocean),
                rings: Arc::new(Rings::default()),
            },
        })
    }

    /// Makes the pipelines for frames with these settings.
    pub fn make_pipelines(&mut self, settings: &RenderSettings, drawing: SurfaceDrawing) -> Result<()> {
        self.drawing(settings, drawing).map(|_| ())
    }

    fn drawing(&mut self, settings: &RenderSettings, drawing: SurfaceDrawing) -> Result<Drawing> {
        let (gpu, needs, filter, numbering) =
            (&self.gpu, settings.shading.needs(), drawing.filter, self.water.numbering);
        let Ocean { shore, cascades, .. } = &*self.water.ocean;
        // Ray marching does not support a shore and has no triangles.
        if needs.is_finest() && shore.is_none() && drawing.geometry != GeometryKind::Wires {
            return Ok(Drawing::March(self.march.get((), || OceanMarch::new(gpu, cascades, numbering))?));
        }
        let beach = shore.is_some();
        let filter =
            self.filters.get((needs, filter), || OceanFilterPass::new(gpu, needs, filter, beach, numbering))?;
        let surface =
            drawing.geometry(|kind| self.surface.get(kind, || OceanSurfacePass::new(gpu, kind, beach, numbering)))?;
        Ok(Drawing::Rings { fields: self.fields.clone(), surface, filter })
    }

    /// Poses the sea for a frame and makes its pipelines.
    pub(super) fn prepare(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        drawing: SurfaceDrawing,
    ) -> Result<PreparedSea> {
        let (gpu, drawing) = (self.gpu.clone(), self.drawing(settings, drawing)?);
        Ok(PreparedSea {
            buffers: self.buffers.take(|| SeaBuffers::new(&gpu, &self.water.rings))?,
            water: self.water.clone(),
            drawing,
            time: state.time,
            laid: RingLayout::default(),
            tessellation: settings.tessellation,
        })
    }
}

/// The sea at one moment in time.
pub(in crate::frame) struct PreparedSea {
    water: Water,
    buffers: Arc<SeaBuffers>,
    drawing: Drawing,
    /// The time in seconds.
    time: f64,
    /// The rings of patches around the last viewpoint.
    laid: RingLayout,
    tessellation: TessellationSettings,
}

/// How the sea is drawn.
enum Drawing {
    /// The sea is drawn as rings of patches, and slope moments filter the waves.
    Rings { fields: OceanFields, surface: ForViews<OceanSurfacePass>, filter: OceanFilterPass },
    /// The sea is drawn as a reference, by marching rays through the unfiltered waves.
    March(OceanMarch),
}

impl PreparedSea {
    /// Places the rings around a viewpoint and writes the buffers. The device must not be drawing this frame.
    pub fn set_view(&mut self, view: &View) -> Result<()> {
        let Water { ocean, rings, deviations, .. } = &self.water;
        let buffers = &self.buffers;
        let from = Viewpoint::from(view);
        let Viewpoint { clip_from_world, lens, .. } = from;
        let sea_view = SeaView { clip_from_world, lens, level: ocean.level, deviation: ocean.height };
        self.laid = rings.layout(&sea_view, &self.tessellation);
        match &self.drawing {
            Drawing::Rings { .. } => buffers.rings.update(&self.laid, &from, ocean.level)?,
            Drawing::March(march) => buffers.rays.write(0, &[march.rays(&from, ocean.level)])?,
        }
        buffers.water.write(0, &[WaterGpu::new(ocean, lens.eye.truncate())])?;
        let shore_block = ocean.shore.as_ref().map(|shore| ShoreGpu::new(shore, self.time, deviations));
        buffers.shore.write(0, &[shore_block.unwrap_or_default()])
    }

    /// Records the animation of the waves, before any pass reads them.
    pub fn record_motion(&self, passes: &mut Passes<'_>) {
        let (time, choppiness) = (self.time, self.water.ocean.choppiness);
        let fields = match &self.drawing {
            Drawing::Rings { fields, .. } => fields,
            Drawing::March(march) => march.fields(),
        };
        passes.run("wave rows", |cmd| fields.record_rows(cmd, time));
        passes.run("wave columns", |cmd| fields.record_columns(cmd, choppiness));
        passes.run("wave mips", |cmd| fields.record_mips(cmd));
    }

    /// Returns an upper bound on the number of triangles of one sample, and the number of patches drawn for the camera.
    pub fn counts(&self) -> (u64, u32) {
        (self.laid.list.triangles, self.laid.list.visible.len() as u32)
    }

    /// Returns the last tessellation of a sea patch as the number of segments along u and v, or 0 if the sea is ray-marched.
    pub fn segments(&self, object: u32, patch: u32) -> Option<[f32; 2]> {
        let edges = self
            .water
            .rings
            .topology
            .patch_edges
            .get(patch as usize)
            .filter(|_| object == self.water.numbering.sea())?;
        Some(match self.drawing {
            Drawing::Rings { .. } => inner_segments(edges.map(|edge| self.laid.factors[(edge >> 1) as usize])),
            Drawing::March(_) => [0.0; 2],
        })
    }
}

impl DrawnSurface for PreparedSea {
    fn names(&self) -> PassNames {
        PassNames { geometry: "sea geometry", filter: "sea filter", filter_and_shade: "sea filter and shade" }
    }

    fn draw_geometry(&self, cmd: &mut Commands, target: &GeometryTargets, view: &View) {
        match &self.drawing {
            Drawing::Rings { fields, surface, .. } => {
                let SeaBuffers { rings, shore, .. } = &*self.buffers;
                surface.of(view.samples).draw(cmd, target, rings, &self.laid, fields, shore);
            }
            Drawing::March(march) => march.draw_geometry(cmd, &self.buffers.rays),
        }
    }

    fn draw_filter(&self, cmd: &mut Commands, visible: &VisibleSurface, _: &View, light: Option<&ResourceSet>) {
        let SeaBuffers { water, shore, .. } = &*self.buffers;
        match &self.drawing {
            Drawing::Rings { fields, filter, .. } => {
                filter.draw(cmd, visible, SeaInputs { fields, water, shore }, light)
            }
            Drawing::March(march) => march.draw_filter(cmd, visible, water),
        }
    }
}
