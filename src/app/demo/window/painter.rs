//! Presents frames in a swapchain. A frame has one picture, or two side by side, under the panel.

use std::sync::Arc;

use glam::Vec2;
use winit::window::Window;

use super::over::LayerPicture;
use super::pace::Pace;
use super::panel::paint::{Painted, PanelPainter};
use super::probes::{Ball, balls};
use leadr_gpu::{CommandRecorder, FRAMES_IN_FLIGHT, Gpu, GpuError, Swapchain, Timestamps, Use};
use leadr_maps::RgbImage;
use leadr_maps::tonemap::Tonemap;
use leadr_render::frame::{KeptTargets, Layer, MAX_PASSES, PassTime, PausedFrame, PreparedFrame, Renderer};
use leadr_render::light::environment::Environment;
use leadr_render::passes::present::{PresentPass, Presented};
use leadr_render::scene::FrameState;
use leadr_render::settings::RenderSettings;
use leadr_tools::command::error::AppError;

/// Draws into one window. The GPU draws a frame while the CPU prepares the next frame.
pub struct Painter {
    // The slots wait for the device, so they are dropped first.
    slots: [Slot; FRAMES_IN_FLIGHT],
    panel: PanelPainter,
    /// The index of the slot for the next frame.
    next: usize,
    swapchain: Swapchain,
    /// The present pass, which is recreated when the tone curve changes.
    pass: Option<(Tonemap, PresentPass)>,
    /// The times of the passes of the latest finished frame, in milliseconds.
    times: Vec<(String, f64)>,
    /// The current pictures from left to right. The samples of a still picture are spread over frames.
    shown: [Option<Shown>; 2],
    /// The targets of the right picture. The renderer owns the targets of the left picture.
    beside: KeptTargets,
    renderer: Renderer,
}

/// The resources of a frame in flight.
struct Slot {
    sides: [SideSlot; 2],
    present: CommandRecorder,
    present_time: Timestamps,
    /// Replaced pictures, whose buffers the device may still read.
    held: Vec<PausedFrame>,
}

/// The resources of one picture in a frame.
struct SideSlot {
    recorder: CommandRecorder,
    timestamps: Timestamps,
    /// The times of passes that finished during recording.
    earlier: Vec<PassTime>,
}

impl Slot {
    fn new(gpu: &Arc<Gpu>, number: usize) -> Result<Self, AppError> {
        let side = |side: &str| {
            Ok::<_, AppError>(SideSlot {
                recorder: CommandRecorder::new(gpu, &format!("window {number}, {side}"))?,
                // Each pass has one timestamp, and there is one more timestamp for the start.
                timestamps: Timestamps::new(gpu, MAX_PASSES + 1)?,
                earlier: Vec::new(),
            })
        };
        Ok(Self {
            sides: [side("left")?, side("right")?],
            present: CommandRecorder::new(gpu, &format!("window {number}"))?,
            present_time: Timestamps::new(gpu, 2)?,
            held: Vec::new(),
        })
    }
}

struct Shown {
    frame: PausedFrame,
    settings: RenderSettings,
}

/// The inputs of one frame.
pub struct WindowFrame<'a> {
    /// The size of the window in pixels.
    pub size: [u32; 2],
    /// A new state of the scene. With `None`, a still picture accumulates one more sample.
    pub state: Option<FrameState>,
    /// The settings of one picture, or of two pictures side by side.
    pub sides: &'a [RenderSettings],
    /// The pace of moving pictures.
    pub pace: &'a Pace,
    /// The exposure factor of the picture.
    pub exposure: f32,
    /// The tone curve of the picture.
    pub tonemap: Tonemap,
    /// Whether the codes of the picture are dithered.
    pub dithered: bool,
    /// Position of the split between two pictures, as a fraction of the width.
    pub split: f32,
    /// The panel that is drawn over the picture.
    pub panel: Painted,
}

