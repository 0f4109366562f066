//! Shadow pass: the depth of the displaced scene seen from each sun.

use std::sync::Arc;

use ash::vk;
use glam::{Mat4, Vec3};

use super::geometry::{CasterKinds, DEPTH_OF_HOLES, DrawnAs, PatchMode, PatchPipelines, guard_band};
use crate::gpu::{Commands, Depth, DepthTarget, Gpu, GraphicsDesc, Image, ImageDesc, ImageView, Result, Use};
use crate::render::surfaces::object_view::{DrawnObject, Viewpoint};
use crate::render::surfaces::sphere::Sphere;
use crate::render::surfaces::tessellation::{Lens, Viewer};

/// The view from which the shadow map is drawn.
#[derive(Clone, Copy, Debug)]
pub struct ShadowView {
    /// World to clip space: parallel projection, depth 1 nearest the sun.
    pub clip_from_world: Mat4,
    /// World to texture coordinates (xy) and depth (z).
    pub texture_from_world: Mat4,
    /// Texels along a side of the map.
    pub size: u32,
    /// World size of a texel.
    pub texel: f32,
    /// Where the light is.
    pub viewer: Viewer,
}

impl ShadowView {
    /// A view from the sun, whose unit direction is `sun`, of a sphere in a map of `size` texels. The sphere's centre is
    /// snapped to the texel grid, so that the cast shadows of a moving object do not crawl.
    #[must_use]
    pub fn around(sun: Vec3, sphere: Sphere, size: u32) -> Self {
        let Sphere { centre, radius } = sphere;
        let (x, y) = sun.any_orthonormal_pair();
        let texel = 2.0 * radius / size as f32;
        let off_grid = |v: f32| (v / texel).round() * texel - v;
        let snapped = centre + x * off_grid(centre.dot(x)) + y * off_grid(centre.dot(y));
        Self::parallel(sun, Sphere { centre: snapped, radius }, size)
    }

    /// The same without snapping.
    #[must_use]
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
            glam::Vec4::W,
        )
        .transpose();
        let to_texture = Mat4::from_translation(Vec3::new(0.5, 0.5, 0.0)) * Mat4::from_scale(Vec3::new(0.5, 0.5, 1.0));
        Self {
            clip_from_world,
            texture_from_world: to_texture * clip_from_world,
            size,
            texel,
            viewer: Viewer::Toward(sun),
        }
    }

    /// The viewpoint for casters that are tessellated for the camera's `lens`.
    #[must_use]
    pub fn viewpoint(&self, lens: Lens) -> Viewpoint {
        Viewpoint {
            clip_from_world: self.clip_from_world,
            viewer: self.viewer,
            lens,
            grid: 1,
            size: (self.size, self.size),
            draw: 0.0,
        }
    }
}

/// Texels along a side of the maps for a picture of so many pixels: twice its longer side, from 1024 to 2048. A picture of a few
/// hundred pixels does not show more, and a smaller map is drawn and looked up faster.
#[must_use]
pub fn map_size((width, height): (u32, u32)) -> u32 {
    width.max(height).saturating_mul(2).clamp(1024, 2048).next_power_of_two()
}

/// The pipelines of the pass, and the maps made so far.
pub struct ShadowPass {
    pipelines: PatchPipelines,
    kinds: CasterKinds,
    maps: Vec<ShadowMaps>,
}

/// Depth from each sun, larger is nearer. Clones share the images.
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

    /// An array with a layer per sun.
    #[must_use]
    pub fn array(&self) -> &ImageView {
        &self.array
    }
}

impl ShadowPass {
    /// The pass.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        let kinds = CasterKinds::default();
        Ok(Self { pipelines: Self::pipelines(gpu, kinds)?, kinds, maps: Vec::new() })
    }

    fn pipelines(gpu: &Arc<Gpu>, kinds: CasterKinds) -> Result<PatchPipelines> {
        let desc =
            GraphicsDesc { depth: Some(Depth { bias: Some([-2.0, -2.0]), ..Depth::default() }), ..Default::default() };
        PatchPipelines::new(gpu, "shadow", &desc, DEPTH_OF_HOLES, DrawnAs::casters(kinds))
    }

    /// Makes what draws such casters, unless that was done.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn prepare_casters(&mut self, gpu: &Arc<Gpu>, kinds: CasterKinds) -> Result<()> {
        let all = self.kinds.or(kinds);
        if all != self.kinds {
            (self.pipelines, self.kinds) = (Self::pipelines(gpu, all)?, all);
        }
        Ok(())
    }

    /// Maps of `size`² texels for so many suns, which frames share; without suns a single texel that nothing reads.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn maps(&mut self, gpu: &Arc<Gpu>, size: u32, suns: u32) -> Result<ShadowMaps> {
        let (size, layers) = if suns == 0 { (1, 1) } else { (size, suns) };
        let kept = |maps: &&ShadowMaps| maps.image.desc().width == size && maps.image.desc().layers >= layers;
        if let Some(maps) = self.maps.iter().find(kept) {
            return Ok(maps.clone());
        }
        self.maps.retain(|maps| maps.image.desc().width != size);
        let maps = ShadowMaps::new(gpu, size, layers)?;
        self.maps.push(maps.clone());
        Ok(maps)
    }

    /// Draws the casters of each sun and leaves the maps readable.
    pub fn record<'a, C: Iterator<Item = DrawnObject<'a>>>(
        &self,
        cmd: &mut Commands,
        maps: &ShadowMaps,
        suns: impl Iterator<Item = C>,
    ) {
        let ShadowMaps { image, layers, .. } = maps;
        cmd.image_barrier(image, Use::Undefined, Use::DepthTarget);
        for (layer, casters) in layers.iter().zip(suns) {
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
