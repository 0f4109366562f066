//! An [`Object`] on the device, and its buffers for one view of it.

use std::sync::Arc;

use ash::vk;
use glam::{Mat4, Vec4};

use super::atlas::AtlasGpu;
use super::displacement::{Border, BoundaryHeights, EDGE_LEVELS, HeightField};
use super::moments::{Edges, HeightSource, LeadrMapGpu, MomentFormat};
use super::patch_mesh::PosedVertices;
use super::tessellation::{DrawList, GUARD_BAND, Lens, PosedMesh, TessellationSettings};
use super::topology::Topology;
use crate::gpu::{
    AddressMode, Buffer, Filter, Gpu, Image, ImageDesc, Memory, Result, Sampler, SharedStruct, StructLayout,
    shared_struct,
};
use crate::render::scene::Object;

shared_struct! {
    /// One vertex as the shaders read it (`Vertex` in `passes/geometry/interface.glsl`).
    pub struct VertexGpu for "Vertex" {
        /// World position; w: ambient accessibility.
        pub position: [f32; 4],
        /// World displacement direction; w: LOD of the boundary heights.
        pub normal: [f32; 4],
        /// Linear albedo; a: Beckmann roughness.
        pub color: [f32; 4],
    }
}

shared_struct! {
    /// One patch as the shaders read it (`PatchData`).
    pub struct PatchGpu for "PatchData" {
        /// Corner vertices.
        pub vertices: [u32; 4],
        /// `edge << 1 | backwards`, sides v=0, u=1, v=1, u=0.
        pub edges: [u32; 4],
        /// Texture coordinates of corners 0 and 1.
        pub texcoord_01: [f32; 4],
        /// Texture coordinates of corners 3 and 2.
        pub texcoord_23: [f32; 4],
        /// Bounds of the taps in texture space.
        pub tile: [f32; 4],
    }
}

/// Most objects in a scene: the G-buffer has six bits for them, the sea and nothing.
pub const MAX_OBJECTS: usize = 62;

shared_struct! {
    /// The view block (`View`).
    pub struct ViewGpu for "View" {
        /// World to the clip space of a viewport [`GUARD_BAND`] times the image.
        pub clip_from_world: [[f32; 4]; 4],
        /// Position of the viewer; w: pixels of this image along one of the picture.
        pub camera_position: [f32; 4],
    }
}

shared_struct! {
    /// Push constants of the geometry stages (`Object`).
    pub struct ObjectGpu for "Object" {
        /// Height scale `η`.
        pub height_scale: f32,
        /// Specular reflectance at normal incidence.
        pub specular_f0: f32,
        /// `FLAG_` bits.
        pub flags: u32,
        /// Index of the object in the scene, from 1.
        pub index: u32,
        /// From the deepest pit to the highest bump, metres.
        pub relief: f32,
    }
}

shared_struct! {
    /// Push constants of the filter pass: the object's ([`ObjectGpu`]), and the rays of the image, which are those of
    /// [`Camera::rays`](crate::render::camera::Camera::rays).
    pub struct FilteredObjectGpu for "Object" {
        height_scale: f32,
        specular_f0: f32,
        flags: u32,
        index: u32,
        relief: f32,
        padding: [u32; 3],
        ray_x: [f32; 4],
        ray_y: [f32; 4],
        /// w: near plane.
        ray_middle: [f32; 4],
    }
}

impl FilteredObjectGpu {
    /// Of an object in an image with these rays.
    #[must_use]
    pub fn new(object: ObjectGpu, [x, y, middle]: [glam::Vec3; 3], near: f32) -> Self {
        let ObjectGpu { height_scale, specular_f0, flags, index, relief } = object;
        let [ray_x, ray_y, ray_middle] = [x.extend(0.0), y.extend(0.0), middle.extend(near)].map(|v| v.to_array());
        Self { height_scale, specular_f0, flags, index, relief, padding: [0; 3], ray_x, ray_y, ray_middle }
    }
}

