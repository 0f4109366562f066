//! Creates renderers of small scenes.

#![allow(dead_code, reason = "each test binary uses its own part")]

use std::sync::Arc;

use glam::DVec3;
use leadr_gpu::Gpu;
use leadr_maps::{RgbImage, procedural};
use leadr_render::frame::Renderer;
use leadr_render::light::environment::Environment;
use leadr_render::light::sky::Sky;
use leadr_render::scene::{Object, Scene};
use leadr_render::surfaces::displacement::HeightField;
use leadr_render::surfaces::ocean::Ocean;
use leadr_scenes::stage::Stage;

/// Creates a renderer of a scene under the default sky, with a cube of `face`² texels per face.
pub fn under_sky(gpu: &Arc<Gpu>, scene: impl Into<Scene>, face: u32) -> Renderer {
    Renderer::new(gpu, scene, Environment::from_sky(gpu, face, &Sky::default()).unwrap()).unwrap()
}

/// Creates a renderer of objects in an environment of constant radiance.
pub fn in_room(gpu: &Arc<Gpu>, objects: Vec<Object>, radiance: [f32; 3]) -> Renderer {
    let image = RgbImage::new(8, 4, vec![radiance; 32]).unwrap();
    Renderer::new(gpu, objects, Environment::from_equirect(gpu, 16, &image).unwrap()).unwrap()
}

/// Creates a renderer of a stage's sea and objects under the default sky. The function moves the objects out of the stage.
pub fn stage_under_sky(gpu: &Arc<Gpu>, stage: &mut Stage, face: u32) -> Renderer {
    under_sky(gpu, stage.take_scene(), face)
}

/// Creates a renderer of the sea without objects under the default sky.
pub fn seascape(gpu: &Arc<Gpu>, sea: Ocean) -> Renderer {
    under_sky(gpu, sea, 16)
}

/// Returns a repeating height field of `size`² texels with Gaussian bumps. The bumps are `bump` texels wide, and their slope deviation
/// is 1.
pub fn bumps(size: u32, bump: f32, seed: u32) -> HeightField {
    HeightField::repeating(procedural::gaussian(size, size, seed, 1.0, bump / size as f32))
}

/// Computes the photometric luminance of linear Rec. 709 colour.
pub fn luminance(color: &[f32]) -> f32 {
    leadr_reflectance::color::luminance(DVec3::new(color[0].into(), color[1].into(), color[2].into())) as f32
}
