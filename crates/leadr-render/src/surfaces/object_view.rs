//! The drawn part of an object in a view.

use std::sync::Arc;

use glam::Mat4;

use super::divided::{DividedObject, VertexGpu};
use super::object::{GpuObject, PatchGpu};
use super::posed::PosedObject;
use super::records::{DrawGpu, ObjectRecordGpu, Records, ViewRecordGpu};
use super::tessellation::{DrawList, Draws, Lens, TessellationSettings, Viewer};
use crate::view::View;
use leadr_gpu::{Buffer, Gpu, Result, SharedStruct, StructLayout};

/// The structs shared by the stages of the geometry pass.
pub const GEOMETRY_STRUCTS: [StructLayout; 5] =
    [ViewRecordGpu::LAYOUT, VertexGpu::LAYOUT, PatchGpu::LAYOUT, ObjectRecordGpu::LAYOUT, DrawGpu::LAYOUT];

/// The viewpoint for drawing a surface.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// World to clip space.
    pub clip_from_world: Mat4,
    /// The viewer; patches that face away are culled.
    pub viewer: Viewer,
    /// The camera's lens, also for the map of a light.
    pub lens: Lens,
    /// Samples along one side of a pixel of the lens.
    pub grid: u32,
    /// Width and height of the image in samples.
    pub size: (u32, u32),
    /// A number from 0 to 1, different for every sample of the picture. It selects the samples that hit surfaces with partial
    /// coverage.
    pub draw: f32,
}

impl From<&View> for Viewpoint {
    fn from(view: &View) -> Self {
        let viewer = Viewer::At(view.camera.position);
        Self {
            clip_from_world: view.clip_from_world(),
            viewer,
            lens: view.lens(),
            grid: view.grid(),
            size: view.size(),
            // Sample offsets are uniform in the pixel. This combination is also uniform, and nearly independent of both.
            draw: (3.0 * view.offset.x + 5.0 * view.offset.y).rem_euclid(1.0),
        }
    }
}

/// The inputs for drawing an object in a geometry pipeline.
#[derive(Clone, Copy)]
pub struct DrawnObject<'a> {
    /// The object.
    pub posed: &'a PosedObject,
    /// The tessellation.
    pub divided: &'a DividedObject,
    /// The drawn part.
    pub view: &'a ObjectView,
    /// The records of objects and views.
    pub records: Records<'a>,
}

/// One object in one view: the camera's or that of a shadow map.
pub struct ObjectView {
    /// Visible patches, with room for every patch of the object.
    pub visible: Arc<Buffer>,
    /// Draws over the visible patches.
    pub draws: Draws,
    /// Upper bound on the triangles of these draws.
    pub triangles: u64,
    /// Number of visible patches.
    pub patches: u32,
}

impl ObjectView {
    /// A view without patches yet, with the buffer for them.
    pub fn new(visible: Arc<Buffer>) -> Self {
        Self { visible, draws: Draws::default(), triangles: 0, patches: 0 }
    }

    /// A buffer for the patches of an object.
    pub fn buffer(gpu: &Arc<Gpu>, object: &GpuObject) -> Result<Buffer> {
        object.frame_buffer(gpu, "visible patches", object.object.mesh.patches.len(), 4)
    }

    /// Selects the visible patches of a tessellated object and writes the buffers. The device must not be reading them.
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
