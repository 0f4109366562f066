//! The records of the objects and of the views of a frame. Draws refer to a record by its index.

use std::sync::Arc;

use glam::{Mat4, Vec3};

use super::flat::Chart;
use super::object_view::Viewpoint;
use super::posed::PosedObject;
use crate::constants::{GUARD_BAND, MAX_VIEWS};
use crate::view::{Samples, View};
use leadr_gpu::{Buffer, Descriptor, Gpu, Memory, Result, shared_struct};
use leadr_reflectance::masking::classes::MOST_CLASSES;

shared_struct! {
    /// The record of an object in a frame (`ObjectRecord` in `passes/geometry/object.glsl`).
    pub struct ObjectRecordGpu for "ObjectRecord" {
        /// The linear albedo (rgb) and the Beckmann roughness (a) of plain objects.
        pub color: [f32; 4],
        /// The tangent of flat objects along the texture coordinate s. The component w is 1, or -1 if the tangents run clockwise
        /// seen from outside.
        pub tangent_s: [f32; 4],
        /// The tangent of flat objects along the texture coordinate t. The accessibility of plain objects is in w.
        pub tangent_t: [f32; 4],
        /// The shift [`PosedObject::tiling_shift`], in map repeats.
        pub shift: [f32; 2],
        /// The height scale `η`.
        pub height_scale: f32,
        /// The height scale of the geometry, or 0 to draw it smooth.
        pub displacement: f32,
        /// The height range from the deepest pit to the highest bump, in metres.
        pub relief: f32,
        /// The height of the viewer above the plane of a flat object, in metres.
        pub viewer_above: f32,
        /// The number of metres per map repeat, for a plane that can have vertices on texel centres, and 0 for other objects.
        pub texel_repeat: f32,
        /// The reflectance at normal incidence.
        pub specular_f0: f32,
        /// The `FLAG_` constants that apply, as bits.
        pub flags: u32,
        /// The number of the object in the scene, counted from 1.
        pub number: u32,
        /// The number of the measured material, counted from 1, or 0 without one.
        pub fit: u32,
        /// The edge tint of a conductor, with five bits per channel.
        pub edge_tint: u32,
        /// The weight and the roughness of the clear coat, and 1 if the coat is smooth.
        pub coat: [f32; 4],
        /// The number of the medium, counted from 1, or 0 without one.
        pub medium: u32,
        /// The level of the height scale's map whose texels are as wide as those of the heights.
        pub scale_lod: f32,
        /// The offset of the coordinates in the height scale's map.
        pub scale_offset: [f32; 2],
        /// The columns of the matrix from texture coordinates to coordinates in the height scale's map.
        pub scale_linear: [f32; 4],
        /// For a detail that displaces, the units of the heights per metre.
        pub detail_unit: f32,
        /// The level of the detail whose texels are as wide as those of the heights.
        pub detail_lod: f32,
        /// Padding.
        pub spare: [u32; 2],
        /// The centres of the classes of facets, as slopes per unit of texture coordinate and height, in units of the map.
        pub class_centers: [[f32; 4]; MOST_CLASSES],
        /// The units of the classes' moments about these centres, and the slope variance of the map in these units.
        pub class_unit: [f32; 4],
        /// The correlation of the openness of each class towards different directions: the width, across, and opposite.
        pub class_correlation: [[f32; 4]; MOST_CLASSES],
        /// The optical depth of each class towards the sky.
        pub class_sky_depth: [f32; MOST_CLASSES],
    }
}

shared_struct! {
    /// The record of a view (`ViewRecord`).
    pub struct ViewRecordGpu for "ViewRecord" {
        /// The transform from world space to the clip space of a viewport that is [`GUARD_BAND`] times as large as the image.
        clip_from_world: [[f32; 4]; 4],
        /// The first vector of [`Camera::rays`](crate::camera::Camera::rays). The horizontal step between pixels in ndc is in w.
        ray_x: [f32; 4],
        /// The second vector of the rays. The vertical step between pixels in ndc is in w.
        ray_y: [f32; 4],
        /// The third vector of the rays. The near distance is in w.
        ray_middle: [f32; 4],
        /// The position of the viewer in metres. The value of [`Viewpoint::draw`] is in w.
        eye: [f32; 4],
        /// The size of the image in pixels.
        size: [f32; 2],
        /// The factor on the footprints in the maps.
        widening: f32,
        /// The number of samples along one side of a pixel for images of edge samples, otherwise 0.
        edge_grid: u32,
    }
}

