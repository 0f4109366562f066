//! The meshes of a scene.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::{DrawnSurface, ForViews, PassNames, SurfaceDrawing, inner_segments};
use crate::frame::cache::Cache;
use crate::frame::drawing::Demands;
use crate::frame::pool::Pool;
use crate::passes::edges::edge_tessellation;
use crate::passes::filter::{FilterInto, FilterPass};
use crate::passes::geometry::{CasterKinds, GeometryKind, GeometryPass};
use crate::passes::shade::{Edges, ShadeKind};
use crate::passes::shadow::ShadowView;
use crate::passes::targets::{GeometryTargets, VisibleSurface};
use crate::scene::{FrameState, Object, Pose};
use crate::settings::{Needs, RenderSettings};
use crate::surfaces::budget::Room;
use crate::surfaces::classes::{ClassAtlas, ClassImages, ClassSources, FoundClasses, ObjectClasses, SceneClasses};
use crate::surfaces::displacement::Border;
use crate::surfaces::divided::{DividedObject, DivisionBuffers};
use crate::surfaces::material::Bases;
use crate::surfaces::moments::MomentFormat;
use crate::surfaces::numbering::Numbering;
use crate::surfaces::object::{GpuObject, ObjectMaps, SurfaceKind, Upload, with_same_maps};
use crate::surfaces::object_view::{DrawnObject, ObjectView, Viewpoint};
use crate::surfaces::patch_mesh::PosedVertices;
use crate::surfaces::posed::PosedObject;
use crate::surfaces::records::{ObjectRecordGpu, ObjectRecords, Records, Shown, ViewRecordGpu, ViewRecords};
use crate::surfaces::sphere::Sphere;
use crate::surfaces::tessellation::{Lens, TessellationSettings};
use crate::view::{Samples, View};
use leadr_gpu::{Buffer, Commands, Gpu, ResourceSet, Result};
use leadr_maps::cache::MapCache;

/// The smallest distance between vertices of a shadow caster, in texels of the shadow map.
const CASTER_SPACING: f32 = 4.0;

/// The meshes on the device, and their pipelines.
pub struct Meshes {
    gpu: Arc<Gpu>,
    meshes: Vec<Mesh>,
    pipelines: MeshPipelines,
    records: Pool<ObjectRecords>,
    views: Pool<ViewRecords>,
    /// The maps in which the classes of the objects are found, until a frame needs the classes.
    unfound: Option<Vec<Option<ClassSources<'static>>>>,
    cache: Option<MapCache>,
    format: MomentFormat,
    no_classes: ClassImages,
}

/// The pipelines for the objects of a scene, which are described before the upload.
pub struct MeshPipelines {
    gpu: Arc<Gpu>,
    /// The kinds of all meshes, each with the number of its object.
    kinds: Vec<(usize, SurfaceKind)>,
    /// The kinds for frames that shade by classes of facets, if the classes are known.
    by_class: Option<Vec<SurfaceKind>>,
    casters: CasterKinds,
    numbering: Numbering,
    geometry: Cache<GeometryKind, GeometryPass>,
    filters: Cache<(Needs, [bool; 3], FilterInto), FilterPass>,
}

impl MeshPipelines {
    /// Describes the pipelines for these objects without making any.
    pub fn of(gpu: &Arc<Gpu>, objects: &[Object], numbering: Numbering) -> Self {
        let (mut kinds, mut casters) = (Vec::new(), CasterKinds::default());
        for (number, object) in objects.iter().enumerate() {
            for mesh in std::iter::once(&object.mesh).chain(&object.coarse_mesh) {
                let kind = SurfaceKind::of(object, mesh);
                kinds.push((number, kind));
                if object.casts_shadow {
                    casters = casters.or(CasterKinds::of(kind));
                }
            }
        }
        let (geometry, filters) = (Cache::default(), Cache::default());
        Self { gpu: gpu.clone(), kinds, by_class: None, casters, numbering, geometry, filters }
    }

    /// Describes the pipelines for objects with these classes. Frames then shade by classes.
    pub fn add_classes(&mut self, found: &FoundClasses) {
        self.by_class = Some(self.kinds_of(found));
    }

    fn kinds_of(&self, found: &FoundClasses) -> Vec<SurfaceKind> {
        let kind = |&(number, kind): &(usize, SurfaceKind)| {
            found[number].as_ref().map_or(kind, |classes| kind.with_classes(classes))
        };
        self.kinds.iter().map(kind).collect()
    }

