//! Shadows at the resolution of the relief, for the reference. Each light has a depth map of geometry with one vertex per
//! displacement texel. The map shifts by part of a texel from sample to sample, so the errors of its limited resolution average
//! out.

use std::sync::Arc;

use glam::{Vec2, Vec3};
use leadr_gpu::vk;

use super::geometry::{CUTOUT_DEPTH, CasterKinds, PatchMode, PatchPipelines, guard_band};
use super::shadow::ShadowView;
use crate::surfaces::divided::{DividedObject, DivisionBuffers};
use crate::surfaces::object_view::{DrawnObject, ObjectView, Viewpoint};
use crate::surfaces::posed::PosedObject;
use crate::surfaces::records::{Records, ViewRecordGpu, ViewRecords};
use crate::surfaces::sphere::Sphere;
use crate::surfaces::tessellation::{Lens, TessellationSettings};
use leadr_gpu::{Commands, Depth, DepthTarget, Gpu, GraphicsDesc, Image, ImageDesc, ImageView, Result, Use};

/// The number of map texels per relief texel, along one side.
const TEXELS_PER_RELIEF_TEXEL: f32 = 3.0;
/// The smallest and the largest size of a map, in texels.
const MAP_SIZES: [u32; 2] = [256, 4096];

/// The light for which a relief map is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Caster {
    /// A light at infinity, in this unit direction.
    Directional(Vec3),
    /// A light at this position.
    Point(Vec3),
}

/// Returns the view for a map of `size` texels that covers a sphere. The view is shifted by `offset` texels. For a point light,
/// [`ShadowView::texel`] is the size of a texel at distance 1. The map of a point light inside the sphere covers a wide cone
/// towards the centre of the sphere.
pub fn relief_view(caster: Caster, sphere: Sphere, size: u32, offset: Vec2) -> ShadowView {
    match caster {
        Caster::Directional(toward) => {
            let Sphere { centre, radius } = sphere;
            let (x, y) = toward.any_orthonormal_pair();
            let texel = 2.0 * radius / size as f32;
            // A margin of one texel leaves room for the offset.
            let wider = radius + texel;
            let moved = centre + (x * offset.x + y * offset.y) * texel;
            ShadowView::parallel(toward, Sphere { centre: moved, radius: wider }, size)
        }
        Caster::Point(eye) => ShadowView::from_point(eye, sphere, size).moved(offset),
    }
}

/// Returns the number of texels along one side of a map. The map resolves relief texels of `texel` metres on casters within
/// `radius`. An infinite `texel` means that the casters are smooth.
pub fn map_size(radius: f32, texel: f32) -> u32 {
    // For smooth casters, it is enough to resolve the silhouettes.
    let texel = if texel.is_finite() { texel } else { radius / 512.0 };
    let wanted = (TEXELS_PER_RELIEF_TEXEL * 2.0 * radius / texel.max(1e-9)).min(1e6) as u32;
    wanted.clamp(MAP_SIZES[0], MAP_SIZES[1]).next_multiple_of(64)
}

/// The pipelines that draw the maps.
#[derive(Clone)]
pub struct ReliefShadowPass {
    pipelines: PatchPipelines,
}

impl ReliefShadowPass {
    /// Creates the pass for these kinds of casters.
    pub fn new(gpu: &Arc<Gpu>, kinds: CasterKinds) -> Result<Self> {
        let desc = GraphicsDesc { depth: Some(Depth::default()), ..Default::default() };
        Ok(Self { pipelines: PatchPipelines::new(gpu, "relief shadow", &desc, CUTOUT_DEPTH, kinds.iter())? })
    }

    /// Draws the maps with the current views, and leaves them readable. `casters` must be the casters passed to
    /// [`ReliefMaps::new`].
    pub fn record(&self, cmd: &mut Commands, maps: &ReliefMaps, casters: &[&PosedObject]) {
        cmd.image_barrier(&maps.image, Use::Undefined, Use::DepthTarget);
        for ((layer, views), light) in maps.layers.iter().zip(&maps.views).zip(0..) {
            cmd.begin_rendering(&[], Some(DepthTarget { view: layer, clear: Some(0.0) }));
            guard_band(cmd, &maps.image);
            for ((posed, divided), view) in casters.iter().zip(&maps.divided).zip(views) {
                let records = Records { objects: &posed.records, views: &maps.records, view: light };
                self.pipelines.draw(cmd, DrawnObject { posed, divided, view, records }, PatchMode::Caster);
            }
            cmd.end_rendering();
        }
        cmd.transition(&maps.image, Use::Sampled);
    }
}

