//! The visible patches of an object in a view.

use std::sync::Arc;

use glam::Mat4;

use super::detail::{DetailHeadGpu, RestVertexGpu};
use super::divided::{DividedObject, VertexGpu};
use super::object::{GpuObject, PatchGpu};
use super::posed::PosedObject;
use super::records::{DrawGpu, ObjectRecordGpu, Records, ViewRecordGpu};
use super::tessellation::{DrawList, Draws, Lens, TessellationSettings, Viewer};
use crate::view::View;
use leadr_gpu::{Buffer, Gpu, Result, SharedStruct, StructLayout};

/// The structs that the stages of the geometry pass share.
pub const GEOMETRY_STRUCTS: [StructLayout; 7] = [
    ViewRecordGpu::LAYOUT,
    VertexGpu::LAYOUT,
    PatchGpu::LAYOUT,
    ObjectRecordGpu::LAYOUT,
    DrawGpu::LAYOUT,
    DetailHeadGpu::LAYOUT,
    RestVertexGpu::LAYOUT,
];

/// The viewpoint from which a surface is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// The transform from world to clip space.
    pub clip_from_world: Mat4,
    /// The position of the viewer. Patches that face away from the viewer are culled.
    pub viewer: Viewer,
    /// The camera's lens, even if the viewpoint is a light.
    pub lens: Lens,
    /// The width and height of the image, in samples.
    pub size: (u32, u32),
    /// A number from 0 to 1 that differs between the samples of a pixel. The number selects the samples that hit surfaces with
    /// partial coverage.
    pub draw: f32,
}

impl From<&View> for Viewpoint {
    fn from(view: &View) -> Self {
        let viewer = Viewer::At(view.camera.position);
        Self {
            clip_from_world: view.clip_from_world(),
            viewer,
            lens: view.lens(),
            size: view.size(),
            // Sample offsets are uniform in the pixel. This combination of x and y is also uniform, and nearly independent of x and
            // of y.
            draw: (3.0 * view.offset.x + 5.0 * view.offset.y).rem_euclid(1.0),
        }
    }
}

/// What a geometry pipeline needs to draw an object.
#[derive(Clone, Copy)]
pub struct DrawnObject<'a> {
    /// The posed object.
    pub posed: &'a PosedObject,
    /// The tessellation of the object.
    pub divided: &'a DividedObject,
    /// The visible patches of the object.
    pub view: &'a ObjectView,
    /// The records of objects and views.
    pub records: Records<'a>,
}

/// The patches of one object that are visible to the camera or in a shadow map.
pub struct ObjectView {
    /// The indices of the visible patches. The buffer has room for every patch of the object.
    pub visible: Arc<Buffer>,
    /// The draws, which are ranges of the visible patches.
    pub draws: Draws,
    /// The upper bound on the number of triangles drawn.
    pub triangles: u64,
    /// The number of visible patches.
    pub patches: u32,
}

impl ObjectView {
    /// Creates a view without patches. `visible` is the buffer for the visible patches.
    pub fn new(visible: Arc<Buffer>) -> Self {
        Self { visible, draws: Draws::default(), triangles: 0, patches: 0 }
    }

    /// Creates a buffer for the visible patches of an object.
    pub fn buffer(gpu: &Arc<Gpu>, object: &GpuObject) -> Result<Buffer> {
        object.frame_buffer(gpu, "visible patches", object.object.mesh.patches.len(), 4)
    }

    /// Selects the visible patches of a tessellated object, and writes them to the buffer. The device must not be reading the
    /// buffer.
    pub fn select(
        &mut self,
        posed: &PosedObject,
        divided: &DividedObject,
        from: &Viewpoint,
        settings: &TessellationSettings,
    ) -> Result<()> {
        let factors = &divided.division.edge_factors;
        let list = DrawList::new(posed.mesh(), factors, from.clip_from_world, from.viewer, settings);
        self.visible.write(0, &list.visible)?;
        self.patches = list.visible.len() as u32;
        self.draws = list.draws;
        self.triangles = list.triangles;
        Ok(())
    }
}