impl Painter {
    /// Creates a painter for a window on the renderer's display.
    pub fn new(renderer: Renderer, window: Arc<Window>) -> Result<Self, AppError> {
        let gpu = renderer.gpu().clone();
        let swapchain = Swapchain::new(&gpu, window)?;
        Ok(Self {
            slots: [Slot::new(&gpu, 0)?, Slot::new(&gpu, 1)?],
            panel: PanelPainter::new(&gpu, swapchain.format())?,
            next: 0,
            pass: None,
            times: Vec::new(),
            shown: [None, None],
            beside: KeptTargets::default(),
            swapchain,
            renderer,
        })
    }

    /// Waits for the frames in flight.
    pub fn finish(&mut self) -> Result<(), AppError> {
        for i in 0..FRAMES_IN_FLIGHT {
            self.finish_slot((self.next + i) % FRAMES_IN_FLIGHT)?;
        }
        Ok(())
    }

    fn finish_slot(&mut self, slot: usize) -> Result<(), AppError> {
        let slot = &mut self.slots[slot];
        if slot.present.is_pending() {
            let mut times: Vec<(String, f64)> = Vec::new();
            for side in &mut slot.sides {
                let earlier = side.earlier.drain(..).map(|time| (time.pass, time.milliseconds));
                let mut passes: Vec<_> = earlier.collect();
                if side.recorder.is_pending() {
                    side.recorder.wait()?;
                    passes.extend(side.timestamps.intervals()?);
                }
                for (pass, time) in passes {
                    match times.iter_mut().find(|(known, _)| *known == pass) {
                        Some((_, sum)) => *sum += time,
                        None => times.push((pass, time)),
                    }
                }
            }
            slot.present.wait()?;
            times.extend(slot.present_time.intervals()?);
            self.times = times;
        }
        slot.held.clear();
        Ok(())
    }

    /// Returns the name and the milliseconds of each pass in the latest finished frame. The times of two pictures are added.
    pub fn times(&self) -> &[(String, f64)] {
        &self.times
    }

    /// Replaces the environment. The next frame needs a new state of the scene.
    pub fn surround(&mut self, environment: Environment) -> Result<(), AppError> {
        self.finish()?;
        self.shown = [None, None];
        self.renderer.set_environment(environment);
        Ok(())
    }

    /// Replaces the scene. The next frame needs a state of the new scene.
    pub fn replace(&mut self, renderer: Renderer) -> Result<(), AppError> {
        self.finish()?;
        self.shown = [None, None];
        self.beside = KeptTargets::default();
        self.renderer = renderer;
        Ok(())
    }

    /// Replaces the scene and keeps the current environment.
    pub fn replace_keeping_environment(&mut self, mut renderer: Renderer) -> Result<(), AppError> {
        self.finish()?;
        renderer.swap_environments(&mut self.renderer);
        self.replace(renderer)
    }

    /// Returns the device.
    pub fn gpu(&self) -> &Arc<Gpu> {
        self.renderer.gpu()
    }

    /// Returns the current and final sample counts of the picture with fewer samples.
    pub fn samples(&self) -> (u32, u32) {
        let progress = self.shown.iter().flatten().map(|shown| (shown.frame.samples(), shown.settings.samples));
        progress.min_by_key(|(has, wants)| (has * 1000) / wants.max(&1)).unwrap_or((0, 0))
    }

    /// Returns the width and the height of the drawn picture in pixels, an upper bound on the number of triangles, and the number of
    /// patches.
    pub fn drawn(&self) -> ((u32, u32), (u64, u32)) {
        let counts = self.shown.iter().flatten().map(|shown| shown.frame.counts());
        let size = self.shown[0].as_ref().map_or((0, 0), |shown| shown.settings.size);
        (size, counts.fold((0, 0), |sum, counts| (sum.0 + counts.0, sum.1 + counts.1)))
    }

    /// Whether the pictures are complete still pictures with these settings and this size, to which [`draw`](Self::draw) adds nothing.
    pub fn is_complete(&self, size: [u32; 2], sides: &[RenderSettings]) -> bool {
        self.shown.iter().flatten().count() == sides.len()
            && self.shown.iter().flatten().zip(sides).all(|(shown, side)| {
                let still = still(side, size);
                shown.settings == still && shown.frame.samples() >= still.samples
            })
    }

