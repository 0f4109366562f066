//! Frames that are drawn to be timed.

use super::{PassTime, Renderer};
use crate::gpu::Result;
use crate::render::scene::FrameState;
use crate::render::settings::RenderSettings;

impl Renderer {
    /// Draws one frame of one sample, the `index`-th of `settings.samples`, with all its passes and edge samples, and
    /// returns the time of each pass on the device. Nothing is read back.
    ///
    /// Buffers are written and missing pipelines are made before the first timestamp, and the device is idle when it
    /// begins and when this returns; still, drivers compile at a pipeline's first use, so the first frame of new
    /// settings is a warm-up. Each pass is drawn `repeats` times (at least once) between its timestamps and its time
    /// divided by that number: a fast device needs it, since its clock ticks in fractions of a microsecond. The passes
    /// order themselves by their own barriers, so repetitions don't overlap.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn measure(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        index: u32,
        repeats: u32,
    ) -> Result<Vec<PassTime>> {
        let posed = self.prepare(state, settings)?;
        self.repeats = repeats.max(1);
        // Begun anew, a sample has all the passes.
        let drawn = self.draw_sample(state, settings, &posed, index, 0);
        let repeats = f64::from(std::mem::replace(&mut self.repeats, 1));
        let times = drawn?.into_iter();
        Ok(times
            .map(|PassTime { pass, milliseconds }| {
                // The sky changes once, not once per repetition.
                let count = if ["sky", "cube mips"].contains(&pass.as_str()) { 1.0 } else { repeats };
                PassTime { pass, milliseconds: milliseconds / count }
            })
            .collect())
    }
}