    /// Whether frames with these settings shade by classes.
    fn shades_classes(&self, settings: &RenderSettings) -> bool {
        settings.shading.has_classes() && self.by_class.is_some()
    }

    /// Returns the kinds of all meshes in frames with these settings.
    fn kinds(&self, state: &FrameState, settings: &RenderSettings) -> Vec<SurfaceKind> {
        let plain = self.kinds.iter().map(|(_, kind)| *kind);
        match &self.by_class {
            Some(kinds) if settings.shading.has_classes() => {
                kinds.iter().zip(plain).map(|(kind, plain)| kind.at_height(state.height_scale, plain)).collect()
            }
            _ => plain.collect(),
        }
    }

    /// Returns the shading features that the objects require.
    pub fn demands(&self, state: &FrameState, settings: &RenderSettings) -> Demands {
        let kinds = self.kinds(state, settings);
        let any = |is: fn(&SurfaceKind) -> bool| kinds.iter().any(is);
        Demands {
            relief: state.height_scale != 0.0 && any(|kind| kind.horizon),
            casters: !self.casters.is_empty(),
            bases: kinds.iter().fold(Bases::default(), |all, kind| all.and(kind.features.bases)),
        }
    }

    /// Returns the kinds of surfaces that cast shadows.
    pub fn casters(&self) -> CasterKinds {
        self.casters
    }

    /// Makes the pipelines of a frame.
    pub fn prepare(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        drawing: SurfaceDrawing,
    ) -> Result<MeshPasses> {
        let (kinds, shades_classes) = (self.kinds(state, settings), self.shades_classes(settings));
        let Self { gpu, geometry, filters, numbering, .. } = self;
        let numbering = *numbering;
        let (needs, filter) = (settings.shading.needs(), drawing.filter);
        let relief_drawn = settings.geometry_scale(state.height_scale) != 0.0;
        let mut filter_pass = |filter, kinds: &[SurfaceKind]| {
            filters.get((needs, [shades_classes, state.height_scale == 0.0, relief_drawn], filter), || {
                FilterPass::new(gpu, needs, relief_drawn, filter, kinds.iter().copied(), numbering)
            })
        };
        let geometry =
            drawing.geometry(|kind| geometry.get(kind, || GeometryPass::new(gpu, kind, &kinds, numbering)))?;
        let filter = filter_pass(filter, &kinds)?;
        let with_classes: Vec<_> = kinds.into_iter().filter(|kind| kind.has_classes()).collect();
        let shading = |kind: ShadeKind| {
            let mut pass = |edges| filter_pass(FilterInto::Radiance(ShadeKind { edges, ..kind }), &with_classes);
            let edges = drawing.edges.then(|| pass(Edges::Shaded)).transpose()?;
            Ok(ForViews { pixels: pass(Edges::None)?, edges })
        };
        Ok(MeshPasses { geometry, filter, by_class: drawing.by_class.map(shading).transpose()? })
    }
}

/// The passes of the meshes in a frame.
pub struct MeshPasses {
    geometry: ForViews<GeometryPass>,
    filter: FilterPass,
    /// The passes that filter and shade objects with several classes of facets, if the other filter pass writes the G-buffer.
    by_class: Option<ForViews<FilterPass>>,
}

struct Mesh {
    /// The number of the object in the scene. Instances share it.
    number: usize,
    fine: DetailLevel,
    coarse: Option<DetailLevel>,
}

struct DetailLevel {
    object: Arc<GpuObject>,
    /// Whether the mesh is closed, so that its front faces hide its back faces from every viewpoint.
    closed: bool,
    divisions: Pool<DivisionBuffers>,
    /// The buffers of the patches that the camera and the lights draw.
    views: Pool<Buffer>,
}

impl DetailLevel {
    fn new(object: GpuObject) -> Self {
        let closed = object.topology.irregular_edges() == 0;
        Self { object: Arc::new(object), closed, divisions: Pool::default(), views: Pool::default() }
    }

    /// Returns the same object with its own buffers for the frames.
    fn again(&self) -> Self {
        Self { object: self.object.clone(), closed: self.closed, divisions: Pool::default(), views: Pool::default() }
    }