    /// Draws a frame. Returns false if no swapchain image is available. The caller must then pass the state again.
    ///
    /// A moving picture has one sample in the middle of each pixel, at the quality of its pace. A still picture accumulates the samples of
    /// [`Renderer::render`], and converges to the same result.
    pub fn draw(&mut self, frame: WindowFrame<'_>) -> Result<bool, AppError> {
        let WindowFrame { size, state, sides, pace, exposure, tonemap, dithered, split, mut panel } = frame;
        let current = self.next;
        if panel.textures.is_empty() {
            self.finish_slot(current)?;
        } else {
            self.finish()?;
            self.panel.update(&mut panel.textures)?;
        }
        let Some(target) = self.swapchain.acquire(size)? else { return Ok(false) };
        let [width, height] = target.image.mip_extent(0);
        let all_still = |side: &RenderSettings, shown: &Option<Shown>| {
            shown.as_ref().is_some_and(|shown| shown.settings == still(side, [width, height]))
        };
        // Moving pictures are drawn from the start. A picture that has just stopped is drawn from the start once, and then gains samples.
        let anew = state.is_some() || !sides.iter().zip(&self.shown).all(|(side, shown)| all_still(side, shown));
        let wanted: Vec<RenderSettings> = sides
            .iter()
            .map(|side| {
                let still = still(side, [width, height]);
                if state.is_some() { pace.moving(&still) } else { still }
            })
            .collect();
        let mut last: Vec<PausedFrame> = Vec::new();
        if anew {
            let before = self.shown.each_mut().map(Option::take);
            let known = before[0].as_ref().map(|shown| shown.frame.state().clone());
            last.extend(before.into_iter().flatten().map(|shown| shown.frame));
            let state = state.or(known).ok_or_else(|| AppError::Failed("the window has no scene".into()))?;
            self.draw_side(current, 0, wanted[0], |renderer| renderer.prepare(&state, &wanted[0]))?;
            if let Some(&settings) = wanted.get(1)
                && let Some(left) = self.shown[0].take()
            {
                let right =
                    self.draw_side(current, 1, settings, |renderer| renderer.prepare_second(&left.frame, &settings));
                self.shown[0] = Some(left);
                right?;
            }
        } else {
            for side in 0..sides.len() {
                self.go_on(current, side)?;
            }
        }
        if self.pass.as_ref().is_none_or(|(known, _)| *known != tonemap) {
            self.finish()?;
            self.pass = Some((tonemap, PresentPass::new(self.renderer.gpu(), self.swapchain.format(), tonemap)?));
        }
        let Some((_, pass)) = &self.pass else { return Ok(false) };
        let slot = &mut self.slots[current];
        let pictures = self.shown.each_ref().map(|shown| shown.as_ref().map(|shown| shown.frame.image()));
        let [Some(image), other] = pictures else { return Err(AppError::Failed("the window has no picture".into())) };
        let presented = Presented { image, beside: other.map(|other| (other, split)), exposure, dithered };
        let (panel_painter, time) = (&mut self.panel, &slot.present_time);
        slot.present.record("window frame", |cmd| {
            cmd.full_barrier();
            cmd.reset_timestamps(time);
            cmd.timestamp(time, "begin");
            cmd.label("present", |cmd| pass.record(cmd, presented, &target.image));
            if !panel.primitives.is_empty() {
                cmd.full_barrier();
                cmd.label("panel", |cmd| panel_painter.record(cmd, &target.image, &panel))?;
            }
            cmd.timestamp(time, "present");
            cmd.transition(&target.image, Use::Present);
            Ok::<(), AppError>(())
        })??;
        self.swapchain.present(&mut slot.present, target)?;
        self.next = (current + 1) % FRAMES_IN_FLIGHT;
        // The previous frame may still be in flight.
        self.slots[self.next].held.extend(last);
        Ok(true)
    }

