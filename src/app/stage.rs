//! Sets the scene of a capture or a demo: objects, light and view from a configuration and its input files.

use std::sync::Arc;

use super::config::{SceneConfig, View};
use super::error::AppError;
use super::output::Output;
use super::values::{EnvironmentChoice, SceneKind, Size};
use crate::gpu::Gpu;
use crate::maps::{self, HeightMap, RgbImage};
use crate::render::camera::Camera;
use crate::render::frame::Renderer;
use crate::render::light::environment::{Environment, FACE_SIZE};
use crate::render::light::sky::Sky;
use crate::render::scene::FrameState;
use crate::scenes::daylight;
use crate::scenes::deform::{self, Deformation};
use crate::scenes::ocean::sea;
use crate::scenes::shore::shore_stage;
use crate::scenes::stage::{Lights, Relief, Stage, Views, plane_stage, sphere_stage};
use crate::scenes::studio::studio;
use crate::scenes::trex::stage::trex_stage;
use crate::scenes::{pillow, snake, spheres};

/// The files a scene is made from, loaded and checked.
#[derive(Debug)]
pub struct Inputs {
    /// Heights of the plane or sphere.
    pub height_map: Option<HeightMap>,
    /// Equirectangular radiance; none for the analytic sky.
    pub environment: Option<RgbImage>,
}

impl Inputs {
    /// Loads what `config` names.
    ///
    /// # Errors
    /// If a file is missing, damaged, too large or of another kind.
    pub fn load(config: &SceneConfig) -> Result<Self, AppError> {
        let height_map = config.height_map.as_ref().map(maps::load_height_map).transpose()?;
        let environment = match &config.environment {
            EnvironmentChoice::Sky => None,
            EnvironmentChoice::Studio => Some(studio()),
            EnvironmentChoice::File(path) => Some(maps::load_environment(path)?),
        };
        Ok(Self { height_map, environment })
    }
}

/// The scene at a time in seconds.
pub type Animation = Box<dyn Fn(f64) -> FrameState>;

/// A scene on the device.
pub struct Set {
    /// Holds the objects.
    pub renderer: Renderer,
    /// The scene at any time, seen by `camera`, which follows what moves.
    pub animation: Animation,
    /// Where the scene is seen from, relative to what it follows.
    pub camera: Camera,
}

/// Uploads the scene that `config` names.
///
/// # Errors
/// If the scene cannot be made or the device fails.
pub fn set(config: &SceneConfig, inputs: Inputs, gpu: &Arc<Gpu>, output: &Output) -> Result<Set, AppError> {
    let start = config.time_of_day.map_or(config.sun.direction(), |hour| daylight::at_hour(f64::from(hour)));
    let ground_albedo = match config.kind {
        SceneKind::Ocean => sea::BELOW_THE_HORIZON,
        _ => Sky::default().ground_albedo,
    };
    let sky = Sky { sun_direction: start, ground_albedo, ..Sky::default() };
    // A picture of an environment has its own sun in it.
    let (environment, sky) = match &inputs.environment {
        Some(image) => (Environment::from_equirect(gpu, FACE_SIZE, image)?, None),
        None => (Environment::from_sky(gpu, FACE_SIZE, &sky)?, Some(sky)),
    };
    let mut stage = stage(config, inputs, output)?;
    let camera = camera(config, stage.views);
    let mut renderer = Renderer::new(gpu, std::mem::take(&mut stage.objects), environment)?;
    renderer.set_ocean(stage.ocean.take())?;
    let lights = Lights { sky, ..Default::default() };
    let height_scale = config.height_scale;
    let hours_per_second = config.day_length.map_or(0.0, |seconds| 24.0 / f64::from(seconds));
    let animation: Animation = Box::new(move |time| {
        let mut state = stage.state(time, &camera, &lights);
        state.height_scale *= height_scale;
        daylight::pass(&mut state, time * hours_per_second);
        state
    });
    Ok(Set { renderer, animation, camera })
}

fn stage(config: &SceneConfig, inputs: Inputs, output: &Output) -> Result<Stage, AppError> {
    let mut relief = Relief { map: inputs.height_map, tile: config.atlas_tile, ..Relief::default() };
    if let Some(roughness) = config.roughness {
        relief.roughness = roughness;
    }
    Ok(match config.kind {
        SceneKind::Plane => plane_stage(relief),
        SceneKind::Sphere => sphere_stage(relief),
        SceneKind::Spheres => spheres::grid::stage(),
        SceneKind::Ocean => {
            let waves = &config.waves;
            let mut stage = sea::stage(&waves.sea(), waves.fft);
            if let Some(ocean) = &mut stage.ocean {
                ocean.choppiness = waves.choppiness as f32;
            }
            stage
        }
        SceneKind::Pillow => pillow::stage(config.atlas_tile),
        SceneKind::Snake => snake::stage(config.atlas_tile),
        SceneKind::Stretch => deform::stage(Deformation::Stretch),
        SceneKind::Shear => deform::stage(Deformation::Shear),
        SceneKind::HeightScale => deform::stage(Deformation::HeightScale),
        SceneKind::Trex | SceneKind::Shore => {
            let progress = output.progress(1000);
            progress.set_message("making the T-rex (once; then it is cached)");
            let make = if config.kind == SceneKind::Shore { shore_stage } else { trex_stage };
            let stage = make(config.atlas_tile, &|share| progress.set_position((share * 1000.0) as u64));
            progress.finish_and_clear();
            stage.map_err(|e| AppError::Failed(e.to_string()))?
        }
    })
}

/// Middle views are composed for pictures of 4 to 3 and wider; in narrower ones the camera steps back until the same width fits.
fn fitted(camera: Camera, size: Size) -> Camera {
    let narrower = (4.0 / 3.0) * size.height as f32 / size.width as f32;
    camera.at_distance(camera.position.distance(camera.target) * narrower.clamp(1.0, 4.0))
}

fn camera(config: &SceneConfig, views: Views) -> Camera {
    let camera = match config.view {
        View::Near => views.near,
        View::Mid => fitted(views.mid, config.size),
        View::Far => views.far,
        View::Pose(pose) => pose.camera(),
    };
    config.distance.map_or(camera, |metres| camera.at_distance(metres))
}