    /// Prepares the object in a pose, with buffers for a frame that has this many lights with shadow maps.
    fn prepare(&mut self, gpu: &Arc<Gpu>, posed: PosedObject, lights: usize) -> Result<PreparedMesh> {
        let Self { object, closed, divisions, views } = self;
        let mut division = || divisions.take(|| DivisionBuffers::new(gpu, object));
        let mut view = || views.take(|| ObjectView::buffer(gpu, object)).map(ObjectView::new);
        Ok(PreparedMesh {
            posed,
            closed: *closed,
            divided: DividedObject::new(division()?),
            camera: view()?,
            caster: None,
            caster_buffers: if lights > 0 { Some(division()?) } else { None },
            lights: (0..lights).map(|_| view()).collect::<Result<_>>()?,
        })
    }
}

impl Mesh {
    /// Uploads an object. `maps` are the maps that it shares with another object, if any.
    fn new(
        gpu: &Arc<Gpu>,
        (number, object): (usize, Object),
        upload: Upload<'_>,
        maps: Option<Arc<ObjectMaps>>,
    ) -> Result<Self> {
        let (fine, coarse) = GpuObject::upload(gpu, object, upload, maps)?;
        Ok(Self { number, fine: DetailLevel::new(fine), coarse: coarse.map(DetailLevel::new) })
    }

    /// Returns one mesh for each instance of the object.
    fn instances(self) -> impl Iterator<Item = Self> {
        let count = self.fine.object.object.instances;
        let number = self.number;
        let again =
            move |_| Self { number, fine: self.fine.again(), coarse: self.coarse.as_ref().map(DetailLevel::again) };
        (0..count).map(again)
    }

    /// Uploads the classes of the object.
    fn add_classes(&self, gpu: &Arc<Gpu>, classes: ObjectClasses, none: &ClassImages) -> Result<()> {
        let objects = std::iter::once(&self.fine).chain(&self.coarse).map(|level| &level.object);
        let kinds: Vec<_> = objects.clone().map(|object| object.kind.with_classes(&classes)).collect();
        let GpuObject { object, topology, .. } = &*self.fine.object;
        let atlas = match object.heights.as_ref().map(|field| field.border) {
            Some(Border::Tiles(layout)) => Some(ClassAtlas { mesh: &object.mesh, topology, layout }),
            _ => None,
        };
        let images = ClassImages::new(gpu, &object.name, classes, atlas, none)?;
        objects.zip(kinds).try_for_each(|(object, kind)| object.add_classes(gpu, kind, images.clone()))
    }

    /// Returns the level of detail that the camera needs, with its posed vertices. `edges` is whether there are edge samples.
    fn posed(
        &mut self,
        pose: &Pose,
        lens: &Lens,
        tessellation: &TessellationSettings,
        edges: bool,
    ) -> (&mut DetailLevel, PosedVertices) {
        let Self { fine, coarse, .. } = self;
        if let Some(level) = coarse {
            let vertices = pose.apply(&level.object.object.mesh);
            let nearest = vertices.positions.iter().map(|p| p.distance(lens.eye)).fold(f32::INFINITY, f32::min);
            let pixels = |side: f32, distance: f32| side * lens.focal_pixels / distance.max(lens.near);
            let suffices = if level.object.kind.displaced {
                let side = level.object.object.mesh.mean_edge();
                // A point inside a patch may be nearer than the patch's corners.
                !edges && tessellation.is_sufficient_for(pixels(side, nearest - side))
            } else {
                pixels(fine.object.object.mesh.mean_edge(), nearest) < 1.0
            };
            if suffices {
                return (level, vertices);
            }
        }
        let vertices = pose.apply(&fine.object.object.mesh);
        (fine, vertices)
    }
}

impl Meshes {
    /// Uploads the objects of `pipelines` and their classes. At the same time, another thread runs `meanwhile` on the pipelines.
    ///
    /// # Errors
    /// Returns an error if memory is short, and the errors of `meanwhile`.
    pub fn new(
        mut pipelines: MeshPipelines,
        objects: Vec<Object>,
        classes: SceneClasses,
        upload: Upload<'_>,
        meanwhile: impl FnOnce(&mut MeshPipelines) -> Result<()> + Send,
    ) -> Result<Self> {
        let gpu = &pipelines.gpu.clone();
        Room::on(gpu, upload.format).check(&objects)?;
        let (meshes, done) = rayon::join(|| upload_all(gpu, objects, upload), || meanwhile(&mut pipelines));
        done?;
        let (found, unfound) = match classes {
            SceneClasses::Found(found) => (found, None),
            SceneClasses::Unfound(sources) => (Vec::new(), Some(sources)),
        };
        let meshes = Self {
            meshes: meshes?,
            pipelines,
            records: Pool::default(),
            views: Pool::default(),
            unfound,
            cache: upload.cache.cloned(),
            format: upload.format,
            no_classes: upload.none.classes.clone(),
            gpu: gpu.clone(),
        };
        meshes.upload_classes(found)?;
        Ok(meshes)
    }