/// What the stages of the geometry pass share.
pub const GEOMETRY_STRUCTS: [StructLayout; 4] =
    [ViewGpu::LAYOUT, VertexGpu::LAYOUT, PatchGpu::LAYOUT, ObjectGpu::LAYOUT];

/// The object has LEADR maps.
pub const FLAG_DISPLACED: u32 = 1;
/// The object has a colour map.
pub const FLAG_COLOR_MAP: u32 = 2;
/// Back faces are painted in the marker colour.
pub const FLAG_MARK_INSIDE: u32 = 4;
/// Above the flags, in the filter pass: edge samples across a pixel.
pub const FLAGS_GRID_SHIFT: u32 = 8;

/// What of an object stays the same from frame to frame.
pub struct GpuObject {
    /// The object itself; its height texels are dropped once they are on the device.
    pub object: Object,
    /// Edges of its mesh.
    pub topology: Topology,
    height_range: Vec<[f32; 2]>,
    /// Of all heights, before scaling.
    relief: f32,
    edge_texels: Vec<f32>,
    edge_relief: Vec<f32>,
    /// `PatchData` of every patch.
    pub patches: Buffer,
    /// What the filter pass knows of the surface beyond a patch's tile.
    pub atlas: AtlasGpu,
    /// Baked heights of the edges.
    pub edge_heights: Buffer,
    /// Baked heights of the vertices.
    pub vertex_heights: Buffer,
    /// The LEADR maps; a 1×1 placeholder for smooth objects.
    pub maps: LeadrMapGpu,
    /// The colour map; a 1×1 placeholder without one.
    pub color: Image,
    /// Sampler of the maps.
    pub sampler: Sampler,
    flags: u32,
    index: u32,
}

impl GpuObject {
    /// Uploads an object and builds its LEADR maps. `index` counts the objects of a scene from 0, below
    /// [`MAX_OBJECTS`].
    ///
    /// # Errors
    /// Memory or a Vulkan call that failed.
    pub fn new(gpu: &Arc<Gpu>, mut object: Object, index: usize) -> Result<Self> {
        let name = object.name.clone();
        let topology = Topology::new(&object.mesh.patches);
        let mut flags = 0;
        let (boundary, border) = match &object.heights {
            Some(field) => {
                flags |= FLAG_DISPLACED;
                (BoundaryHeights::bake(&object.mesh, &topology, field), field.border)
            }
            None => (
                BoundaryHeights {
                    edges: vec![0.0],
                    vertices: vec![0.0; EDGE_LEVELS],
                    patch_range: Vec::new(),
                    edge_texels: Vec::new(),
                    edge_relief: Vec::new(),
                },
                Border::Clamp,
            ),
        };
        let everywhere = [-1e9, -1e9, 1e9, 1e9];
        let patches: Vec<PatchGpu> = (0..object.mesh.patches.len())
            .map(|i| {
                let t = object.mesh.texcoords.get(i).copied().unwrap_or_default();
                let tile = match (&object.heights, border) {
                    (Some(field), Border::Tiles(layout)) => {
                        let (x, y) = layout.origin(i as u32);
                        let (w, h) = (field.width as f32, field.height as f32);
                        let end = |k: u32| (k + layout.tile) as f32;
                        [x as f32 / w, y as f32 / h, end(x) / w, end(y) / h]
                    }
                    _ => everywhere,
                };
                PatchGpu {
                    vertices: object.mesh.patches[i],
                    edges: topology.patch_edges[i],
                    texcoord_01: [t[0].x, t[0].y, t[1].x, t[1].y],
                    texcoord_23: [t[3].x, t[3].y, t[2].x, t[2].y],
                    tile,
                }
            })
            .collect();
        let maps = leadr_maps(gpu, object.heights.as_ref())?;
        if let Some(field) = &mut object.heights {
            field.texels = Vec::new();
        }
        let color = match object.color_map.take() {
            Some(map) => {
                flags |= FLAG_COLOR_MAP;
                super::color_map::upload(gpu, &name, map, border)?
            }
            None => {
                let image =
                    Image::new(gpu, &format!("{name} no colour map"), ImageDesc::new(vk::Format::R8G8B8A8_SRGB, 1, 1))?;
                image.write(0, 0, &[255u8; 4])?;
                image
            }
        };
        let atlas = match border {
            Border::Tiles(layout) => {
                let colors = (flags & FLAG_COLOR_MAP != 0).then_some(&color);
                AtlasGpu::new(gpu, &name, &object.mesh, &topology, layout, &maps, colors)?
            }
            Border::Wrap | Border::Clamp => AtlasGpu::none(gpu, &name)?,
        };
        let (low, high) =
            boundary.patch_range.iter().fold((0.0f32, 0.0f32), |(low, high), r| (low.min(r[0]), high.max(r[1])));
        let relief = high - low;
        let mode = if border == Border::Wrap { AddressMode::Repeat } else { AddressMode::ClampToEdge };
        Ok(Self {
            patches: Buffer::from_slice(gpu, &format!("{name} patches"), &patches)?,
            atlas,
            edge_heights: Buffer::from_slice(gpu, &format!("{name} edge heights"), &boundary.edges)?,
            vertex_heights: Buffer::from_slice(gpu, &format!("{name} vertex heights"), &boundary.vertices)?,
            relief,
            height_range: boundary.patch_range,
            edge_texels: boundary.edge_texels,
            edge_relief: boundary.edge_relief,
            sampler: Sampler::new(gpu, &format!("{name} sampler"), Filter::Trilinear, mode)?,
            topology,
            object,
            maps,
            color,
            flags,
            index: index as u32 + 1,
        })
    }

