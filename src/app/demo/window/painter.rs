//! Frames of the renderer in a swapchain.

use std::sync::Arc;

use winit::window::Window;

use crate::app::error::AppError;
use crate::gpu::{CommandRecorder, Gpu, Swapchain, Timestamps, Use};
use crate::maps::RgbImage;
use crate::maps::tonemap::Tonemap;
use crate::render::frame::{PassTime, PausedFrame, Renderer};
use crate::render::light::environment::Environment;
use crate::render::passes::present::PresentPass;
use crate::render::scene::FrameState;
use crate::render::settings::RenderSettings;

/// Draws into one window. One frame is in flight; until it is done, the renderer's mapped buffers belong to the device.
pub struct Painter {
    // Dropped first: it waits for the device.
    recorder: CommandRecorder,
    swapchain: Swapchain,
    pass: PresentPass,
    timestamps: Timestamps,
    /// Times of the passes of the last sample.
    times: Vec<PassTime>,
    /// The picture being drawn, and its progress: the samples of a still picture are spread over frames.
    shown: Option<Shown>,
    renderer: Renderer,
    moving_msaa: u32,
}

struct Shown {
    frame: PausedFrame,
    settings: RenderSettings,
}

impl Painter {
    /// A painter for a window of the renderer's display. `moving_msaa`: samples of the geometry in each pixel of a moving picture.
    ///
    /// # Errors
    /// A device that cannot draw on the window, or a failed Vulkan call.
    pub fn new(renderer: Renderer, window: Arc<Window>, tonemap: Tonemap, moving_msaa: u32) -> Result<Self, AppError> {
        let gpu = renderer.gpu().clone();
        let swapchain = Swapchain::new(&gpu, window)?;
        Ok(Self {
            recorder: CommandRecorder::new(&gpu, "window")?,
            pass: PresentPass::new(&gpu, swapchain.format(), tonemap)?,
            timestamps: Timestamps::new(&gpu, 2)?,
            times: Vec::new(),
            shown: None,
            swapchain,
            renderer,
            moving_msaa,
        })
    }

    /// Waits for the frame in flight.
    ///
    /// # Errors
    /// A lost device.
    pub fn finish(&mut self) -> Result<(), AppError> {
        Ok(self.recorder.wait()?)
    }

    /// Name and milliseconds of the passes of the last frame.
    ///
    /// # Errors
    /// A lost device.
    pub fn times(&mut self) -> Result<Vec<(String, f64)>, AppError> {
        self.finish()?;
        let passes = self.times.iter().map(|time| (time.pass.clone(), time.milliseconds));
        Ok(passes.chain(self.timestamps.intervals()?).collect())
    }

    /// Surrounds the scene with another environment; the next frame needs a state of the scene.
    ///
    /// # Errors
    /// A lost device.
    pub fn surround(&mut self, environment: Environment) -> Result<(), AppError> {
        self.finish()?;
        self.shown = None;
        self.renderer.set_environment(environment);
        Ok(())
    }

    /// The device.
    #[must_use]
    pub fn gpu(&self) -> &Arc<Gpu> {
        self.renderer.gpu()
    }

    /// Whether [`draw`](Self::draw) has samples to add.
    #[must_use]
    pub fn is_complete(&self, samples: u32) -> bool {
        self.shown
            .as_ref()
            .is_some_and(|shown| shown.settings.samples == samples.max(1) && shown.frame.samples() >= samples)
    }

    /// Draws a frame in a window of `size` pixels: a new `state` of the scene, or without one a further sample of the last state,
    /// until there are `settings.samples`. False if there was nothing to draw on; then the caller must pass `state` again.
    ///
    /// A moving picture has one sample in the middle of each pixel, and multisampled geometry. A still one has the samples of
    /// [`Renderer::render`] and becomes the same picture.
    ///
    /// # Errors
    /// A lost device, or memory that is short.
    pub fn draw(
        &mut self,
        size: [u32; 2],
        state: Option<FrameState>,
        settings: &RenderSettings,
        exposure: f32,
    ) -> Result<bool, AppError> {
        self.finish()?;
        let Some(frame) = self.swapchain.acquire(size)? else { return Ok(false) };
        let [width, height] = frame.image.mip_extent(0);
        let still = RenderSettings { size: (width, height), samples: settings.samples.max(1), ..*settings };
        let moving = RenderSettings { samples: 1, msaa: self.moving_msaa, ..still };
        let (paused, settings) = match (state, self.shown.take()) {
            (Some(state), _) => (self.renderer.prepare(&state, &moving)?.pause(), moving),
            (None, Some(shown)) if shown.settings != still => {
                let state = shown.frame.into_state();
                (self.renderer.prepare(&state, &still)?.pause(), still)
            }
            (None, Some(shown)) => (shown.frame, still),
            (None, None) => return Err(AppError::Failed("the window has no scene".into())),
        };
        let mut prepared = self.renderer.resume(paused)?;
        if prepared.samples() < settings.samples {
            self.times = prepared.draw_sample(prepared.samples())?;
        }
        self.shown = Some(Shown { frame: prepared.pause(), settings });
        let (renderer, pass, timestamps) = (&self.renderer, &self.pass, &self.timestamps);
        self.recorder.record("window frame", |cmd| {
            cmd.full_barrier();
            cmd.reset_timestamps(timestamps);
            cmd.timestamp(timestamps, "begin");
            if let Some(image) = renderer.image() {
                cmd.label("present", |cmd| pass.record(cmd, image, &frame.image, exposure));
            }
            cmd.timestamp(timestamps, "present");
            cmd.transition(&frame.image, Use::Present);
        })?;
        self.swapchain.present(&mut self.recorder, frame)?;
        Ok(true)
    }

    /// The picture in the window, linear.
    ///
    /// # Errors
    /// A lost device, or memory that is short.
    pub fn picture(&mut self) -> Result<Option<RgbImage>, AppError> {
        self.finish()?;
        let Some(image) = self.renderer.image() else { return Ok(None) };
        let texels: Vec<[f32; 4]> = image.read(0, 0)?;
        let [width, height] = image.mip_extent(0);
        let texels = texels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
        let image = RgbImage::new(width, height, texels).map_err(|fault| AppError::Failed(fault.to_string()))?;
        Ok(Some(image))
    }
}