    /// Finds and uploads the classes of the objects, unless they are known.
    ///
    /// # Errors
    /// Returns an error if memory is short. Frames then show one class.
    pub fn find_classes(&mut self) -> Result<()> {
        let Some(sources) = self.unfound.take() else { return Ok(()) };
        let found = SceneClasses::find(sources, self.cache.as_ref());
        let kinds = self.pipelines.kinds_of(&found);
        self.upload_classes(found)?;
        self.pipelines.by_class = Some(kinds);
        Ok(())
    }

    fn upload_classes(&self, mut found: FoundClasses) -> Result<()> {
        let classes = self.meshes.iter().filter_map(|mesh| Some((mesh, found.get_mut(mesh.number)?.take()?)));
        let classes: Vec<(&Mesh, ObjectClasses)> = classes.collect();
        let named: Vec<_> = classes.iter().map(|(mesh, of)| (mesh.fine.object.object.name.as_str(), of)).collect();
        Room::on(&self.gpu, self.format).check_classes(&named)?;
        classes.into_par_iter().try_for_each(|(mesh, classes)| mesh.add_classes(&self.gpu, classes, &self.no_classes))
    }
}

/// Uploads objects in parallel. Objects with their own maps come first, followed by objects that share maps.
fn upload_all(gpu: &Arc<Gpu>, objects: Vec<Object>, upload: Upload<'_>) -> Result<Vec<Mesh>> {
    let same = with_same_maps(&objects);
    let (own, shared): (Vec<_>, Vec<_>) =
        objects.into_iter().enumerate().partition(|&(index, _)| same[index].is_none());
    let mesh = |object: (usize, Object), maps| Ok((object.0, Mesh::new(gpu, object, upload, maps)?));
    let mut meshes: BTreeMap<usize, Mesh> =
        own.into_par_iter().map(|object| mesh(object, None)).collect::<Result<_>>()?;
    let with_maps = |object: (usize, Object)| {
        let maps = same[object.0].map(|earlier| meshes[&earlier].fine.object.maps.clone());
        mesh(object, maps)
    };
    let others: Vec<_> = shared.into_par_iter().map(with_maps).collect::<Result<_>>()?;
    meshes.extend(others);
    Ok(meshes.into_values().flat_map(Mesh::instances).collect())
}

impl Meshes {
    /// Returns the shading features that the meshes require.
    pub fn demands(&self, state: &FrameState, settings: &RenderSettings) -> Demands {
        self.pipelines.demands(state, settings)
    }

    /// Poses the meshes for a frame, in buffers that no other frame uses. Also makes the pipelines of the meshes.
    pub(super) fn prepare(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        drawing: SurfaceDrawing,
    ) -> Result<PreparedMeshes> {
        let passes = self.pipelines.prepare(state, settings, drawing)?;
        let lens = state.camera.lens(settings.size.1);
        let shades_classes = self.pipelines.shades_classes(settings);
        let Self { gpu, records, views, .. } = self;
        let objects = self.meshes.len();
        let records = records.take(|| ObjectRecords::new(gpu, objects))?;
        let shown =
            Shown { height_scale: state.height_scale, mark_inside: settings.mark_inside, eye: state.camera.position };
        let (mut meshes, mut written) = (Vec::new(), Vec::new());
        for (number, (mesh, pose)) in (1u32..).zip(self.meshes.iter_mut().zip(&state.poses)) {
            let (level, vertices) = mesh.posed(pose, &lens, &settings.tessellation, drawing.edges);
            let lights = if level.object.object.casts_shadow { drawing.shadow_maps as usize } else { 0 };
            let height_scale = settings.geometry_scale(state.height_scale);
            let object = level.object.clone();
            let shades_classes = shades_classes
                && object.by_class().is_some_and(|of| of.kind.at_height(state.height_scale, object.kind).has_classes());
            let posed =
                PosedObject { object, number, vertices, height_scale, records: records.clone(), shades_classes };
            written.push(ObjectRecordGpu::new(&posed, &shown));
            meshes.push(level.prepare(gpu, posed, lights)?);
        }
        records.write(&written)?;
        Ok(PreparedMeshes {
            meshes,
            views: views.take(|| ViewRecords::new(gpu))?,
            passes,
            tessellation: settings.tessellation,
            mark_inside: settings.mark_inside,
        })
    }
}