    /// Push constants at a height scale that multiplies the object's own.
    #[must_use]
    pub fn constants(&self, height_scale: f32, mark_inside: bool) -> ObjectGpu {
        ObjectGpu {
            height_scale: height_scale * self.object.height_scale,
            specular_f0: self.object.specular_f0,
            flags: self.flags | if mark_inside { FLAG_MARK_INSIDE } else { 0 },
            index: self.index,
            relief: self.relief * (height_scale * self.object.height_scale).abs(),
        }
    }

    /// World length of a texel of the heights, on average; infinite without any.
    #[must_use]
    pub fn texel_length(&self, posed: &PosedVertices) -> f32 {
        let lengths =
            self.topology.edges.iter().map(|e| posed.positions[e[0] as usize].distance(posed.positions[e[1] as usize]));
        let texels: f32 = self.edge_texels.iter().sum();
        if texels > 0.0 { lengths.sum::<f32>() / texels } else { f32::INFINITY }
    }

    /// The bounding sphere of the posed object, bumps included.
    #[must_use]
    pub fn bounds(&self, posed: &PosedVertices, height_scale: f32) -> (glam::Vec3, f32) {
        let (low, high) = posed
            .positions
            .iter()
            .fold((glam::Vec3::INFINITY, glam::Vec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
        let bump = self.height_range.iter().flatten().fold(0.0f32, |a, h| a.max(h.abs()));
        ((low + high) * 0.5, low.distance(high) * 0.5 + bump * (height_scale * self.object.height_scale).abs())
    }
}

/// The LEADR maps of a height field; without one, those of a single zero height that nothing will sample.
fn leadr_maps(gpu: &Arc<Gpu>, field: Option<&HeightField>) -> Result<LeadrMapGpu> {
    let none = HeightField { width: 1, height: 1, texels: vec![0.0], border: Border::Clamp };
    let field = field.unwrap_or(&none);
    let edges = match field.border {
        Border::Wrap => Edges::Wrap(crate::maps::Wrap::Repeat),
        Border::Clamp => Edges::Wrap(crate::maps::Wrap::Clamp),
        Border::Tiles(layout) => Edges::Atlas(layout),
    };
    let source = HeightSource { width: field.width, height: field.height, texels: &field.texels };
    LeadrMapGpu::new(gpu, source, edges, MomentFormat::Float32)
}

/// The buffers of one object in one view (the camera, or the sun's shadow map).
pub struct ViewBuffers {
    /// `Vertex` of every vertex.
    pub vertices: Buffer,
    /// Tessellation factor of every edge.
    pub edge_factors: Buffer,
    /// Patches to draw.
    pub visible: Buffer,
    /// The [`ViewGpu`] block.
    pub view: Buffer,
    /// Draws over `visible`.
    pub draws: Vec<(u32, u32)>,
    /// Bound on the triangles of these draws.
    pub triangles: u64,
    /// Visible patches.
    pub patches: u32,
}

impl ViewBuffers {
    /// Buffers large enough for every patch of the object.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn new(gpu: &Arc<Gpu>, object: &GpuObject, view: &str) -> Result<Self> {
        let name = &object.object.name;
        let buffer = |what: &str, count: usize, size: usize| {
            Buffer::new(gpu, &format!("{name} {view} {what}"), (count.max(1) * size) as u64, Memory::Upload)
        };
        let mesh = &object.object.mesh;
        Ok(Self {
            vertices: buffer("vertices", mesh.positions.len(), size_of::<VertexGpu>())?,
            edge_factors: buffer("edge factors", object.topology.edges.len(), 4)?,
            visible: buffer("visible patches", mesh.patches.len(), 4)?,
            view: buffer("view", 1, size_of::<ViewGpu>())?,
            draws: Vec::new(),
            triangles: 0,
            patches: 0,
        })
    }

    /// Chooses factors, culls, and writes the buffers, for an image with `grid` pixels along one of the lens. The device must
    /// not be reading them.
    ///
    /// # Errors
    /// None in practice; a failed write.
    pub fn update(
        &mut self,
        object: &GpuObject,
        posed: &PosedVertices,
        height_scale: f32,
        clip_from_world: Mat4,
        eye: glam::Vec3,
        lens: Lens,
        settings: &TessellationSettings,
        grid: u32,
    ) -> Result<()> {
        let mesh = &object.object.mesh;
        let posed_mesh = PosedMesh {
            mesh,
            topology: &object.topology,
            positions: &posed.positions,
            normals: &posed.normals,
            edge_texels: &object.edge_texels,
            edge_relief: &object.edge_relief,
            height_range: &object.height_range,
            height_scale: height_scale * object.object.height_scale,
        };
        let list = DrawList::new(posed_mesh, clip_from_world, lens, settings);
        let vertices: Vec<VertexGpu> = (0..mesh.positions.len())
            .map(|i| VertexGpu {
                position: posed.positions[i].extend(mesh.accessibility.get(i).copied().unwrap_or(1.0)).to_array(),
                normal: posed.normals[i].extend(list.vertex_lods[i]).to_array(),
                color: mesh.colors.get(i).copied().unwrap_or([0.5, 0.5, 0.5, 0.5]),
            })
            .collect();
        self.vertices.write(0, &vertices)?;
        self.edge_factors.write(0, &list.edge_factors)?;
        self.visible.write(0, &list.visible)?;
        let shrink = Mat4::from_scale(glam::Vec3::new(1.0 / GUARD_BAND, 1.0 / GUARD_BAND, 1.0));
        let view = ViewGpu {
            clip_from_world: (shrink * clip_from_world).to_cols_array_2d(),
            camera_position: Vec4::from((eye, grid as f32)).to_array(),
        };
        self.view.write(0, &[view])?;
        self.draws = list.draws;
        self.triangles = list.triangles;
        self.patches = list.visible.len() as u32;
        Ok(())
    }
}
