//! The meshes of a scene.

use std::sync::Arc;

use super::{Extent, ForViews, PassNames, PreparedSurface, Surface, SurfaceDrawing};
use crate::gpu::{Commands, Gpu, GpuError, Result};
use crate::maps::cache::MapCache;
use crate::render::frame::cache::Cache;
use crate::render::frame::pool::Pool;
use crate::render::passes::edges::edge_tessellation;
use crate::render::passes::filter::{FilterInto, FilterPass};
use crate::render::passes::geometry::{GeometryKind, GeometryPass};
use crate::render::passes::shade::ShadeInputs;
use crate::render::passes::shadow::ShadowView;
use crate::render::passes::targets::{GeometryTargets, VisibleSurface};
use crate::render::scene::{FrameState, Object, Pose};
use crate::render::settings::{Needs, RenderSettings};
use crate::render::surfaces::object::{GpuObject, MAX_OBJECTS};
use crate::render::surfaces::divided::{DividedObject, DivisionBuffers};
use crate::render::surfaces::object_view::{DrawnObject, ObjectView, ViewBuffers, Viewpoint};
use crate::render::surfaces::patch_mesh::PosedVertices;
use crate::render::surfaces::posed::PosedObject;
use crate::render::surfaces::tessellation::{Lens, TessellationSettings};
use crate::render::view::{Samples, View};

/// The meshes on the device, and what draws them.
pub struct Meshes {
    gpu: Arc<Gpu>,
    meshes: Vec<Mesh>,
    geometry: Cache<GeometryKind, GeometryPass>,
    filters: Cache<(Needs, bool, FilterInto), FilterPass>,
}

struct Mesh {
    fine: Level,
    /// Mean side of its patches, metres.
    patch: f32,
    coarse: Option<Level>,
}

/// An object in one level of detail.
struct Level {
    object: Arc<GpuObject>,
    /// Whether it is closed, so that what is behind is hidden by what is in front, from wherever it is seen.
    closed: bool,
    divisions: Pool<DivisionBuffers>,
    /// For the camera and for suns.
    views: Pool<ViewBuffers>,
}

impl Level {
    fn new(gpu: &Arc<Gpu>, object: Object, index: usize, cache: Option<&MapCache>) -> Result<Self> {
        let object = Arc::new(GpuObject::new(gpu, object, index, cache)?);
        let closed = object.topology.irregular_edges() == 0;
        Ok(Self { object, closed, divisions: Pool::default(), views: Pool::default() })
    }

    /// Its buffers for a frame: a division, and a view for the camera and each of so many suns.
    fn buffers(&mut self, gpu: &Arc<Gpu>, suns: usize) -> Result<(DividedObject, ObjectView, Vec<ObjectView>)> {
        let Self { object, divisions, views, .. } = self;
        let division = divisions.take(|| DivisionBuffers::new(gpu, object))?;
        let mut view = || views.take(|| ViewBuffers::new(gpu, object)).map(ObjectView::new);
        Ok((DividedObject::new(division), view()?, (0..suns).map(|_| view()).collect::<Result<_>>()?))
    }
}

impl Mesh {
    fn new(gpu: &Arc<Gpu>, mut object: Object, index: usize, cache: Option<&MapCache>) -> Result<Self> {
        let coarse = object.coarse_mesh.take().map(|mesh| Object { mesh, ..object.clone() });
        Ok(Self {
            patch: object.mesh.mean_edge(),
            coarse: coarse.map(|object| Level::new(gpu, object, index, cache)).transpose()?,
            fine: Level::new(gpu, object, index, cache)?,
        })
    }

    /// The level of detail for a camera, and its vertices in a pose.
    fn posed(&mut self, pose: &Pose, lens: &Lens) -> (&mut Level, PosedVertices) {
        let Self { fine, patch, coarse } = self;
        if let Some(level) = coarse {
            let vertices = pose.apply(&level.object.object.mesh);
            let nearest = vertices.positions.iter().map(|p| p.distance(lens.eye)).fold(f32::INFINITY, f32::min);
            if *patch * lens.focal_pixels < nearest.max(lens.near) {
                return (level, vertices);
            }
        }
        let vertices = pose.apply(&fine.object.object.mesh);
        (fine, vertices)
    }
}

impl Meshes {
    /// Uploads objects. `cache` keeps what takes long to find in their maps.
    ///
    /// # Errors
    /// [`GpuError::Usage`] for more than [`MAX_OBJECTS`]; memory that is short; a failed pipeline.
    pub fn new(gpu: &Arc<Gpu>, objects: Vec<Object>, cache: Option<&MapCache>) -> Result<Self> {
        if objects.len() > MAX_OBJECTS {
            let fault = format!("{} objects are more than {MAX_OBJECTS}", objects.len());
            return Err(GpuError::Usage { name: "scene".to_owned(), fault });
        }
        let mesh = |(index, object)| Mesh::new(gpu, object, index, cache);
        Ok(Self {
            meshes: objects.into_iter().enumerate().map(mesh).collect::<Result<_>>()?,
            geometry: Cache::default(),
            filters: Cache::default(),
            gpu: gpu.clone(),
        })
    }
}

impl Surface for Meshes {
    fn has_relief(&self, state: &FrameState) -> bool {
        state.height_scale != 0.0 && self.meshes.iter().any(|mesh| mesh.fine.object.kind.horizon)
    }

