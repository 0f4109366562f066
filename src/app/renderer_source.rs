//! The renderer as a [`FrameSource`]: a scene as a function of time, drawn with one configuration.

use super::config::{CaptureConfig, SceneConfig};
use super::error::AppError;
use super::frame_source::{DeviceInfo, Frame, FrameSource, PassTime};
use super::frames::Moment;
use super::output::Output;
use super::stage::{self, Animation, Inputs, Set};
use super::values::Layer;
use crate::gpu::{Gpu, GpuOptions};
use crate::render::frame::{Layer as GBufferLayer, Renderer};
use crate::render::settings::RenderSettings;
use crate::render::surfaces::tessellation::TessellationSettings;

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
        let settings = render_settings(&config.scene);
        Self { renderer, animation, settings, layers: config.layers.clone(), validation: config.scene.validation }
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

/// The part of a configuration that the renderer takes.
#[must_use]
pub fn render_settings(config: &SceneConfig) -> RenderSettings {
    RenderSettings {
        size: (config.size.width, config.size.height),
        samples: config.samples,
        seed: config.seed,
        shading: config.shading,
        displacement: config.displacement,
        tessellation: TessellationSettings {
            pixels_per_triangle: config.triangle_pixels,
            to_texels: config.shading.technique().is_reference(),
            ..Default::default()
        },
        ..Default::default()
    }
}

impl FrameSource for RendererSource {
    fn device(&self) -> DeviceInfo {
        let gpu = self.renderer.gpu();
        DeviceInfo { device: gpu.device_name().to_owned(), driver: gpu.driver_info().to_owned() }
    }

    fn render(&mut self, moment: Moment) -> Result<Frame, AppError> {
        let mut state = (self.animation)(moment.time);
        if let Some(distance) = moment.distance {
            state.camera = state.camera.at_distance(distance);
        }
        let output = self.renderer.render(&state, &self.settings)?;
        let mut layers = Vec::with_capacity(self.layers.len());
        for &layer in &self.layers {
            let texels = self.renderer.layer(gbuffer_layer(layer))?;
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

fn gbuffer_layer(layer: Layer) -> GBufferLayer {
    match layer {
        Layer::Depth => GBufferLayer::Depth,
        Layer::Normal => GBufferLayer::Normal,
        Layer::MeanSlope => GBufferLayer::MeanSlope,
        Layer::Covariance => GBufferLayer::Covariance,
        Layer::Lod => GBufferLayer::Lod,
        Layer::Albedo => GBufferLayer::Albedo,
    }
}