shared_struct! {
    /// The push constants of a draw (`Draw`).
    pub struct DrawGpu for "Draw" {
        /// The index of the object's record.
        object: u32,
        /// The index of the view's record.
        view: u32,
    }
}

/// The parameters of a frame that all objects share.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// The factor for the height scale of every object.
    pub height_scale: f32,
    /// Whether back faces use the marker colour.
    pub mark_inside: bool,
    /// The position of the viewer in metres.
    pub eye: Vec3,
}

impl ObjectRecordGpu {
    /// Creates the record of a posed object.
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
            ..object.record(shown, posed.by_class())
        }
    }
}

impl ViewRecordGpu {
    /// Creates the record for the view of a light.
    pub fn of_light(from: &Viewpoint) -> Self {
        let shrink = Mat4::from_scale(Vec3::new(1.0 / GUARD_BAND, 1.0 / GUARD_BAND, 1.0));
        Self {
            clip_from_world: (shrink * from.clip_from_world).to_cols_array_2d(),
            ray_x: [0.0; 4],
            ray_y: [0.0; 4],
            ray_middle: [0.0; 4],
            eye: [0.0, 0.0, 0.0, from.draw],
            size: [from.size.0 as f32, from.size.1 as f32],
            widening: 1.0,
            edge_grid: 0,
        }
    }

    /// Creates the record for the view of a camera.
    pub fn of_camera(view: &View) -> Self {
        let (from, [x, y, middle], (width, height)) = (Viewpoint::from(view), view.rays(), view.size());
        Self {
            ray_x: x.extend(2.0 / width as f32).to_array(),
            ray_y: y.extend(2.0 / height as f32).to_array(),
            ray_middle: middle.extend(view.camera.near).to_array(),
            eye: view.camera.position.extend(from.draw).to_array(),
            widening: view.lod_bias.exp2(),
            edge_grid: if let Samples::Edges { grid } = view.samples { grid } else { 0 },
            ..Self::of_light(&from)
        }
    }
}

/// The records of the objects of a frame.
pub struct ObjectRecords(Buffer);

impl ObjectRecords {
    /// Creates a buffer for this number of objects.
    pub fn new(gpu: &Arc<Gpu>, objects: usize) -> Result<Self> {
        let bytes = (objects.max(1) * size_of::<ObjectRecordGpu>()) as u64;
        Ok(Self(Buffer::new(gpu, "objects", bytes, Memory::Upload)?))
    }

    /// Writes the records of all objects in scene order. The device must not be reading the buffer.
    pub fn write(&self, records: &[ObjectRecordGpu]) -> Result<()> {
        self.0.write(0, records)
    }
}

/// The records of the views of a frame.
pub struct ViewRecords(Buffer);

impl ViewRecords {
    /// Creates a buffer for all views of a frame.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let bytes = (MAX_VIEWS as usize * size_of::<ViewRecordGpu>()) as u64;
        Ok(Self(Buffer::new(gpu, "views", bytes, Memory::Upload)?))
    }

    /// Writes view records, starting at index `first`. The device must not be reading the buffer.
    pub fn write(&self, first: u32, records: &[ViewRecordGpu]) -> Result<()> {
        self.0.write(u64::from(first) * size_of::<ViewRecordGpu>() as u64, records)
    }
}

/// The records that a draw can read, and the index of its view.
#[derive(Clone, Copy)]
pub struct Records<'a> {
    /// The records of all objects.
    pub objects: &'a ObjectRecords,
    /// The records of all views.
    pub views: &'a ViewRecords,
    /// The index of the view.
    pub view: u32,
}

impl<'a> Records<'a> {
    /// Returns both buffers of records, each with its name in the shaders.
    pub fn bindings(self) -> [(&'static str, Descriptor<'a>); 2] {
        [("Objects", Descriptor::Storage(&self.objects.0)), ("Views", Descriptor::Uniform(&self.views.0))]
    }

    /// Returns the push constants with which this object is drawn.
    pub fn draw(self, posed: &PosedObject) -> DrawGpu {
        DrawGpu { object: posed.number - 1, view: self.view }
    }
}
