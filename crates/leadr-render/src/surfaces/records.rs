//! Records of each object and each view of a frame. Draws refer to them by index.

use std::sync::Arc;

use glam::{Mat4, Vec3};

use super::flat::Chart;
use super::object_view::Viewpoint;
use super::posed::PosedObject;
use crate::constants::{GUARD_BAND, MAX_VIEWS};
use crate::view::{Samples, View};
use leadr_gpu::{Buffer, Descriptor, Gpu, Memory, Result, shared_struct};

shared_struct! {
    /// An object in a frame (`ObjectRecord` in `passes/geometry/object.glsl`).
    pub struct ObjectRecordGpu for "ObjectRecord" {
        /// Plain objects: linear albedo, Beckmann roughness.
        pub color: [f32; 4],
        /// Flat objects: tangents by texture coordinate; w: 1, or -1 if they run clockwise seen from outside.
        pub tangent_s: [f32; 4],
        /// w: accessibility of plain objects.
        pub tangent_t: [f32; 4],
        /// [`PosedObject::tiling_shift`], repeats.
        pub shift: [f32; 2],
        /// Height scale `η`.
        pub height_scale: f32,
        /// Height scale of the geometry, which may be drawn smooth.
        pub displacement: f32,
        /// Height range from the deepest pit to the highest bump, metres.
        pub relief: f32,
        /// Height of the viewer above the plane of a flat object, metres.
        pub viewer_above: f32,
        /// Metres per map repeat, for a plane with vertices on texel centres.
        pub texel_repeat: f32,
        /// Reflectance at normal incidence.
        pub specular_f0: f32,
        /// `FLAG_` bits.
        pub flags: u32,
        /// Object number in the scene, from 1.
        pub number: u32,
        /// Number of the measured material, from 1, or 0.
        pub fit: u32,
        /// The edge tint of a conductor, five bits per channel.
        pub edge_tint: u32,
    }
}

shared_struct! {
    /// A view (`ViewRecord`).
    pub struct ViewRecordGpu for "ViewRecord" {
        /// World to the clip space of a viewport [`GUARD_BAND`] times the size of the image.
        clip_from_world: [[f32; 4]; 4],
        /// [`Camera::rays`](crate::camera::Camera::rays); w: horizontal step from pixel to pixel in ndc.
        ray_x: [f32; 4],
        /// w: vertical step from pixel to pixel in ndc.
        ray_y: [f32; 4],
        /// w: near plane.
        ray_middle: [f32; 4],
        /// Position of the viewer, metres; w: [`Viewpoint::draw`].
        eye: [f32; 4],
        /// Size of the image, pixels.
        size: [f32; 2],
        /// Samples of this image along one side of a pixel of the picture.
        grid: f32,
        /// The same for images of edge samples, otherwise 0.
        edge_grid: u32,
    }
}

shared_struct! {
    /// Push constants of a draw (`Draw`).
    pub struct DrawGpu for "Draw" {
        /// Index of the object's record.
        object: u32,
        /// Index of the view's record.
        view: u32,
    }
}

/// Frame parameters common to all objects.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Factor on the height scale of every object.
    pub height_scale: f32,
    /// Whether back faces use the marker colour.
    pub mark_inside: bool,
    /// Position of the viewer, metres.
    pub eye: Vec3,
}

impl ObjectRecordGpu {
    /// The record of a posed object.
    pub fn new(posed: &PosedObject, shown: &Shown) -> Self {
        let PosedObject { object, number, vertices, height_scale, .. } = posed;
        let mesh = &object.object.mesh;
        let chart = if object.kind.flat { Chart::of(mesh, vertices) } else { None };
        let chart = chart.unwrap_or(Chart { tangent_s: Vec3::X, tangent_t: Vec3::Y, outward: true });
        let side = if chart.outward { 1.0 } else { -1.0 };
        let normal = chart.tangent_s.cross(chart.tangent_t).normalize_or_zero() * side;
        Self {
            number: *number,
            color: mesh.color_of(0),
            tangent_s: chart.tangent_s.extend(side).to_array(),
            tangent_t: chart.tangent_t.extend(mesh.accessibility_of(0)).to_array(),
            shift: posed.tiling_shift(),
            displacement: height_scale * object.object.height_scale,
            viewer_above: vertices.positions.first().map_or(0.0, |&p| normal.dot(shown.eye - p)),
            texel_repeat: mesh.flat_repeat.unwrap_or(0.0),
            ..object.record(shown)
        }
    }
}

