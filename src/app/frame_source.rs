//! Where a capture's pictures come from: the renderer, or in tests something that needs no device.

use serde::Serialize;

use super::config::{CaptureConfig, SceneConfig};
use super::error::AppError;
use super::frames::Moment;
use super::output::Output;
use super::renderer_source::RendererSource;
use super::stage::{self, Set};
use super::values::{EnvironmentChoice, Layer};
use crate::gpu::{Gpu, GpuOptions};
use crate::maps::{self, HeightMap, RgbImage};

/// The device that renders.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceInfo {
    /// As the driver names it.
    pub device: String,
    /// Driver and version.
    pub driver: String,
}

/// How long one pass took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassTime {
    /// The pass.
    pub pass: String,
    /// Milliseconds on the device.
    pub ms: f64,
}

/// One picture in rows from the top left.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Linear Rec. 709 radiance and coverage, `width · height` long.
    pub color: Vec<[f32; 4]>,
    /// The layers that were asked for; each plane is `width · height` long, in the order of [`Layer::channels`].
    pub layers: Vec<(Layer, Vec<Vec<f32>>)>,
    /// Device time per pass, in order.
    pub passes: Vec<PassTime>,
}

/// Renders moments of one configured capture. The same moment gives the same bits.
pub trait FrameSource {
    /// What renders.
    fn device(&self) -> DeviceInfo;

    /// Renders one moment.
    ///
    /// # Errors
    /// If the device fails.
    fn render(&mut self, moment: Moment) -> Result<Frame, AppError>;
}

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
            EnvironmentChoice::File(path) => Some(maps::load_environment(path)?),
        };
        Ok(Self { height_map, environment })
    }
}

/// Loads the inputs of `config`, opens the device and prepares the renderer.
///
/// # Errors
/// If an input file or the device is not what it should be.
pub fn open(config: &CaptureConfig, output: &Output) -> Result<Box<dyn FrameSource>, AppError> {
    // Files first: their faults are found in no time and need no device.
    let scene = &config.scene;
    let inputs = Inputs::load(scene)?;
    let options = GpuOptions { device: scene.device.clone(), validation: scene.validation, ..Default::default() };
    let gpu = Gpu::new(&options)?;
    let Set { renderer, animation, .. } = stage::set(scene, inputs, &gpu, output)?;
    Ok(Box::new(RendererSource::new(config, renderer, animation)))
}
