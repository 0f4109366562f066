//! What a frame is made of: meshes, and the sea.

pub(super) mod meshes;
pub(super) mod sea;

use self::meshes::{Meshes, PreparedMeshes};
use self::sea::{PreparedSea, Sea};
use crate::camera::Camera;
use crate::frame::timing::Passes;
use crate::passes::filter::FilterInto;
use crate::passes::geometry::GeometryKind;
use crate::passes::targets::{GeometryTargets, VisibleSurface};
use crate::pixel_area::PixelArea;
use crate::scene::FrameState;
use crate::settings::RenderSettings;
use crate::view::{Samples, View};
use leadr_gpu::{Commands, ResourceSet, Result};

/// The surfaces of a scene on the device, as they are whatever the frame.
pub(super) struct Surfaces {
    pub meshes: Meshes,
    pub sea: Option<Sea>,
}

impl Surfaces {
    /// Poses them for a frame, in buffers that no other frame holds, and makes the pipelines that draw them.
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
    /// In the order in which they are drawn.
    pub fn drawn(&self) -> impl Iterator<Item = &dyn DrawnSurface> {
        let sea = self.sea.iter().map(|sea| sea as &dyn DrawnSurface);
        std::iter::once(&self.meshes as &dyn DrawnSurface).chain(sea)
    }

    /// Chooses what is drawn of them in a view, and how finely. The device must not be drawing this frame.
    pub fn look(&mut self, view: &View) -> Result<()> {
        self.meshes.look(view)?;
        self.sea.as_mut().map_or(Ok(()), |sea| sea.look(view))
    }

    /// Moves what moves by itself on the device, before anything looks at it.
    pub fn record_motion(&self, passes: &mut Passes<'_>) {
        if let Some(sea) = &self.sea {
            sea.record_motion(passes);
        }
    }

    /// The pixels that can see them.
    pub fn area(&self, camera: &Camera, size: (u32, u32)) -> PixelArea {
        match self.sea {
            Some(_) => PixelArea::whole(size),
            None => PixelArea::of_spheres(&self.meshes.bounds(), camera, size),
        }
    }

    /// Upper bound on the triangles of one sample, all views together, and patches drawn for the camera.
    pub fn counts(&self) -> (u64, u32) {
        let (triangles, patches) = self.meshes.counts();
        let (of_sea, in_sea) = self.sea.as_ref().map_or((0, 0), PreparedSea::counts);
        (triangles + of_sea, patches + in_sea)
    }

    /// Into how many segments a patch was last divided along u and v.
    pub fn segments(&self, object: u32, patch: u32) -> Option<[f32; 2]> {
        let sea = || self.sea.as_ref().and_then(|sea| sea.segments(object, patch));
        self.meshes.segments(object, patch).or_else(sea)
    }
}

/// Surfaces that geometry and filter passes of their own draw.
pub(super) trait DrawnSurface {
    /// Names of these passes.
    fn names(&self) -> PassNames;

    /// Draws its geometry into the begun targets.
    fn draw_geometry(&self, cmd: &mut Commands, target: &GeometryTargets, view: &View);

    /// Filters its maps under the pixels that see it into the begun targets. `light`: the set of the scene, where the filter pass shades.
    fn draw_filter(&self, cmd: &mut Commands, visible: &VisibleSurface, view: &View, light: Option<&ResourceSet>);
}

/// What of a surface will be drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfaceDrawing {
    /// Lights into whose shadow maps it is drawn.
    pub shadow_maps: u32,
    /// How many of them are suns.
    pub sun_maps: u32,
    /// What its geometry pass writes for the pixels.
    pub geometry: GeometryKind,
    /// Whether there are edge samples too.
    pub edges: bool,
    /// What its filter pass makes.
    pub filter: FilterInto,
}

impl SurfaceDrawing {
    /// What `make` makes for each kind of geometry in the frame.
    pub(super) fn geometry<P>(&self, mut make: impl FnMut(GeometryKind) -> Result<P>) -> Result<ForViews<P>> {
        let edges = self.edges.then(|| make(GeometryKind::Edges)).transpose()?;
        Ok(ForViews { pixels: make(self.geometry)?, edges })
    }
}

/// What draws the geometry of a frame's views.
pub(super) struct ForViews<P> {
    pixels: P,
    edges: Option<P>,
}

impl<P> ForViews<P> {
    /// What draws it as such samples see it.
    pub(super) fn of(&self, samples: Samples) -> &P {
        match samples {
            Samples::Edges { .. } => self.edges.as_ref().unwrap_or(&self.pixels),
            Samples::Pixels | Samples::Multisampled { .. } => &self.pixels,
        }
    }
}

/// What the tessellator divides the inside of a patch into along u and v, where its edges, v = 0, u = 1, v = 1 and u = 0, have these
/// factors: `geometry.tesc`.
pub(super) fn inner_segments([v0, u1, v1, u0]: [f32; 4]) -> [f32; 2] {
    [v0.max(v1), u1.max(u0)]
}

/// Names of a surface's passes.
#[derive(Clone, Copy)]
pub(super) struct PassNames {
    pub geometry: &'static str,
    pub filter: &'static str,
    /// Of a filter pass that shades too.
    pub filter_and_shade: &'static str,
}