impl ViewRecordGpu {
    /// The view of a light.
    pub fn of_light(from: &Viewpoint) -> Self {
        let shrink = Mat4::from_scale(Vec3::new(1.0 / GUARD_BAND, 1.0 / GUARD_BAND, 1.0));
        Self {
            clip_from_world: (shrink * from.clip_from_world).to_cols_array_2d(),
            ray_x: [0.0; 4],
            ray_y: [0.0; 4],
            ray_middle: [0.0; 4],
            eye: [0.0, 0.0, 0.0, from.draw],
            size: [from.size.0 as f32, from.size.1 as f32],
            grid: from.grid as f32,
            edge_grid: 0,
        }
    }

    /// The view of a camera.
    pub fn of_camera(view: &View) -> Self {
        let (from, [x, y, middle], (width, height)) = (Viewpoint::from(view), view.rays(), view.size());
        Self {
            ray_x: x.extend(2.0 / width as f32).to_array(),
            ray_y: y.extend(2.0 / height as f32).to_array(),
            ray_middle: middle.extend(view.camera.near).to_array(),
            eye: view.camera.position.extend(from.draw).to_array(),
            edge_grid: if let Samples::Edges { grid } = view.samples { grid } else { 0 },
            ..Self::of_light(&from)
        }
    }
}

/// The records of a frame's objects.
pub struct ObjectRecords(Buffer);

impl ObjectRecords {
    /// A buffer for this number of objects.
    pub fn new(gpu: &Arc<Gpu>, objects: usize) -> Result<Self> {
        let bytes = (objects.max(1) * size_of::<ObjectRecordGpu>()) as u64;
        Ok(Self(Buffer::new(gpu, "objects", bytes, Memory::Upload)?))
    }

    /// Writes the records of all objects in scene order. The device must not be reading them.
    pub fn write(&self, records: &[ObjectRecordGpu]) -> Result<()> {
        self.0.write(0, records)
    }
}

/// The records of views.
pub struct ViewRecords(Buffer);

impl ViewRecords {
    /// A buffer for all views of a frame.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let bytes = (MAX_VIEWS as usize * size_of::<ViewRecordGpu>()) as u64;
        Ok(Self(Buffer::new(gpu, "views", bytes, Memory::Upload)?))
    }

    /// Writes views starting at an index. The device must not be reading them.
    pub fn write(&self, first: u32, records: &[ViewRecordGpu]) -> Result<()> {
        self.0.write(u64::from(first) * size_of::<ViewRecordGpu>() as u64, records)
    }
}

/// The records available to a draw, and its view.
#[derive(Clone, Copy)]
pub struct Records<'a> {
    /// Records of all objects.
    pub objects: &'a ObjectRecords,
    /// Records of all views.
    pub views: &'a ViewRecords,
    /// Index of the view.
    pub view: u32,
}

impl<'a> Records<'a> {
    /// The arrays with their shader names.
    pub fn bindings(self) -> [(&'static str, Descriptor<'a>); 2] {
        [("Objects", Descriptor::Storage(&self.objects.0)), ("Views", Descriptor::Uniform(&self.views.0))]
    }

    /// The push constants for drawing this object.
    pub fn draw(self, posed: &PosedObject) -> DrawGpu {
        DrawGpu { object: posed.number - 1, view: self.view }
    }
}
