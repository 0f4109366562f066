//! Shadows as fine as the relief, for the reference: one depth map per light, of geometry with a vertex for every texel of
//! the displacement, moved by a part of a texel from sample to sample so that what a map's texels hide averages out.

use std::sync::Arc;

use ash::vk;
use glam::{Mat4, Vec2, Vec3};

use super::geometry::{draw_object, guard_band};
use super::shadow::ShadowView;
use crate::gpu::{
    Commands, Depth, DepthTarget, Gpu, GraphicsDesc, GraphicsPipeline, Image, ImageDesc, ImageView, Result, Topology,
    Use,
};
use crate::render::surfaces::object::{GEOMETRY_STRUCTS, GpuObject, ViewBuffers};
use crate::render::surfaces::patch_mesh::PosedVertices;
use crate::render::surfaces::tessellation::{Lens, TessellationSettings};

/// Texels of a map for each texel of the relief, along a side.
const TEXELS_PER_RELIEF_TEXEL: f32 = 3.0;
/// Bounds on the size of a map.
const MAP_SIZES: [u32; 2] = [256, 4096];
/// Half the opening of a point light's map when its light is among the casters, radians: what lies outside is lit.
const WIDEST: f32 = 1.3;

/// What a relief map looks from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Caster {
    /// Far away in this unit direction.
    Directional(Vec3),
    /// At this place.
    Point(Vec3),
}

/// The view of a map of `size` texels that sees a sphere, moved by `offset` texels. [`ShadowView::texel`] of a point light's
/// is the size at distance 1. A point light inside the sphere sees a wide cone about its centre.
#[must_use]
pub fn relief_view(caster: Caster, centre: Vec3, radius: f32, size: u32, offset: Vec2) -> ShadowView {
    match caster {
        Caster::Directional(toward) => {
            let (x, y) = toward.any_orthonormal_pair();
            let texel = 2.0 * radius / size as f32;
            // One texel of room for the offset.
            let wider = radius + texel;
            ShadowView::parallel(toward, centre + (x * offset.x + y * offset.y) * texel, wider, size)
        }
        Caster::Point(eye) => {
            let distance = eye.distance(centre);
            let half = if distance > radius { (radius / distance).asin().min(WIDEST) } else { WIDEST };
            let half = (half + 2.0 / size as f32).min(WIDEST);
            let near = (0.9 * (distance - radius)).max(1e-3 * radius);
            let forward = (centre - eye).normalize_or(Vec3::X);
            let clip = Mat4::from_translation((offset * (2.0 / size as f32)).extend(0.0))
                * glam::camera::rh::proj::vulkan::perspective_infinite_reverse(2.0 * half, 1.0, near)
                * glam::camera::rh::view::look_to_mat4(eye, forward, forward.any_orthonormal_vector());
            let to_texture =
                Mat4::from_translation(Vec3::new(0.5, 0.5, 0.0)) * Mat4::from_scale(Vec3::new(0.5, 0.5, 1.0));
            let focal_pixels = size as f32 / (2.0 * half.tan());
            ShadowView {
                clip_from_world: clip,
                texture_from_world: to_texture * clip,
                texel: focal_pixels.recip(),
                eye,
            }
        }
    }
}

/// Texels along a map that resolves relief texels of `texel` metres on casters within `radius`; an infinite texel means smooth casters.
#[must_use]
pub fn map_size(radius: f32, texel: f32) -> u32 {
    // Smooth casters have outlines only.
    let texel = if texel.is_finite() { texel } else { radius / 512.0 };
    let wanted = (TEXELS_PER_RELIEF_TEXEL * 2.0 * radius / texel.max(1e-9)).min(1e6) as u32;
    wanted.clamp(MAP_SIZES[0], MAP_SIZES[1]).next_multiple_of(64)
}

/// The maps and the pipeline that draws them.
pub struct ReliefShadows {
    gpu: Arc<Gpu>,
    pipeline: GraphicsPipeline,
    maps: Option<Maps>,
}

struct Maps {
    image: Image,
    array: ImageView,
    layers: Vec<ImageView>,
    /// By light, then by object.
    buffers: Vec<Vec<ViewBuffers>>,
}

impl ReliefShadows {
    /// Without maps yet.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let desc = GraphicsDesc {
            vertex: "passes/geometry/geometry.vert",
            tessellation: Some(["passes/geometry/geometry.tesc", "passes/geometry/geometry.tese"]),
            depth: Some(Depth::default()),
            topology: Topology::Patches(4),
            structs: &GEOMETRY_STRUCTS,
            ..Default::default()
        };
        Ok(Self { gpu: gpu.clone(), pipeline: GraphicsPipeline::new(gpu, "relief shadow", &desc)?, maps: None })
    }

    /// Makes room for `lights` maps of `size`² texels and points them at the casters. The device must be idle.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn prepare(
        &mut self,
        casters: &[(&GpuObject, &PosedVertices)],
        views: &[ShadowView],
        size: u32,
        height_scale: f32,
        lens: Lens,
        tessellation: &TessellationSettings,
    ) -> Result<()> {
        let fits =
            |m: &Maps| m.image.desc().width == size && m.layers.len() >= views.len() && m.buffers.len() >= views.len();
        if !self.maps.as_ref().is_some_and(fits) {
            self.maps = None;
            let layers = views.len().max(1) as u32;
            let desc = ImageDesc::new(vk::Format::D32_SFLOAT, size, size).depth_target().layers(layers);
            let image = Image::new(&self.gpu, "relief maps", desc)?;
            let buffers = || {
                casters.iter().map(|(object, _)| ViewBuffers::new(&self.gpu, object, "relief")).collect::<Result<_>>()
            };
            self.maps = Some(Maps {
                array: image.array()?,
                layers: (0..layers).map(|layer| image.mip_layer(0, layer)).collect::<Result<_>>()?,
                buffers: (0..layers).map(|_| buffers()).collect::<Result<_>>()?,
                image,
            });
        }
        let maps = self.maps.as_mut().expect("made above");
        // Divided as for the camera: any other surface would stand out of what the camera sees.
        let settings = TessellationSettings { cull: false, ..*tessellation };
        for (view, buffers) in views.iter().zip(&mut maps.buffers) {
            for (buffers, (object, posed)) in buffers.iter_mut().zip(casters) {
                let clip = view.clip_from_world;
                buffers.update(object, posed, height_scale, clip, view.eye, lens, &settings, 1)?;
            }
        }
        Ok(())
    }

    /// Draws the first `lights` maps and leaves them readable.
    pub fn record(&self, cmd: &mut Commands, casters: &[&GpuObject], lights: usize, height_scale: f32) {
        let Some(maps) = &self.maps else { return };
        cmd.image_barrier(&maps.image, Use::Undefined, Use::DepthTarget);
        for (layer, buffers) in maps.layers.iter().zip(&maps.buffers).take(lights) {
            cmd.begin_rendering(&[], Some(DepthTarget { view: layer, clear: Some(0.0) }));
            guard_band(cmd, &maps.image);
            for (object, view) in casters.iter().zip(buffers) {
                draw_object(cmd, &self.pipeline, object, view, height_scale, false);
            }
            cmd.end_rendering();
        }
        cmd.transition(&maps.image, Use::Sampled);
    }

    /// The maps by light, once prepared.
    #[must_use]
    pub fn array(&self) -> Option<&ImageView> {
        self.maps.as_ref().map(|maps| &maps.array)
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
            let view = |offset| relief_view(caster, centre, radius, size, offset);
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
            // A texel's size, measured.
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
