//! The subjects of the sections. Each subject is a stage on the device with its lights.

use super::studio::Studio;
use leadr_maps::RgbImage;
use leadr_render::camera::Camera;
use leadr_render::frame::Renderer;
use leadr_render::light::environment::Environment;
use leadr_render::light::sky::Sky;
use leadr_render::scene::{FrameState, Scene};
use leadr_render::surfaces::moments::MomentFormat;
use leadr_scenes::stage::{Lights, ReliefOptions, Stage, sphere_stage};
use leadr_scenes::trex::stage::trex_stage;
use leadr_tools::error::LabError;

/// A stage whose objects are on the device.
pub struct Subject {
    /// The renderer that holds the objects.
    pub renderer: Renderer,
    /// The stage with the objects' motion and the views.
    pub stage: Stage,
    lights: Lights,
    time: f64,
    objects: usize,
}

impl Subject {
    /// Uploads a stage that a panorama and `lights` illuminate.
    ///
    /// # Errors
    /// Fails if the device fails.
    pub fn in_panorama(
        studio: &Studio,
        mut stage: Stage,
        panorama: &RgbImage,
        lights: Lights,
    ) -> Result<Self, LabError> {
        let environment = Environment::from_equirect(&studio.gpu, Environment::FACE_SIZE, panorama)?;
        let objects = stage.objects.len();
        let renderer = Renderer::new(&studio.gpu, stage.take_scene(), environment)?;
        Ok(Self { renderer, stage, lights, time: 0.0, objects })
    }

    /// Uploads a stage under the sky and its sun. `time` is the time of the stage's motion in seconds.
    ///
    /// # Errors
    /// Fails if the device fails.
    pub fn under_the_sky(studio: &Studio, stage: Stage, time: f64) -> Result<Self, LabError> {
        Self::kept_in(MomentFormat::default(), studio, stage, time)
    }

    /// Like `under_the_sky`, but stores the slopes of maps in `format`.
    ///
    /// # Errors
    /// Fails if the device fails.
    pub fn kept_in(format: MomentFormat, studio: &Studio, mut stage: Stage, time: f64) -> Result<Self, LabError> {
        let sky = Sky { ground_albedo: stage.below_horizon, ..Sky::default() };
        let environment = Environment::from_sky(&studio.gpu, Environment::FACE_SIZE, &sky)?;
        let objects = stage.objects.len();
        let scene = Scene { map_precision: format, ..stage.take_scene() };
        let renderer = Renderer::new(&studio.gpu, scene, environment)?;
        Ok(Self { renderer, stage, lights: Lights::under(&sky), time, objects })
    }

    /// Uploads rock on a unit sphere under the sky, with atlas tiles of `tile` texels.
    ///
    /// # Errors
    /// Fails if the device fails.
    pub fn rock(studio: &Studio, tile: u32) -> Result<Self, LabError> {
        Self::under_the_sky(studio, sphere_stage(ReliefOptions { tile, ..ReliefOptions::default() }), 0.0)
    }

    /// Uploads the T-rex in mid-step under the sky, without its ground, with atlas tiles of `tile` texels.
    ///
    /// # Errors
    /// Fails if the T-rex cannot be created or the device fails.
    pub fn trex(studio: &Studio, tile: u32) -> Result<Self, LabError> {
        let mut stage = Self::trex_stage(tile)?;
        // The ground is the last object.
        stage.objects.pop();
        Self::under_the_sky(studio, stage, Self::MID_STEP)
    }

    /// The time at which the T-rex is in mid-step, in seconds.
    pub const MID_STEP: f64 = 0.4;

    /// Returns the stage of the T-rex with its ground, with atlas tiles of `tile` texels.
    ///
    /// # Errors
    /// Fails if the T-rex cannot be created.
    pub fn trex_stage(tile: u32) -> Result<Stage, LabError> {
        trex_stage(tile, &|_| {}).map_err(|e| LabError(e.to_string()))
    }

    /// Sets the time of the stage's motion in seconds.
    pub fn set_time(&mut self, time: f64) {
        self.time = time;
    }

    /// Returns the state of the stage as seen from `camera`.
    pub fn seen_by(&self, camera: &Camera) -> FrameState {
        let mut state = self.stage.state(self.time, camera, &self.lights);
        state.poses.truncate(self.objects);
        state
    }
}

/// Returns `camera` moved to `factor` times its distance from its target, with a narrower field of view. With `factor` times
/// fewer pixels along each axis, the picture then shows an equal region.
pub fn framed_from(camera: &Camera, factor: f32) -> Camera {
    let distance = camera.position.distance(camera.target);
    let fov_y = 2.0 * ((0.5 * camera.fov_y).tan() / factor).atan();
    Camera { fov_y, ..camera.at_distance(distance * factor) }
}