    fn casts_shadows(&self) -> bool {
        self.meshes.iter().any(|mesh| mesh.fine.object.object.casts_shadow)
    }

    fn prepare(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        drawing: SurfaceDrawing,
    ) -> Result<Box<dyn PreparedSurface>> {
        let SurfaceDrawing { suns, filter, .. } = drawing;
        let lens = state.camera.lens(settings.size.1);
        let mut meshes = Vec::new();
        for (mesh, pose) in self.meshes.iter_mut().zip(&state.poses) {
            let (level, vertices) = mesh.posed(pose, &lens);
            let suns = if level.object.object.casts_shadow { suns as usize } else { 0 };
            let (divided, camera, suns) = level.buffers(&self.gpu, suns)?;
            meshes.push(PreparedMesh {
                posed: PosedObject {
                    vertices,
                    object: level.object.clone(),
                    height_scale: settings.geometry_scale(state.height_scale),
                },
                closed: level.closed,
                divided,
                camera,
                suns,
            });
        }
        let needs = settings.shading.needs();
        let relief_drawn = settings.geometry_scale(state.height_scale) != 0.0;
        let levels = || self.meshes.iter().flat_map(|mesh| [Some(&mesh.fine), mesh.coarse.as_ref()]).flatten();
        Ok(Box::new(PreparedMeshes {
            meshes,
            geometry: drawing.geometry(|kind| self.geometry.get(kind, || GeometryPass::new(&self.gpu, kind)))?,
            filter: self.filters.get((needs, relief_drawn, filter), || {
                FilterPass::new(&self.gpu, needs, relief_drawn, filter, levels().map(|level| level.object.kind))
            })?,
            tessellation: settings.tessellation,
            height_scale: state.height_scale,
            mark_inside: settings.mark_inside,
        }))
    }
}

/// The meshes in their poses.
struct PreparedMeshes {
    meshes: Vec<PreparedMesh>,
    geometry: ForViews<GeometryPass>,
    filter: FilterPass,
    tessellation: TessellationSettings,
    /// What multiplies the height scale of every object's maps.
    height_scale: f32,
    mark_inside: bool,
}

struct PreparedMesh {
    posed: PosedObject,
    closed: bool,
    divided: DividedObject,
    camera: ObjectView,
    suns: Vec<ObjectView>,
}

impl PreparedMesh {
    fn drawn<'a>(&'a self, view: &'a ObjectView) -> DrawnObject<'a> {
        DrawnObject { posed: &self.posed, divided: &self.divided, view }
    }
}

impl PreparedSurface for PreparedMeshes {
    fn names(&self) -> PassNames {
        PassNames { geometry: "geometry", filter: "filter", filter_and_shade: "filter and shade" }
    }

    fn extent(&self) -> Extent {
        Extent::Spheres(self.meshes.iter().map(|mesh| mesh.posed.bounds()).collect())
    }

    fn cast(&mut self, suns: &[ShadowView], lens: Lens) -> Result<()> {
        for PreparedMesh { posed, closed, divided, suns: views, .. } in &mut self.meshes {
            let settings = TessellationSettings { cull: self.tessellation.cull && *closed, ..self.tessellation };
            for (view, sun) in views.iter_mut().zip(suns) {
                view.look(posed, divided, &sun.viewpoint(lens), &settings)?;
            }
        }
        Ok(())
    }

    fn casters(&self) -> Vec<&PosedObject> {
        self.meshes.iter().map(|mesh| &mesh.posed).filter(|posed| posed.object.object.casts_shadow).collect()
    }

    fn casters_under(&self, sun: usize) -> Vec<DrawnObject<'_>> {
        self.meshes.iter().filter_map(|mesh| mesh.suns.get(sun).map(|view| mesh.drawn(view))).collect()
    }

    fn look(&mut self, view: &View) -> Result<()> {
        let from = Viewpoint::from(view);
        for PreparedMesh { posed, divided, camera, .. } in &mut self.meshes {
            let tessellation = match view.samples {
                Samples::Pixels | Samples::Multisampled { .. } => self.tessellation,
                // Silhouettes consist of bumps, and the geometry of whole pixels leaves out small ones.
                Samples::Edges { .. } => edge_tessellation(self.tessellation, posed.bounds(), &from.lens),
            };
            camera.look(posed, divided, &from, &tessellation)?;
        }
        Ok(())
    }

    fn draw_geometry(&self, cmd: &mut Commands, target: &GeometryTargets, view: &View) {
        let drawn = self.meshes.iter().map(|mesh| mesh.drawn(&mesh.camera));
        self.geometry.of(view.samples).draw(cmd, target, drawn, self.mark_inside);
    }

    fn draw_filter(&self, cmd: &mut Commands, visible: &VisibleSurface, view: &View, light: Option<ShadeInputs<'_>>) {
        let seen = self.meshes.iter().filter(|mesh| mesh.camera.patches > 0);
        let drawn = seen.map(|mesh| mesh.drawn(&mesh.camera));
        self.filter.draw(cmd, visible, view, drawn, self.height_scale, light);
    }

    fn triangles(&self) -> u64 {
        self.meshes.iter().map(|m| m.camera.triangles + m.suns.iter().map(|sun| sun.triangles).sum::<u64>()).sum()
    }

    fn patches(&self) -> u32 {
        self.meshes.iter().map(|mesh| mesh.camera.patches).sum()
    }
}
