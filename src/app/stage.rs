//! Sets the scene of a capture: objects, light and views from a configuration and its input files.

use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::config::{CaptureConfig, View};
use super::error::AppError;
use super::frame_source::Inputs;
use super::renderer_source::{Animation, RendererSource};
use super::values::SceneKind;
use crate::gpu::Gpu;
use crate::maps::{HeightMap, procedural};
use crate::render::camera::Camera;
use crate::render::displacement::{Border, HeightField};
use crate::render::environment::Environment;
use crate::render::frame::Renderer;
use crate::render::scene::{FrameState, Object, Pose, Sun};
use crate::render::sky::Sky;
use crate::scenes::{plane, sphere};

/// Texels across a face of the environment's cube map.
const CUBE_FACE: u32 = 256;
/// Linear albedo and Beckmann roughness where neither a map nor a flag says otherwise: grey stone.
const STONE: [f32; 4] = [0.42, 0.38, 0.33, 0.25];

/// Uploads the scene that `config` names.
///
/// # Errors
/// If the scene cannot be made or the device fails.
pub fn set(config: &CaptureConfig, inputs: Inputs, gpu: &Arc<Gpu>) -> Result<RendererSource, AppError> {
    let sun_direction = config.sun.direction();
    let sky = Sky { sun_direction, ..Sky::default() };
    // A picture of an environment has its own sun in it.
    let (environment, sky) = match &inputs.environment {
        Some(image) => (Environment::from_equirect(gpu, CUBE_FACE, image)?, None),
        None => (Environment::from_sky(gpu, CUBE_FACE, &sky)?, Some(sky)),
    };
    let sun = sky.map(|sky| Sun { direction: sun_direction, irradiance: Vec3::from_array(sky.sun_irradiance()) });
    let heights = height_field(inputs.height_map);
    let mut stone = STONE;
    if let Some(roughness) = config.roughness {
        stone[3] = roughness;
    }
    let (object, views) = match config.scene {
        SceneKind::Plane => still_plane(heights, stone),
        SceneKind::Sphere => still_sphere(&heights, stone, config.atlas_tile),
        SceneKind::Trex => return Err(AppError::Failed("the trex is not connected yet".into())),
    };
    let camera = camera(config, views);
    let height_scale = config.height_scale;
    let animation: Animation = Box::new(move |_time| FrameState {
        camera,
        poses: vec![Pose::Rigid(Affine3A::IDENTITY)],
        sky,
        sun,
        point_lights: Vec::new(),
        height_scale,
    });
    let renderer = Renderer::new(gpu, vec![object], environment)?;
    Ok(RendererSource::new(config, renderer, animation))
}

/// The near, middle and far view of a scene.
type Views = [Camera; 3];

fn camera(config: &CaptureConfig, [near, mid, far]: Views) -> Camera {
    let camera = match config.view {
        View::Near => near,
        View::Mid => mid,
        View::Far => far,
        View::Pose(pose) => pose.camera(),
    };
    config.distance.map_or(camera, |metres| camera.at_distance(metres))
}

/// Heights in metres: values of 0 to 1 over a repeat of 2 m give slopes of a rough wall. Without a map, rock.
fn height_field(map: Option<HeightMap>) -> HeightField {
    let map = map.unwrap_or_else(|| procedural::rock(512, 512, 1));
    let texels = map.texels.iter().map(|h| h * RELIEF).collect();
    HeightField { width: map.width, height: map.height, texels, border: Border::Wrap }
}

/// Metres of relief for a height of 1.
const RELIEF: f32 = 0.1;
/// Metres of surface that show a height map once.
const REPEAT: f32 = 2.0;

fn object(name: &str, mesh: crate::render::patch_mesh::PatchMesh, heights: HeightField, casts_shadow: bool) -> Object {
    Object {
        name: name.to_owned(),
        mesh,
        heights: Some(heights),
        height_scale: 1.0,
        color_map: None,
        specular_f0: 0.04,
        casts_shadow,
    }
}

fn still_plane(heights: HeightField, color: [f32; 4]) -> (Object, Views) {
    let mesh = plane::plane(8.0, 16, REPEAT, color, plane::even);
    let from = |distance: f32| Camera::looking_at(Vec3::new(0.0, -0.85, 0.53) * distance, Vec3::ZERO, 35.0);
    (object("plane", mesh, heights, false), [4.0, 14.0, 80.0].map(from))
}

fn still_sphere(heights: &HeightField, color: [f32; 4], tile: u32) -> (Object, Views) {
    let (mesh, heights) = sphere::displaced_sphere(heights, REPEAT, 8, tile, color);
    let from = |distance: f32| Camera::looking_at(Vec3::new(0.3, -0.9, 0.3).normalize() * distance, Vec3::ZERO, 35.0);
    (object("sphere", mesh, heights, true), [2.4, 4.5, 30.0].map(from))
}