/// The posed meshes of a frame.
pub(in crate::frame) struct PreparedMeshes {
    meshes: Vec<PreparedMesh>,
    passes: MeshPasses,
    tessellation: TessellationSettings,
    mark_inside: bool,
    /// The record of the camera's view, followed by the records of the lights' views.
    views: Arc<ViewRecords>,
}

struct PreparedMesh {
    posed: PosedObject,
    closed: bool,
    divided: DividedObject,
    camera: ObjectView,
    /// The coarser shadow caster, if it differs from the mesh that is drawn.
    caster: Option<DividedObject>,
    caster_buffers: Option<Arc<DivisionBuffers>>,
    lights: Vec<ObjectView>,
}

impl PreparedMesh {
    fn seen<'a>(&'a self, views: &'a ViewRecords) -> DrawnObject<'a> {
        let records = Records { objects: &self.posed.records, views, view: 0 };
        DrawnObject { posed: &self.posed, divided: &self.divided, view: &self.camera, records }
    }

    fn cast(&mut self, lights: &[ShadowView], lens: Lens, tessellation: TessellationSettings) -> Result<()> {
        let Self { posed, closed, divided, caster, caster_buffers, lights: views, .. } = self;
        let Some(buffers) = caster_buffers else { return Ok(()) };
        // Culling is safe only on closed surfaces, whose back faces are hidden.
        let settings = TessellationSettings { cull: tessellation.cull && *closed, ..tessellation };
        divided.divide(posed, lens, &settings)?;
        let spacing = CASTER_SPACING * lights.iter().map(|light| light.texel_at_centre).fold(f32::INFINITY, f32::min);
        *caster = divided.with_min_spacing(spacing, posed, buffers)?;
        let drawn = caster.as_ref().unwrap_or(divided);
        for (view, light) in views.iter_mut().zip(lights) {
            view.select(posed, drawn, &light.viewpoint(lens), &settings)?;
        }
        Ok(())
    }

    fn cast_under<'a>(&'a self, views: &'a ViewRecords, light: usize) -> Option<DrawnObject<'a>> {
        let records = Records { objects: &self.posed.records, views, view: light as u32 + 1 };
        let divided = self.caster.as_ref().unwrap_or(&self.divided);
        Some(DrawnObject { posed: &self.posed, divided, view: self.lights.get(light)?, records })
    }
}

impl PreparedMeshes {
    /// Selects the patches for the shadow maps, which are tessellated as for the camera's lens. The device must not be drawing this
    /// frame.
    pub fn cast(&mut self, lights: &[ShadowView], lens: Lens) -> Result<()> {
        let views: Vec<_> = lights.iter().map(|light| ViewRecordGpu::of_light(&light.viewpoint(lens))).collect();
        self.views.write(1, &views)?;
        self.meshes.iter_mut().try_for_each(|mesh| mesh.cast(lights, lens, self.tessellation))
    }

    /// Returns the meshes that cast shadows.
    pub fn casters(&self) -> Vec<&PosedObject> {
        self.meshes.iter().map(|mesh| &mesh.posed).filter(|posed| posed.object.object.casts_shadow).collect()
    }