/// The maps for the lights of a frame.
pub struct ReliefMaps {
    image: Image,
    array: ImageView,
    layers: Vec<ImageView>,
    /// The objects, which are tessellated as for the camera.
    divided: Vec<DividedObject>,
    /// The views of all objects, for each light.
    views: Vec<Vec<ObjectView>>,
    /// The view of each light.
    records: ViewRecords,
}

impl ReliefMaps {
    /// Creates maps of `size`² texels for these casters, with one map for each of the lights.
    pub fn new(gpu: &Arc<Gpu>, casters: &[&PosedObject], size: u32, lights: usize) -> Result<Self> {
        let layers = lights.max(1) as u32;
        let desc = ImageDesc::new(vk::Format::D32_SFLOAT, size, size).depth_target().layers(layers);
        let image = Image::new(gpu, "relief maps", desc)?;
        let divided = |posed: &&PosedObject| {
            DivisionBuffers::new(gpu, &posed.object).map(|buffers| DividedObject::new(Arc::new(buffers)))
        };
        let view = |posed: &&PosedObject| {
            ObjectView::buffer(gpu, &posed.object).map(|buffer| ObjectView::new(Arc::new(buffer)))
        };
        let views = |_| casters.iter().map(view).collect::<Result<_>>();
        Ok(Self {
            array: image.array()?,
            layers: (0..layers).map(|layer| image.mip_layer(0, layer)).collect::<Result<_>>()?,
            divided: casters.iter().map(divided).collect::<Result<_>>()?,
            views: (0..lights).map(views).collect::<Result<_>>()?,
            records: ViewRecords::new(gpu)?,
            image,
        })
    }

    /// Sets the view of each light. `casters` must be the casters passed to `new`. The device must be idle.
    pub fn point(
        &mut self,
        casters: &[&PosedObject],
        views: &[ShadowView],
        lens: Lens,
        tessellation: &TessellationSettings,
    ) -> Result<()> {
        let settings = TessellationSettings { cull: false, ..*tessellation };
        for (divided, posed) in self.divided.iter_mut().zip(casters) {
            divided.divide(posed, lens, &settings)?;
        }
        let from: Vec<Viewpoint> = views.iter().map(|view| view.viewpoint(lens)).collect();
        self.records.write(0, &from.iter().map(ViewRecordGpu::of_light).collect::<Vec<_>>())?;
        for (from, views) in from.iter().zip(&mut self.views) {
            for ((view, divided), posed) in views.iter_mut().zip(&self.divided).zip(casters) {
                view.select(posed, divided, from, &settings)?;
            }
        }
        Ok(())
    }

    /// The maps, one layer per light.
    pub fn array(&self) -> &ImageView {
        &self.array
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_see_the_sphere_and_offsets_move_them_by_texels() {
        let (centre, radius, size) = (Vec3::new(1.0, 2.0, 3.0), 2.0, 512);
        for caster in [
            Caster::Directional(Vec3::new(0.3, -0.4, 0.8).normalize()),
            Caster::Point(Vec3::new(7.0, 1.0, 6.0)),
            Caster::Point(centre + Vec3::X * 20.0),
        ] {
            let view = |offset| relief_view(caster, Sphere { centre, radius }, size, offset);
            let still = view(Vec2::ZERO);
            for axis in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
                let s = still.texture_from_world.project_point3(centre + axis * radius * 0.999);
                assert!(s.min_element() >= 0.0 && s.max_element() <= 1.0, "{caster:?} {axis}: {s}");
            }
            let toward = match caster {
                Caster::Directional(d) => d,
                Caster::Point(p) => (p - centre).normalize(),
            };
            let depth = |v: &ShadowView, p: Vec3| v.texture_from_world.project_point3(p).z;
            assert!(depth(&still, centre + toward) > depth(&still, centre - toward), "nearer is larger");
            let at = |offset| view(offset).texture_from_world.project_point3(centre).truncate() * size as f32;
            let moved = at(Vec2::new(0.5, 0.25)) - at(Vec2::ZERO);
            assert!((moved.abs() - Vec2::new(0.5, 0.25)).abs().max_element() < 0.01, "{caster:?}: {moved}");
            // A step of one texel must move the projected point by one texel.
            let distance = if let Caster::Point(p) = caster { p.distance(centre) } else { 1.0 };
            let side = toward.any_orthonormal_vector() * still.texel * distance;
            let step = still.texture_from_world.project_point3(centre + side)
                - still.texture_from_world.project_point3(centre);
            assert!((step.truncate().length() * size as f32 - 1.0).abs() < 0.02, "{caster:?}");
        }
    }

    #[test]
    fn maps_resolve_the_relief_within_bounds() {
        assert_eq!(map_size(1.0, 0.006), 1024);
        assert_eq!(map_size(1.0, 1.0), 256);
        assert_eq!(map_size(1000.0, 1e-3), 4096);
    }
}
