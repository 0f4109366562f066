//! The shadow pass, which draws the depth of the displaced scene seen from each light.

use std::sync::Arc;

use glam::{Mat4, Vec2, Vec3, Vec4};
use leadr_gpu::vk;

use super::geometry::{CUTOUT_DEPTH, CasterKinds, PatchMode, PatchPipelines, guard_band};
use crate::surfaces::object_view::{DrawnObject, Viewpoint};
use crate::surfaces::sphere::Sphere;
use crate::surfaces::tessellation::{Lens, Viewer};
use leadr_gpu::{Commands, Depth, DepthTarget, Gpu, GraphicsDesc, Image, ImageDesc, ImageView, Result, Use};

/// The widest half angle, in radians, of the view of a point light among the casters. Directions outside the view count as lit.
const WIDEST: f32 = 1.3;

const TEXTURE_FROM_CLIP: Mat4 = Mat4::from_cols(
    Vec4::new(0.5, 0.0, 0.0, 0.0),
    Vec4::new(0.0, 0.5, 0.0, 0.0),
    Vec4::new(0.0, 0.0, 1.0, 0.0),
    Vec4::new(0.5, 0.5, 0.0, 1.0),
);

/// The view of a shadow map.
#[derive(Clone, Copy, Debug)]
pub struct ShadowView {
    /// The matrix from world to clip space, where depth is 1 nearest to the light. The projection is orthographic for suns, and
    /// perspective for point lights.
    pub clip_from_world: Mat4,
    /// The matrix from world space to texture coordinates (xy) and depth (z).
    pub texture_from_world: Mat4,
    /// The number of texels along one side of the map.
    pub size: u32,
    /// The world size of a texel. For point lights, it is the size at distance 1.
    pub texel: f32,
    /// The world size of a texel at the centre of the sphere that the map covers.
    pub texel_at_centre: f32,
    /// The distance from a point light at which depth is 1, or 0 for orthographic views.
    pub near: f32,
    /// The position or direction of the light.
    pub viewer: Viewer,
}

impl ShadowView {
    /// Returns the view of a sphere from a sun in the unit direction `sun`, for a map of `size` texels. The centre of the sphere
    /// snaps to the texel grid, so that the shadows of moving objects do not crawl.
    pub fn around(sun: Vec3, sphere: Sphere, size: u32) -> Self {
        let Sphere { centre, radius } = sphere;
        let (x, y) = sun.any_orthonormal_pair();
        let texel = 2.0 * radius / size as f32;
        let off_grid = |v: f32| (v / texel).round() * texel - v;
        let snapped = centre + x * off_grid(centre.dot(x)) + y * off_grid(centre.dot(y));
        Self::parallel(sun, Sphere { centre: snapped, radius }, size)
    }

    /// Like [`around`](Self::around), but without snapping.
    pub fn parallel(sun: Vec3, sphere: Sphere, size: u32) -> Self {
        let Sphere { centre, radius } = sphere;
        let (x, y) = sun.any_orthonormal_pair();
        let texel = 2.0 * radius / size as f32;
        let (cx, cy, cz) = (centre.dot(x), centre.dot(y), centre.dot(sun));
        // Depth runs from 0 (far from the sun) to 1.
        let row = |axis: Vec3, scale: f32, offset: f32| (axis * scale).extend(offset);
        let clip_from_world = Mat4::from_cols(
            row(x, 1.0 / radius, -cx / radius),
            row(y, 1.0 / radius, -cy / radius),
            row(sun, 0.5 / radius, 0.5 - 0.5 * cz / radius),
            Vec4::W,
        )
        .transpose();
        Self {
            clip_from_world,
            texture_from_world: TEXTURE_FROM_CLIP * clip_from_world,
            size,
            texel,
            texel_at_centre: texel,
            near: 0.0,
            viewer: Viewer::Toward(sun),
        }
    }

    /// Returns the view of a sphere from a point. From outside, the view contains the whole sphere, so nothing beyond its edges is
    /// in shadow. From inside, it covers a wide cone towards the centre, and all points outside the cone count as lit.
    pub fn from_point(eye: Vec3, sphere: Sphere, size: u32) -> Self {
        let Sphere { centre, radius } = sphere;
        let distance = eye.distance(centre);
        let half = if distance > radius { (radius / distance).asin().min(WIDEST) } else { WIDEST };
        let half = (half + 2.0 / size as f32).min(WIDEST);
        let near = (0.9 * (distance - radius)).max(1e-3 * radius);
        let forward = (centre - eye).normalize_or(Vec3::NEG_Z);
        let clip_from_world = glam::camera::rh::proj::vulkan::perspective_infinite_reverse(2.0 * half, 1.0, near)
            * glam::camera::rh::view::look_to_mat4(eye, forward, forward.any_orthonormal_vector());
        let texel = 2.0 * half.tan() / size as f32;
        Self {
            clip_from_world,
            texture_from_world: TEXTURE_FROM_CLIP * clip_from_world,
            size,
            texel,
            texel_at_centre: texel * distance.max(0.5 * radius),
            near,
            viewer: Viewer::At(eye),
        }
    }

    /// Returns the same view, shifted by this many texels.
    #[must_use]
    pub fn moved(self, texels: Vec2) -> Self {
        let clip_from_world =
            Mat4::from_translation((texels * (2.0 / self.size as f32)).extend(0.0)) * self.clip_from_world;
        Self { clip_from_world, texture_from_world: TEXTURE_FROM_CLIP * clip_from_world, ..self }
    }

    /// Returns the viewpoint that draws casters with the tessellation for the camera's `lens`.
    pub fn viewpoint(&self, lens: Lens) -> Viewpoint {
        Viewpoint {
            clip_from_world: self.clip_from_world,
            viewer: self.viewer,
            lens,
            size: (self.size, self.size),
            draw: 0.0,
        }
    }
}

