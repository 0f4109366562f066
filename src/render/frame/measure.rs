//! Frames that are drawn to be timed.

use super::{PassTime, Renderer};
use crate::gpu::{Result, Timestamps};
use crate::render::scene::FrameState;
use crate::render::settings::RenderSettings;

impl Renderer {
    /// Draws one frame of one sample, the `index`-th of `settings.samples`, with all its passes, and returns the time
    /// of each on the device. Nothing is read back.
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
        self.prepare_camera(state, settings, &posed, index)?;
        let gpu = self.gpu.clone();
        let timestamps: Timestamps = self.timestamps.clone();
        self.repeats = repeats.max(1);
        let submitted = gpu.submit("measured frame", |cmd| {
            cmd.reset_timestamps(&timestamps);
            // Sample 0 has all the passes.
            self.record(cmd, state, settings, 0, &timestamps);
        });
        let repeats = f64::from(std::mem::replace(&mut self.repeats, 1));
        submitted?;
        let times = timestamps.intervals()?.into_iter();
        Ok(times
            .map(|(pass, milliseconds)| {
                // The sky and the waves change once, not once per repetition.
                let once = ["sky", "cube mips", "waves"].contains(&pass.as_str());
                let count = if once { 1.0 } else { repeats };
                PassTime { pass, milliseconds: milliseconds / count }
            })
            .collect())
    }
}
