//! The renderer as a [`FrameSource`]: a scene as a function of time, drawn with one configuration.

use super::args::CaptureConfig;
use super::frame_source::{Frame, FrameSource, PassTime};
use super::frames::Moment;
use crate::app::error::AppError;
use crate::app::flags::device::DeviceInfo;
use crate::app::output::Output;
use crate::lab::progress::Progress;
use crate::render::frame::Layer;
use crate::render::frame::Renderer;
use crate::render::light::panorama::EnvironmentLight;
use crate::render::settings::RenderSettings;
use crate::scenes::set::{Animation, Inputs, Set, set};

/// Draws an [`Animation`] with a [`Renderer`] that holds its objects.
pub struct RendererSource {
    renderer: Renderer,
    animation: Animation,
    settings: RenderSettings,
    layers: Vec<Layer>,
    validation: bool,
}

impl RendererSource {
    /// `renderer` holds the objects that the states of `animation` pose.
    #[must_use]
    pub fn new(config: &CaptureConfig, renderer: Renderer, animation: Animation) -> Self {
        let settings = config.scene.render_settings();
        let (layers, validation) = (config.layers.clone(), config.device.validation);
        Self { renderer, animation, settings, layers, validation }
    }
}

/// Loads the inputs of `config`, opens the device and prepares the renderer.
///
/// # Errors
/// If an input file or the device is not what it should be.
pub fn open(config: &CaptureConfig, output: &Output) -> Result<Box<dyn FrameSource>, AppError> {
    // Files first: their errors are found at once, without a device.
    let scene = &config.scene;
    let inputs = Inputs::load(scene)?;
    let gpu = config.device.open()?;
    let Set { renderer, animation, .. } =
        set(scene, inputs, &gpu, Some(&scene.render_settings()), &output.share(scene.scene.making))?;
    Ok(Box::new(RendererSource::new(config, renderer, animation)))
}

impl FrameSource for RendererSource {
    fn device(&self) -> DeviceInfo {
        DeviceInfo::of(self.renderer.gpu())
    }

    fn lights(&self) -> Vec<EnvironmentLight> {
        self.renderer.environment().lights().to_vec()
    }

    fn render(&mut self, moment: Moment) -> Result<Frame, AppError> {
        let mut state = (self.animation)(moment.time);
        if let Some(distance) = moment.distance {
            state.camera = state.camera.at_distance(distance);
        }
        if let Some(degrees) = moment.turn_degrees {
            state.camera = state.camera.turned(degrees);
        }
        let output = self.renderer.render(&state, &self.settings)?;
        let mut layers = Vec::with_capacity(self.layers.len());
        for &layer in &self.layers {
            let texels = self.renderer.layer(layer)?;
            let plane = |i: usize| texels.iter().map(|texel| texel[i]).collect();
            layers.push((layer, (0..layer.channels().len()).map(plane).collect()));
        }
        if self.validation
            && let Some(first) = self.renderer.gpu().take_validation_messages().first()
        {
            return Err(AppError::Failed(format!("Vulkan validation: {first}")));
        }
        let (width, height) = output.size;
        let passes = output.times.into_iter().map(|time| PassTime { pass: time.pass, ms: time.milliseconds }).collect();
        Ok(Frame { width, height, color: output.color, layers, exposure: state.exposure(), passes })
    }
}