/// Returns the number of texels along one side of the shadow maps, which is twice the longer side of the picture, from 1024 to
/// 2048. Small pictures do not show finer shadows, and smaller maps are faster to draw and sample.
pub fn map_size((width, height): (u32, u32)) -> u32 {
    width.max(height).saturating_mul(2).clamp(1024, 2048).next_power_of_two()
}

/// The shadow pass, with its pipelines and the maps that were made so far.
pub struct ShadowPass {
    pipelines: PatchPipelines,
    maps: Vec<ShadowMaps>,
}

/// The reversed depth from each light, where larger values are nearer. Clones share the images.
#[derive(Clone)]
pub struct ShadowMaps {
    image: Image,
    array: ImageView,
    layers: Vec<ImageView>,
}

impl ShadowMaps {
    fn new(gpu: &Arc<Gpu>, size: u32, count: u32) -> Result<Self> {
        let desc = ImageDesc::new(vk::Format::D32_SFLOAT, size, size).depth_target().layers(count);
        let image = Image::new(gpu, "shadow maps", desc)?;
        let layers = (0..count).map(|layer| image.mip_layer(0, layer)).collect::<Result<_>>()?;
        Ok(Self { array: image.array()?, layers, image })
    }

    /// Returns an array view with one layer per light.
    pub fn array(&self) -> &ImageView {
        &self.array
    }
}

impl ShadowPass {
    /// Creates the pass for these kinds of casters.
    pub fn new(gpu: &Arc<Gpu>, kinds: CasterKinds) -> Result<Self> {
        let desc =
            GraphicsDesc { depth: Some(Depth { bias: Some([-2.0, -2.0]), ..Depth::default() }), ..Default::default() };
        let pipelines = PatchPipelines::new(gpu, "shadow", &desc, CUTOUT_DEPTH, kinds.iter())?;
        Ok(Self { pipelines, maps: Vec::new() })
    }

    /// Returns maps of `size`² texels for this number of lights. Frames share the maps. Without lights, the map is a single unused
    /// texel.
    pub fn maps(&mut self, gpu: &Arc<Gpu>, size: u32, lights: u32) -> Result<ShadowMaps> {
        let (size, layers) = if lights == 0 { (1, 1) } else { (size, lights) };
        let kept = |maps: &&ShadowMaps| maps.image.desc().width == size && maps.image.desc().layers >= layers;
        if let Some(maps) = self.maps.iter().find(kept) {
            return Ok(maps.clone());
        }
        self.maps.retain(|maps| maps.image.desc().width != size);
        let maps = ShadowMaps::new(gpu, size, layers)?;
        self.maps.push(maps.clone());
        Ok(maps)
    }

    /// Draws the casters of each light and leaves the maps readable.
    pub fn record<'a, C: Iterator<Item = DrawnObject<'a>>>(
        &self,
        cmd: &mut Commands,
        maps: &ShadowMaps,
        lights: impl Iterator<Item = C>,
    ) {
        let ShadowMaps { image, layers, .. } = maps;
        cmd.image_barrier(image, Use::Undefined, Use::DepthTarget);
        for (layer, casters) in layers.iter().zip(lights) {
            cmd.begin_rendering(&[], Some(DepthTarget { view: layer, clear: Some(0.0) }));
            guard_band(cmd, image);
            for caster in casters {
                self.pipelines.draw(cmd, caster, PatchMode::Caster);
            }
            cmd.end_rendering();
        }
        cmd.transition(image, Use::Sampled);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_suit_the_picture() {
        let sizes = [(1, 1), (480, 270), (512, 512), (270, 640), (4096, 2160), (u32::MAX, 1)];
        assert_eq!(sizes.map(map_size), [1024, 1024, 1024, 2048, 2048, 2048]);
    }

    #[test]
    fn point_shadow_depths_match_distances() {
        let sphere = Sphere { centre: Vec3::new(1.0, 2.0, 3.0), radius: 2.0 };
        let eye = Vec3::new(5.0, -1.0, 7.0);
        let view = ShadowView::from_point(eye, sphere, 512);
        let forward = (sphere.centre - eye).normalize();
        for away in [-1.9, 0.0, 1.9] {
            let p = sphere.centre + forward * away;
            let s = view.texture_from_world.project_point3(p);
            assert!((s.truncate() - 0.5).length() < 1e-4);
            assert!((view.near / s.z - p.distance(eye)).abs() < 1e-3, "{s}");
        }
        // A view from inside the sphere still covers the points ahead.
        let inside = ShadowView::from_point(sphere.centre + Vec3::Z, sphere, 512);
        let s = inside.texture_from_world.project_point3(sphere.centre - Vec3::Z + Vec3::X);
        assert!(s.min_element() > 0.0 && s.max_element() < 1.0, "{s}");
    }

    #[test]
    fn the_sphere_fills_the_map_and_the_sunward_side_is_nearest() {
        let sun = Vec3::new(0.3, -0.5, 0.8).normalize();
        let centre = Vec3::new(3.0, 1.0, 2.0);
        let view = ShadowView::around(sun, Sphere { centre, radius: 5.0 }, 1000);
        let at = |p: Vec3| view.texture_from_world.project_point3(p);
        assert!((at(centre) - Vec3::splat(0.5)).length() < 2e-3);
        assert!((at(centre + sun * 5.0).z - 1.0).abs() < 1e-5);
        assert!(at(centre - sun * 5.0).z.abs() < 1e-5);
        let side = sun.any_orthonormal_vector();
        assert!((at(centre + side * 4.9) - at(centre)).truncate().length() < 0.5);
    }
}
