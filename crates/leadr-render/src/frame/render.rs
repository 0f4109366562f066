//! Renders complete frames, and reads them back or times them.

use std::ops::Range;
use std::time::Instant;

use super::drawing::Purpose;
use super::renderer::Renderer;
use super::timing::{CpuTime, FrameCost, PassTime, add_times, since};
use crate::scene::FrameState;
use crate::settings::RenderSettings;
use leadr_gpu::{GpuError, Result};
use leadr_maps::RgbImage;

/// A finished frame.
#[derive(Clone, Debug)]
pub struct FrameOutput {
    /// The width and height in pixels.
    pub size: (u32, u32),
    /// The linear radiance in rgb and the coverage in alpha. Rows start at the top.
    pub color: Vec<[f32; 4]>,
    /// The device time of each pass.
    pub times: Vec<PassTime>,
    /// An upper bound on the triangles of one sample, over all views.
    pub triangles: u64,
    /// The number of patches drawn for the camera.
    pub patches: u32,
}

impl FrameOutput {
    /// Returns the radiance without the coverage.
    pub fn image(&self) -> RgbImage {
        let texels = self.color.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
        RgbImage { width: self.size.0, height: self.size.1, texels }
    }
}

impl Renderer {
    /// Renders a frame and reads it back.
    pub fn render(&mut self, state: &FrameState, settings: &RenderSettings) -> Result<FrameOutput> {
        self.render_watched(state, settings, &mut |_| ())
    }

    /// Like [`render`](Self::render), but also reports the number of finished samples after each sample, because a frame may take
    /// minutes.
    pub fn render_watched(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        done: &mut dyn FnMut(u32),
    ) -> Result<FrameOutput> {
        self.draw_range(state, settings, 0..settings.samples.max(1), Purpose::Picture, done)
    }

    /// Renders some of a frame's samples and returns their mean. An [`Accumulation`](crate::passes::accumulate::Accumulation)
    /// combines the parts of a long frame. A sample is the same in every range that contains it.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the range is empty or ends after `settings.samples`. Also returns the errors of
    /// [`prepare`](Self::prepare).
    pub fn render_range(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        range: Range<u32>,
    ) -> Result<FrameOutput> {
        self.draw_range(state, settings, range, Purpose::Picture, &mut |_| ())
    }

    /// Renders a frame with separate filter and shading passes, so that [`layer`](Self::layer) reads exactly the values that were
    /// shaded.
    #[doc(hidden)]
    pub fn render_in_two_passes(&mut self, state: &FrameState, settings: &RenderSettings) -> Result<FrameOutput> {
        self.draw_range(state, settings, 0..settings.samples.max(1), Purpose::GBuffer, &mut |_| ())
    }

    fn draw_range(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        range: Range<u32>,
        purpose: Purpose,
        done: &mut dyn FnMut(u32),
    ) -> Result<FrameOutput> {
        if range.is_empty() || range.end > settings.samples.max(1) {
            let fault = format!("the range {range:?} is empty or exceeds the frame's {} samples", settings.samples);
            return Err(GpuError::Usage { name: "samples".to_owned(), fault });
        }
        let mut frame = self.prepare_for(state, settings, purpose)?;
        let mut times = Vec::new();
        let first = range.start;
        for index in range {
            add_times(&mut times, frame.draw_sample(index)?);
            done(index + 1 - first);
        }
        let (triangles, patches) = frame.plan.surfaces.counts();
        Ok(FrameOutput { size: settings.size, color: frame.plan.targets.mean.read(0, 0)?, times, triangles, patches })
    }

    /// Draws sample `index` of `settings.samples` with all passes and edge samples, and does not read the image back. Returns the
    /// device time of each pass.
    ///
    /// Buffers and missing pipelines are made before the first timestamp. The device is idle at the start and at the end. A driver
    /// may compile a pipeline when it is first used, so treat the first frame with new settings as a warm-up. Each pass runs
    /// `repeats` times (at least once) between its timestamps, and its time is divided by that number. Repeats make passes on fast
    /// devices long enough for the resolution of the device clock. Barriers in each pass prevent its repetitions from overlapping.
    pub fn measure(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        index: u32,
        repeats: u32,
    ) -> Result<Vec<PassTime>> {
        Ok(self.cost(state, settings, index, repeats)?.passes)
    }

    /// Like [`measure`](Self::measure), but also returns the cost on the CPU. If `repeats` is above 1, the CPU times include the
    /// repetitions, so they are longer than in a normal frame.
    #[doc(hidden)]
    pub fn cost(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        index: u32,
        repeats: u32,
    ) -> Result<FrameCost> {
        let start = Instant::now();
        let mut frame = self.prepare(state, settings)?;
        let mut cpu = CpuTime { prepare: since(start), ..Default::default() };
        let passes = frame.draw_sample_repeating(index, repeats, &mut cpu)?;
        let (triangles, patches) = frame.plan.surfaces.counts();
        Ok(FrameCost { passes, cpu, triangles, patches })
    }
}
