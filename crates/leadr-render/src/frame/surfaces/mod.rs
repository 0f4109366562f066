//! The surfaces of a frame: meshes and the sea.

pub(super) mod meshes;
pub(super) mod sea;

use self::meshes::{Meshes, PreparedMeshes};
use self::sea::{PreparedSea, Sea};
use crate::camera::Camera;
use crate::frame::timing::Passes;
use crate::passes::filter::FilterInto;
use crate::passes::geometry::GeometryKind;
use crate::passes::shade::ShadeKind;
use crate::passes::targets::{GeometryTargets, VisibleSurface};
use crate::pixel_area::PixelArea;
use crate::scene::FrameState;
use crate::settings::RenderSettings;
use crate::view::{Samples, View};
use leadr_gpu::{Commands, ResourceSet, Result};

/// The surfaces of a scene on the device, which do not depend on the frame.
pub(super) struct Surfaces {
    pub meshes: Meshes,
    pub sea: Option<Sea>,
}

impl Surfaces {
    /// Poses the surfaces for a frame, in buffers that no other frame uses. Also makes the pipelines of the surfaces.
    pub fn prepare(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        drawing: SurfaceDrawing,
    ) -> Result<PreparedSurfaces> {
        let meshes = self.meshes.prepare(state, settings, drawing)?;
        let sea = self.sea.as_mut().map(|sea| sea.prepare(state, settings, drawing)).transpose()?;
        Ok(PreparedSurfaces { meshes, sea })
    }
}

/// The surfaces of a scene in the pose of a frame.
pub(super) struct PreparedSurfaces {
    pub meshes: PreparedMeshes,
    pub sea: Option<PreparedSea>,
}

impl PreparedSurfaces {
    /// Returns the surfaces in drawing order.
    pub fn drawn(&self) -> impl Iterator<Item = &dyn DrawnSurface> {
        let sea = self.sea.iter().map(|sea| sea as &dyn DrawnSurface);
        std::iter::once(&self.meshes as &dyn DrawnSurface).chain(sea)
    }

    /// Selects the patches and their tessellation for a view. The device must not be drawing this frame.
    pub fn set_view(&mut self, view: &View) -> Result<()> {
        self.meshes.set_view(view)?;
        self.sea.as_mut().map_or(Ok(()), |sea| sea.set_view(view))
    }

    /// Records the animation that runs on the device, before any pass reads it.
    pub fn record_motion(&self, passes: &mut Passes<'_>) {
        if let Some(sea) = &self.sea {
            sea.record_motion(passes);
        }
    }

    /// Returns the pixels that can show the surfaces.
    pub fn area(&self, camera: &Camera, size: (u32, u32)) -> PixelArea {
        match self.sea {
            Some(_) => PixelArea::whole(size),
            None => PixelArea::of_spheres(&self.meshes.bounds(), camera, size),
        }
    }

    /// Returns an upper bound on the triangles of one sample over all views, and the number of patches drawn for the camera.
    pub fn counts(&self) -> (u64, u32) {
        let (triangles, patches) = self.meshes.counts();
        let (of_sea, in_sea) = self.sea.as_ref().map_or((0, 0), PreparedSea::counts);
        (triangles + of_sea, patches + in_sea)
    }

    /// Returns the last tessellation of a patch as the number of segments along u and v.
    pub fn segments(&self, object: u32, patch: u32) -> Option<[f32; 2]> {
        let sea = || self.sea.as_ref().and_then(|sea| sea.segments(object, patch));
        self.meshes.segments(object, patch).or_else(sea)
    }
}

/// A surface with its own geometry and filter passes.
pub(super) trait DrawnSurface {
    /// Returns the names of the surface's passes.
    fn names(&self) -> PassNames;

    /// Draws the geometry into the active render targets.
    fn draw_geometry(&self, cmd: &mut Commands, target: &GeometryTargets, view: &View);

    /// Filters the maps at the pixels of this surface into the active targets. If the filter pass shades, `light` is the descriptor
    /// set of the scene.
    fn draw_filter(&self, cmd: &mut Commands, visible: &VisibleSurface, view: &View, light: Option<&ResourceSet>);
}

/// The options for drawing a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceDrawing {
    /// The number of shadow maps that the surface is drawn into.
    pub shadow_maps: u32,
    /// The number of shadow maps that belong to suns.
    pub sun_maps: u32,
    /// What the geometry pass writes for each pixel.
    pub geometry: GeometryKind,
    /// Whether there are edge samples.
    pub edges: bool,
    /// What the filter pass writes.
    pub filter: FilterInto,
    /// How objects with several classes of facets are shaded if the filter pass writes the G-buffer, which holds one class.
    pub by_class: Option<ShadeKind>,
}

impl SurfaceDrawing {
    /// Calls `make` for each kind of geometry in the frame, and returns the results.
    pub(super) fn geometry<P>(&self, mut make: impl FnMut(GeometryKind) -> Result<P>) -> Result<ForViews<P>> {
        let edges = self.edges.then(|| make(GeometryKind::Edges)).transpose()?;
        Ok(ForViews { pixels: make(self.geometry)?, edges })
    }
}

/// The pipelines for the views of a frame.
pub(super) struct ForViews<P> {
    pixels: P,
    edges: Option<P>,
}

impl<P> ForViews<P> {
    /// Returns the pipelines for these samples.
    pub(super) fn of(&self, samples: Samples) -> &P {
        match samples {
            Samples::Edges { .. } => self.edges.as_ref().unwrap_or(&self.pixels),
            Samples::Pixels | Samples::Multisampled { .. } => &self.pixels,
        }
    }
}

/// Returns the inner tessellation levels of a patch along u and v. The arguments are the levels of the edges v = 0, u = 1, v = 1
/// and u = 0. The same rule is in `geometry.tesc`.
pub(super) fn inner_segments([v0, u1, v1, u0]: [f32; 4]) -> [f32; 2] {
    [v0.max(v1), u1.max(u0)]
}

#[derive(Clone, Copy)]
pub(super) struct PassNames {
    pub geometry: &'static str,
    pub filter: &'static str,
    /// The name of a filter pass that also shades.
    pub filter_and_shade: &'static str,
}
