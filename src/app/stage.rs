//! Sets the scene of a capture or a demo: objects, light and view from a configuration and its input files.

use std::sync::Arc;

use super::config::{CaptureConfig, View};
use super::error::AppError;
use super::frame_source::Inputs;
use super::renderer_source::{Animation, RendererSource};
use super::values::SceneKind;
use crate::gpu::Gpu;
use crate::render::camera::Camera;
use crate::render::environment::{Environment, FACE_SIZE};
use crate::render::frame::Renderer;
use crate::render::sky::Sky;
use crate::scenes::stage::{Lights, Relief, Stage, Views, plane_stage, sphere_stage};

/// Uploads the scene that `config` names.
///
/// # Errors
/// If the scene cannot be made or the device fails.
pub fn set(config: &CaptureConfig, inputs: Inputs, gpu: &Arc<Gpu>) -> Result<RendererSource, AppError> {
    let sky = Sky { sun_direction: config.sun.direction(), ..Sky::default() };
    // A picture of an environment has its own sun in it.
    let (environment, sky) = match &inputs.environment {
        Some(image) => (Environment::from_equirect(gpu, FACE_SIZE, image)?, None),
        None => (Environment::from_sky(gpu, FACE_SIZE, &sky)?, Some(sky)),
    };
    let mut stage = stage(config, inputs)?;
    let camera = camera(config, stage.views);
    let renderer = Renderer::new(gpu, std::mem::take(&mut stage.objects), environment)?;
    let lights = Lights { sky, points: Vec::new() };
    let height_scale = config.height_scale;
    let animation: Animation = Box::new(move |time| {
        let mut state = stage.state(time, &camera, &lights);
        state.height_scale = height_scale;
        state
    });
    Ok(RendererSource::new(config, renderer, animation))
}

fn stage(config: &CaptureConfig, inputs: Inputs) -> Result<Stage, AppError> {
    let mut relief = Relief { map: inputs.height_map, tile: config.atlas_tile, ..Relief::default() };
    if let Some(roughness) = config.roughness {
        relief.roughness = roughness;
    }
    match config.scene {
        SceneKind::Plane => Ok(plane_stage(relief)),
        SceneKind::Sphere => Ok(sphere_stage(relief)),
        SceneKind::Trex => Err(AppError::Failed("the trex is not connected yet".into())),
    }
}

fn camera(config: &CaptureConfig, views: Views) -> Camera {
    let camera = match config.view {
        View::Near => views.near,
        View::Mid => views.mid,
        View::Far => views.far,
        View::Pose(pose) => pose.camera(),
    };
    config.distance.map_or(camera, |metres| camera.at_distance(metres))
}
