//! What of an object a view draws.

use std::sync::Arc;

use glam::{Mat4, Vec3};

use super::divided::{DividedObject, VertexGpu};
use super::object::{GpuObject, ObjectGpu, PatchGpu};
use super::posed::PosedObject;
use super::tessellation::{DrawList, Draws, Lens, TessellationSettings, Viewer};
use crate::constants::GUARD_BAND;
use crate::view::View;
use leadr_gpu::{Buffer, Gpu, Result, SharedStruct, StructLayout, shared_struct};

shared_struct! {
    /// The view block (`View`).
    pub struct ViewGpu for "View" {
        /// World to the clip space of a viewport that is [`GUARD_BAND`] times the size of the image.
        pub clip_from_world: [[f32; 4]; 4],
        /// Size of the image, pixels.
        pub size: [f32; 2],
        /// Number of samples of this image along a side of a pixel of the picture.
        pub grid: f32,
        /// [`DividedObject::texel_repeat`].
        pub texel_repeat: f32,
        /// [`Viewpoint::draw`].
        pub draw: f32,
        padding: [u32; 3],
    }
}

/// The structs that the stages of the geometry pass share.
pub const GEOMETRY_STRUCTS: [StructLayout; 4] =
    [ViewGpu::LAYOUT, VertexGpu::LAYOUT, PatchGpu::LAYOUT, ObjectGpu::LAYOUT];

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
}

/// The buffers of a view, large enough for every patch of an object.
pub struct ViewBuffers {
    /// Patches to draw.
    pub visible: Buffer,
    /// The [`ViewGpu`] block.
    pub view: Buffer,
}

impl ViewBuffers {
    /// Buffers for an object.
    pub fn new(gpu: &Arc<Gpu>, object: &GpuObject) -> Result<Self> {
        Ok(Self {
            visible: object.frame_buffer(gpu, "visible patches", object.object.mesh.patches.len(), 4)?,
            view: object.frame_buffer(gpu, "view", 1, size_of::<ViewGpu>())?,
        })
    }
}

/// One object in one view: the camera's, or that of a sun's shadow map.
pub struct ObjectView {
    /// What the device reads.
    pub buffers: Arc<ViewBuffers>,
    /// Draws over the visible patches.
    pub draws: Draws,
    /// Whether a vertex stands at the centre of each texel of the heights.
    pub at_texels: bool,
    /// Upper bound on the triangles of these draws.
    pub triangles: u64,
    /// Number of visible patches.
    pub patches: u32,
}

impl ObjectView {
    /// A view that has not looked yet, in these buffers.
    pub fn new(buffers: Arc<ViewBuffers>) -> Self {
        Self { buffers, draws: Draws::default(), at_texels: false, triangles: 0, patches: 0 }
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
        let shrink = Mat4::from_scale(Vec3::new(1.0 / GUARD_BAND, 1.0 / GUARD_BAND, 1.0));
        let view = ViewGpu {
            clip_from_world: (shrink * from.clip_from_world).to_cols_array_2d(),
            size: [from.size.0 as f32, from.size.1 as f32],
            grid: from.grid as f32,
            texel_repeat: divided.texel_repeat,
            draw: from.draw,
            padding: [0; 3],
        };
        self.buffers.visible.write(0, &list.visible)?;
        self.buffers.view.write(0, &[view])?;
        self.patches = list.visible.len() as u32;
        self.draws = list.draws;
        self.at_texels = divided.texel_repeat > 0.0;
        self.triangles = list.triangles;
        Ok(())
    }
}