    /// Adds a sample to a still picture that is not complete.
    fn go_on(&mut self, slot: usize, side: usize) -> Result<(), AppError> {
        let wants = |shown: &mut Shown| shown.frame.samples() < shown.settings.samples;
        let Some(Shown { frame, settings }) = self.shown[side].take_if(wants) else { return Ok(()) };
        self.draw_side(slot, side, settings, |renderer| renderer.resume(frame))
    }

    /// Draws a sample of a side (0 or 1) into the targets of this side.
    fn draw_side(
        &mut self,
        slot: usize,
        side: usize,
        settings: RenderSettings,
        prepare: impl FnOnce(&mut Renderer) -> Result<PreparedFrame<'_>, GpuError>,
    ) -> Result<(), AppError> {
        if side == 1 {
            self.renderer.swap_targets(&mut self.beside);
        }
        let frame = match prepare(&mut self.renderer) {
            Ok(prepared) => sample(prepared, &mut self.slots[slot].sides[side], settings),
            Err(error) => Err(error.into()),
        };
        if side == 1 {
            self.renderer.swap_targets(&mut self.beside);
        }
        self.shown[side] = Some(Shown { frame: frame?, settings });
        Ok(())
    }

    /// Reads back one or two pictures as linear radiance. Moving pictures may have fewer pixels than the window.
    pub fn pictures(&mut self) -> Result<Vec<RgbImage>, AppError> {
        self.finish()?;
        let read = |shown: &Shown| {
            let image = shown.frame.image();
            let texels: Vec<[f32; 4]> = image.read(0, 0)?;
            let [width, height] = image.mip_extent(0);
            let texels = texels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
            RgbImage::new(width, height, texels).map_err(|fault| AppError::Failed(fault.to_string()))
        };
        self.shown.iter().flatten().map(read).collect()
    }

    /// Draws and reads back the pictures again, without an offset of the camera. The next frame needs a state of the scene.
    pub fn centred_pictures(&mut self) -> Result<Vec<RgbImage>, AppError> {
        self.finish()?;
        let shown = std::mem::take(&mut self.shown);
        let pictures = shown.iter().flatten().map(|shown| {
            let mut state = shown.frame.state().clone();
            state.camera.shift = Vec2::ZERO;
            let settings = RenderSettings { samples: shown.frame.samples().max(1), ..shown.settings };
            Ok(self.renderer.render(&state, &settings)?.image())
        });
        pictures.collect()
    }

    /// Returns the probes of the sky occlusion volume that are visible in front of these depths.
    pub fn probes(&self, depth: &LayerPicture) -> Vec<Ball> {
        let camera = self.shown[0].as_ref().map(|shown| shown.frame.state().camera);
        camera.map_or_else(Vec::new, |camera| balls(&self.renderer.sky_probes(), &camera, depth))
    }

    /// Reads back a layer of the picture. The next frame needs a new state of the scene.
    pub fn layer(&mut self, layer: Layer) -> Result<LayerPicture, AppError> {
        self.finish()?;
        let (size, _) = self.drawn();
        Ok(LayerPicture { size, values: self.renderer.layer(layer)? })
    }
}

/// Returns the settings of a still picture for a window of this size.
fn still(settings: &RenderSettings, [width, height]: [u32; 2]) -> RenderSettings {
    RenderSettings { size: (width, height), samples: settings.samples.max(1), ..*settings }
}

/// Draws the next sample of a picture, and then pauses the picture.
fn sample(
    mut prepared: PreparedFrame<'_>,
    slot: &mut SideSlot,
    settings: RenderSettings,
) -> Result<PausedFrame, AppError> {
    let index = prepared.samples();
    if index < settings.samples.max(1) {
        // From the second sample on, the previous sample may still be reading the same buffers.
        if prepared.overlaps() && index == 0 {
            let timestamps = &slot.timestamps;
            slot.recorder.record("picture", |cmd| {
                cmd.full_barrier();
                prepared.record_sample(index, cmd, timestamps)
            })??;
            slot.recorder.submit(&[], &[])?;
        } else {
            slot.earlier = prepared.draw_sample(index)?;
        }
    }
    Ok(prepared.pause())
}