    /// Returns the shadow casters that were last selected for a light.
    pub fn casters_under(&self, light: usize) -> Vec<DrawnObject<'_>> {
        self.meshes.iter().filter_map(|mesh| mesh.cast_under(&self.views, light)).collect()
    }

    /// Selects the patches and their tessellation for a view. The device must not be drawing this frame.
    pub fn set_view(&mut self, view: &View) -> Result<()> {
        let from = Viewpoint::from(view);
        self.views.write(0, &[ViewRecordGpu::of_camera(view)])?;
        for PreparedMesh { posed, divided, camera, .. } in &mut self.meshes {
            let tessellation = match view.samples {
                Samples::Pixels | Samples::Multisampled { .. } => self.tessellation,
                // Bumps form the silhouettes, but the tessellation for whole pixels leaves out small bumps.
                Samples::Edges { .. } => edge_tessellation(self.tessellation, posed.bounds(), &from.lens),
            };
            divided.divide(posed, from.lens, &tessellation)?;
            camera.select(posed, divided, &from, &tessellation)?;
        }
        Ok(())
    }

    /// Returns the bounding spheres of the meshes.
    pub fn bounds(&self) -> Vec<Sphere> {
        self.meshes.iter().map(|mesh| mesh.posed.bounds()).collect()
    }

    /// Returns an upper bound on the triangles of one sample over all views, and the number of patches drawn for the camera.
    pub fn counts(&self) -> (u64, u32) {
        let views = self.meshes.iter().flat_map(|mesh| mesh.lights.iter().chain([&mesh.camera]));
        (views.map(|view| view.triangles).sum(), self.meshes.iter().map(|mesh| mesh.camera.patches).sum())
    }

    /// Returns the last tessellation of a patch as the number of segments along u and v. Returns `None` for objects that are not
    /// meshes.
    pub fn segments(&self, object: u32, patch: u32) -> Option<[f32; 2]> {
        let mesh = self.meshes.get((object as usize).checked_sub(1)?)?;
        let edges = mesh.posed.object.topology.patch_edges.get(patch as usize)?;
        let factors = edges.map(|edge| mesh.divided.division.edge_factors[(edge >> 1) as usize]);
        if mesh.posed.object.kind.triangles {
            // A triangle patch has no third edge (`triangle.tesc`).
            let [a, b, _, c] = factors;
            return Some([a.max(b).max(c); 2]);
        }
        Some(inner_segments(factors))
    }
}

impl DrawnSurface for PreparedMeshes {
    fn names(&self) -> PassNames {
        PassNames { geometry: "geometry", filter: "filter", filter_and_shade: "filter and shade" }
    }

    fn draw_geometry(&self, cmd: &mut Commands, target: &GeometryTargets, view: &View) {
        let drawn = self.meshes.iter().map(|mesh| mesh.seen(&self.views));
        self.passes.geometry.of(view.samples).draw(cmd, target, drawn, self.mark_inside);
    }

    fn draw_filter(&self, cmd: &mut Commands, visible: &VisibleSurface, view: &View, light: Option<&ResourceSet>) {
        // Edge samples of objects with several classes are only shaded.
        let of_edges = matches!(view.samples, Samples::Edges { .. }) && self.shades_classes();
        let is_needed = |posed: &PosedObject| !of_edges || !posed.has_classes();
        let seen = self.meshes.iter().filter(|mesh| mesh.camera.patches > 0 && is_needed(&mesh.posed));
        let drawn = seen.map(|mesh| mesh.seen(&self.views));
        self.passes.filter.draw(cmd, visible, view, drawn, light);
    }
}

impl PreparedMeshes {
    /// Whether objects with several classes of facets are shaded apart from the G-buffer.
    pub fn shades_classes(&self) -> bool {
        self.passes.by_class.is_some()
    }

    /// Returns a bit for each object that [`draw_by_class`](Self::draw_by_class) shades. Objects whose numbers are 64 apart share a bit,
    /// which is set if all of them are shaded so.
    pub fn objects_by_class(&self) -> [u32; 2] {
        let mut by_class = [0u64; 2];
        for PreparedMesh { posed, .. } in &self.meshes {
            let of_class = self.shades_classes() && posed.has_classes();
            by_class[usize::from(of_class)] |= 1 << (posed.number % 64);
        }
        // The last bit belongs to the sea, too.
        let bits = by_class[1] & !by_class[0] & !(1 << 63);
        [bits as u32, (bits >> 32) as u32]
    }

    /// Filters and shades the objects with several classes of facets into the active radiance target, in frames with a G-buffer.
    pub fn draw_by_class(&self, cmd: &mut Commands, visible: &VisibleSurface, view: &View, scene: &ResourceSet) {
        let Some(passes) = &self.passes.by_class else { return };
        let seen = self.meshes.iter().filter(|mesh| mesh.camera.patches > 0 && mesh.posed.has_classes());
        let drawn = seen.map(|mesh| mesh.seen(&self.views));
        passes.of(view.samples).draw(cmd, visible, view, drawn, Some(scene));
    }
}
