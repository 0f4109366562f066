//! The kinds of surfaces that a frame is made of: meshes, and the sea.

pub(super) mod meshes;
pub(super) mod sea;

use crate::frame::timing::Passes;
use crate::passes::edges::MAX_GRID;
use crate::passes::filter::FilterInto;
use crate::passes::geometry::GeometryKind;
use crate::passes::shadow::ShadowView;
use crate::passes::targets::{GeometryTargets, VisibleSurface};
use crate::scene::FrameState;
use crate::settings::RenderSettings;
use crate::surfaces::material::Bases;
use crate::surfaces::object_view::DrawnObject;
use crate::surfaces::posed::PosedObject;
use crate::surfaces::sphere::Sphere;
use crate::surfaces::tessellation::Lens;
use crate::view::{Samples, View};
use leadr_gpu::{Commands, ResourceSet, Result};

/// A kind of surface on the device, as it is whatever the frame.
pub(super) trait Surface {
    /// Whether it moves by itself as time goes on, whatever its poses.
    fn moves(&self) -> bool {
        false
    }

    /// Whether its bumps hide the surroundings from each other.
    fn has_relief(&self, _state: &FrameState) -> bool {
        false
    }

    /// What its bases are.
    fn bases(&self) -> Bases {
        Bases::default()
    }

    /// Whether its colours follow its relief.
    fn has_relief_color(&self) -> bool {
        false
    }

    /// Poses it for a frame, in buffers that no other frame holds, and makes the pipelines that draw it.
    fn prepare(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        drawing: SurfaceDrawing,
    ) -> Result<Box<dyn PreparedSurface>>;
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

/// A kind of surface in the pose of a frame.
pub(super) trait PreparedSurface {
    /// Names of its passes.
    fn names(&self) -> PassNames;

    /// Where it can be seen.
    fn extent(&self) -> Extent;

    /// The finest grid of edge samples that it can be drawn with, 1 to [`MAX_GRID`] along a side of a pixel.
    fn finest_grid(&self) -> u32 {
        MAX_GRID
    }

    /// Whether its horizon lies below eye level, so that the sky has to go on below it.
    fn lowers_horizon(&self) -> bool {
        false
    }

    /// Chooses what is drawn into the lights' shadow maps, divided for the camera's lens. The device must not be drawing this frame.
    fn cast(&mut self, _lights: &[ShadowView], _lens: Lens) -> Result<()> {
        Ok(())
    }

    /// What of it throws shadows.
    fn casters(&self) -> Vec<&PosedObject> {
        Vec::new()
    }

    /// The same, as last chosen for one of the lights.
    fn casters_under(&self, _light: usize) -> Vec<DrawnObject<'_>> {
        Vec::new()
    }

    /// Chooses what is drawn of it in a view, and how finely. The device must not be drawing this frame.
    fn look(&mut self, view: &View) -> Result<()>;

    /// Moves what moves by itself on the device, before anything looks at it.
    fn record_motion(&self, _passes: &mut Passes<'_>) {}

    /// Draws its geometry into the begun targets.
    fn draw_geometry(&self, cmd: &mut Commands, target: &GeometryTargets, view: &View);

    /// Filters its maps under the pixels that see it into the begun targets. `light`: the set of the scene, where the filter pass shades.
    fn draw_filter(&self, cmd: &mut Commands, visible: &VisibleSurface, view: &View, light: Option<&ResourceSet>);

    /// Upper bound on the triangles of one sample, all views together.
    fn triangles(&self) -> u64;

    /// Patches drawn for the camera.
    fn patches(&self) -> u32;

    /// Into how many segments a patch was last divided along u and v; `None` for objects of other surfaces.
    fn segments(&self, object: u32, patch: u32) -> Option<[f32; 2]>;
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

/// Where a surface can be seen.
pub(super) enum Extent {
    /// From the feet to the horizon.
    Everywhere,
    /// Inside these spheres.
    Spheres(Vec<Sphere>),
}
