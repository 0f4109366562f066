//! Frames of the renderer in a swapchain.

use std::sync::Arc;

use winit::window::Window;

use super::pace::Pace;
use crate::app::error::AppError;
use crate::gpu::{CommandRecorder, FRAMES_IN_FLIGHT, Gpu, Swapchain, Timestamps, Use};
use crate::maps::RgbImage;
use crate::maps::tonemap::Tonemap;
use crate::render::frame::{MAX_PASSES, PassTime, PausedFrame, Renderer};
use crate::render::light::environment::Environment;
use crate::render::passes::present::PresentPass;
use crate::render::scene::FrameState;
use crate::render::settings::RenderSettings;

/// Draws into one window: the device draws a frame while the processor prepares the next.
pub struct Painter {
    // Dropped first: they wait for the device.
    slots: [Slot; FRAMES_IN_FLIGHT],
    /// The slot of the next frame.
    next: usize,
    swapchain: Swapchain,
    pass: PresentPass,
    /// Times of the passes of the last frame that is done.
    times: Vec<(String, f64)>,
    /// The picture being drawn, and its progress: the samples of a still picture are spread over frames.
    shown: Option<Shown>,
    renderer: Renderer,
}

/// A frame on its way.
struct Slot {
    recorder: CommandRecorder,
    timestamps: Timestamps,
    /// Times of passes that were waited for when they were recorded.
    earlier: Vec<PassTime>,
    /// A picture that nothing else holds any more, but whose buffers the device may be reading.
    held: Option<PausedFrame>,
}

impl Slot {
    fn new(gpu: &Arc<Gpu>, number: usize) -> Result<Self, AppError> {
        Ok(Self {
            recorder: CommandRecorder::new(gpu, &format!("window {number}"))?,
            // The passes, the first mark, and that of the present pass.
            timestamps: Timestamps::new(gpu, MAX_PASSES + 2)?,
            earlier: Vec::new(),
            held: None,
        })
    }
}

struct Shown {
    frame: PausedFrame,
    settings: RenderSettings,
}

impl Painter {
    /// A painter for a window of the renderer's display.
    ///
    /// # Errors
    /// A device that cannot draw on the window, or a failed Vulkan call.
    pub fn new(renderer: Renderer, window: Arc<Window>, tonemap: Tonemap) -> Result<Self, AppError> {
        let gpu = renderer.gpu().clone();
        let swapchain = Swapchain::new(&gpu, window)?;
        Ok(Self {
            slots: [Slot::new(&gpu, 0)?, Slot::new(&gpu, 1)?],
            next: 0,
            pass: PresentPass::new(&gpu, swapchain.format(), tonemap)?,
            times: Vec::new(),
            shown: None,
            swapchain,
            renderer,
        })
    }

    /// Waits for the frames on their way.
    ///
    /// # Errors
    /// A lost device.
    pub fn finish(&mut self) -> Result<(), AppError> {
        for i in 0..FRAMES_IN_FLIGHT {
            self.finish_slot((self.next + i) % FRAMES_IN_FLIGHT)?;
        }
        Ok(())
    }

    fn finish_slot(&mut self, slot: usize) -> Result<(), AppError> {
        let slot = &mut self.slots[slot];
        if slot.recorder.is_pending() {
            slot.recorder.wait()?;
            let passes = slot.earlier.drain(..).map(|time| (time.pass, time.milliseconds));
            self.times = passes.chain(slot.timestamps.intervals()?).collect();
        }
        slot.held = None;
        Ok(())
    }

    /// Name and milliseconds of the passes of the last frame that is done.
    pub fn times(&self) -> &[(String, f64)] {
        &self.times
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

    /// Whether the picture is the still one of these settings, whatever its size, with all its samples: [`draw`](Self::draw) has
    /// nothing to add.
    #[must_use]
    pub fn is_complete(&self, settings: &RenderSettings) -> bool {
        self.shown.as_ref().is_some_and(|shown| {
            let still = RenderSettings { size: shown.settings.size, samples: settings.samples.max(1), ..*settings };
            shown.settings == still && shown.frame.samples() >= still.samples
        })
    }

    /// Draws a frame in a window of `size` pixels: a new `state` of the scene, or without one a further sample of the last state,
    /// until there are `settings.samples`. False if there was nothing to draw on; then the caller must pass `state` again.
    ///
    /// A moving picture has one sample in the middle of each pixel, and is as good as its `pace` says. A still one has the samples of
    /// [`Renderer::render`] and becomes the same picture.
    ///
    /// # Errors
    /// A lost device, or memory that is short.
    pub fn draw(
        &mut self,
        size: [u32; 2],
        state: Option<FrameState>,
        settings: &RenderSettings,
        pace: &Pace,
        exposure: f32,
    ) -> Result<bool, AppError> {
        let current = self.next;
        self.finish_slot(current)?;
        let Some(frame) = self.swapchain.acquire(size)? else { return Ok(false) };
        let [width, height] = frame.image.mip_extent(0);
        let still = RenderSettings { size: (width, height), samples: settings.samples.max(1), ..*settings };
        let moving = pace.moving(&still);
        let last = self.shown.take();
        let (prepared, settings, last) = match (state, last) {
            (Some(state), last) => (self.renderer.prepare(&state, &moving)?, moving, last),
            (None, Some(shown)) if shown.settings != still => {
                let state = shown.frame.state().clone();
                (self.renderer.prepare(&state, &still)?, still, Some(shown))
            }
            (None, Some(shown)) => (self.renderer.resume(shown.frame)?, still, None),
            (None, None) => return Err(AppError::Failed("the window has no scene".into())),
        };
        let mut prepared = prepared;
        // A new frame has buffers of its own.
        let overlaps = prepared.overlaps() && prepared.samples() == 0;
        let sample = Some(prepared.samples()).filter(|&samples| samples < settings.samples);
        let slot = &mut self.slots[current];
        if let Some(sample) = sample.filter(|_| !overlaps) {
            slot.earlier = prepared.draw_sample(sample)?;
        }
        let (pass, timestamps) = (&self.pass, &slot.timestamps);
        slot.recorder.record("window frame", |cmd| {
            cmd.full_barrier();
            match sample.filter(|_| overlaps) {
                Some(sample) => prepared.record_sample(sample, cmd, timestamps)?,
                None => {
                    cmd.reset_timestamps(timestamps);
                    cmd.timestamp(timestamps, "begin");
                }
            }
            cmd.label("present", |cmd| pass.record(cmd, prepared.image(), &frame.image, exposure));
            cmd.timestamp(timestamps, "present");
            cmd.transition(&frame.image, Use::Present);
            Ok::<(), AppError>(())
        })??;
        self.shown = Some(Shown { frame: prepared.pause(), settings });
        self.swapchain.present(&mut slot.recorder, frame)?;
        self.next = (current + 1) % FRAMES_IN_FLIGHT;
        // The frame before this one may still be drawn.
        self.slots[self.next].held = last.map(|shown| shown.frame);
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
