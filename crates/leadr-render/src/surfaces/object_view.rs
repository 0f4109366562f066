//! What of an object a view draws.

use std::sync::Arc;

use glam::Mat4;

use super::divided::{DividedObject, VertexGpu};
use super::object::{GpuObject, PatchGpu};
use super::posed::PosedObject;
use super::records::{DrawGpu, ObjectRecordGpu, Records, ViewRecordGpu};
use super::tessellation::{DrawList, Draws, Lens, TessellationSettings, Viewer};
use crate::view::View;
use leadr_gpu::{Buffer, Gpu, Result, SharedStruct, StructLayout};

/// The structs that the stages of the geometry pass share.
pub const GEOMETRY_STRUCTS: [StructLayout; 5] =
    [ViewRecordGpu::LAYOUT, VertexGpu::LAYOUT, PatchGpu::LAYOUT, ObjectRecordGpu::LAYOUT, DrawGpu::LAYOUT];

/// The place from which a surface is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Viewpoint {
    /// World to clip space.
    pub clip_from_world: Mat4,
    /// Where it is looked from: patches that face away are not drawn.
    pub viewer: Viewer,
    /// The camera's lens, also when a light's map is drawn.
    pub lens: Lens,
    /// Number of samples along a side of a pixel in which the lens measures.
    pub grid: u32,
    /// Samples across and down the image.
    pub size: (u32, u32),
    /// A number from 0 to 1, another for every sample of the picture, that decides which samples see surfaces with holes.
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
            // Offsets of samples are even in the pixel; this sum of theirs is as even, and has little to do with either.
            draw: (3.0 * view.offset.x + 5.0 * view.offset.y).rem_euclid(1.0),
        }
    }
}

/// An object as a geometry pipeline draws it.
#[derive(Clone, Copy)]
pub struct DrawnObject<'a> {
    /// The object.
    pub posed: &'a PosedObject,
    /// How finely it is divided.
    pub divided: &'a DividedObject,
    /// What of it is drawn.
    pub view: &'a ObjectView,
    /// The records of objects and views.
    pub records: Records<'a>,
}

/// One object in one view: the camera's, or that of a sun's shadow map.
pub struct ObjectView {
    /// Patches to draw, with room for every patch of the object.
    pub visible: Arc<Buffer>,
    /// Draws over the visible patches.
    pub draws: Draws,
    /// Upper bound on the triangles of these draws.
    pub triangles: u64,
    /// Number of visible patches.
    pub patches: u32,
}

impl ObjectView {
    /// A view that has not looked yet, whose patches fit this buffer.
    pub fn new(visible: Arc<Buffer>) -> Self {
        Self { visible, draws: Draws::default(), triangles: 0, patches: 0 }
    }

    /// A buffer for the patches of an object.
    pub fn buffer(gpu: &Arc<Gpu>, object: &GpuObject) -> Result<Buffer> {
        object.frame_buffer(gpu, "visible patches", object.object.mesh.patches.len(), 4)
    }

    /// Chooses what is drawn of a divided object, and writes the buffers. The device must not be reading them.
    pub fn look(
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
