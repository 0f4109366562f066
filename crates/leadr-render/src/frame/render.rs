//! Whole frames: rendered and read back, or measured.

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
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Linear radiance, and coverage in alpha; row by row from the top.
    pub color: Vec<[f32; 4]>,
    /// Time per pass.
    pub times: Vec<PassTime>,
    /// Upper bound on the triangles of one sample, all views together.
    pub triangles: u64,
    /// Patches drawn for the camera.
    pub patches: u32,
}

impl FrameOutput {
    /// The radiance without the coverage.
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

    /// Renders a frame as [`render`](Self::render) does, and tells after each sample how many are done: a frame may take minutes.
    pub fn render_watched(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        done: &mut dyn FnMut(u32),
    ) -> Result<FrameOutput> {
        self.draw_range(state, settings, 0..settings.samples.max(1), Purpose::Picture, done)
    }

    /// Renders some of the samples of a frame and gives their mean, so that a long frame can be made in parts and be put
    /// together by an [`Accumulation`](crate::passes::accumulate::Accumulation). Samples are the same in whatever part
    /// they are.
    ///
    /// # Errors
    /// [`GpuError::Usage`] for a range without samples or beyond `settings.samples`; as [`prepare`](Self::prepare).
    pub fn render_range(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        range: Range<u32>,
    ) -> Result<FrameOutput> {
        self.draw_range(state, settings, range, Purpose::Picture, &mut |_| ())
    }

    /// Renders a frame whose filter and shading are two passes in any case, so that [`layer`](Self::layer) reads the very numbers
    /// that were shaded.
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
            let fault = format!("samples {range:?} are not among the {} of the frame", settings.samples);
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

    /// Draws one frame of one sample, the `index`-th of `settings.samples`, with all its passes and edge samples, and
    /// returns the time of each pass on the device. Nothing is read back.
    ///
    /// Buffers are written and missing pipelines are made before the first timestamp, and the device is idle when it
    /// begins and when this returns; still, drivers compile at a pipeline's first use, so the first frame of new
    /// settings is a warm-up. Each pass is drawn `repeats` times (at least once) between its timestamps and its time
    /// divided by that number: a fast device needs it, since its clock ticks in fractions of a microsecond. The passes
    /// order themselves by their own barriers, so repetitions don't overlap.
    pub fn measure(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        index: u32,
        repeats: u32,
    ) -> Result<Vec<PassTime>> {
        Ok(self.cost(state, settings, index, repeats)?.passes)
    }

    /// Draws a frame as [`measure`](Self::measure) does, and returns what it cost the device and the processor. With `repeats`
    /// above 1 the processor's times are those of the repeated passes, which no other frame has.
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
