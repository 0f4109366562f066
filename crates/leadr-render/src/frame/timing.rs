//! Runs passes with a label and a timestamp after each, once or repeatedly for measurements.

use std::sync::Arc;
use std::time::Instant;

use leadr_gpu::{Commands, Gpu, Result, Timestamps};

/// Maximum number of passes in one submission.
pub const MAX_PASSES: u32 = 31;

/// Device time of a pass, summed over the samples of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// Name of the pass.
    pub pass: String,
    /// Time per run in milliseconds.
    pub milliseconds: f64,
}

/// CPU cost of a frame in wall-clock milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CpuTime {
    /// Time for posing the scene, selecting patches and tessellation, and writing buffers.
    pub prepare: f64,
    /// Time for recording commands.
    pub record: f64,
    /// Time from the end of recording until the device has finished.
    pub wait: f64,
}

/// The cost of drawing a frame, without readback.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameCost {
    /// Device time per run of each pass.
    pub passes: Vec<PassTime>,
    /// CPU time, including all repetitions of the passes.
    pub cpu: CpuTime,
    /// Upper bound on the triangles of one sample, over all views.
    pub triangles: u64,
    /// Patches drawn for the camera.
    pub patches: u32,
}

/// Returns the milliseconds since `start`.
pub(super) fn since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1000.0
}

/// Adds `more` to the times of passes with the same names.
pub(super) fn add_times(times: &mut Vec<PassTime>, more: Vec<PassTime>) {
    for PassTime { pass, milliseconds } in more {
        match times.iter_mut().find(|time| time.pass == pass) {
            Some(time) => time.milliseconds += milliseconds,
            None => times.push(PassTime { pass, milliseconds }),
        }
    }
}

/// Submits passes and measures their times.
#[derive(Clone)]
pub(super) struct PassTimer {
    gpu: Arc<Gpu>,
    timestamps: Timestamps,
    /// Number of times that each repeatable pass is recorded.
    repeats: u32,
}

impl PassTimer {
    /// Creates a timer that runs each pass once.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self { gpu: gpu.clone(), timestamps: Timestamps::new(gpu, MAX_PASSES + 1)?, repeats: 1 })
    }

    /// Returns the same timer with each pass run `repeats` times, at least once, for passes too short for the device's clock.
    pub fn repeating(&self, repeats: u32) -> Self {
        Self { repeats: repeats.max(1), ..self.clone() }
    }

    /// Submits the passes of `record`, waits, and returns the device time per run of each pass. Times of passes with the same name
    /// are added. CPU time is added to `cpu`.
    pub fn submit(&self, cpu: &mut CpuTime, record: impl FnOnce(&mut Passes<'_>)) -> Result<Vec<PassTime>> {
        let start = Instant::now();
        let mut recorded = 0.0;
        let counts = self.gpu.submit("frame", |cmd| {
            let counts = Passes::record(cmd, &self.timestamps, self.repeats, record);
            recorded = since(start);
            counts
        })?;
        cpu.record += recorded;
        cpu.wait += since(start) - recorded;
        let mut times = Vec::new();
        let once = |((pass, milliseconds), count): ((String, f64), u32)| {
            vec![PassTime { pass, milliseconds: milliseconds / f64::from(count) }]
        };
        for time in self.timestamps.intervals()?.into_iter().zip(counts).map(once) {
            add_times(&mut times, time);
        }
        Ok(times)
    }
}

/// A recorder of passes.
pub(super) struct Passes<'a> {
    cmd: &'a mut Commands,
    timestamps: &'a Timestamps,
    /// Number of times that each repeatable pass is recorded.
    repeats: u32,
    /// Number of times that each pass was recorded.
    counts: Vec<u32>,
}

impl<'a> Passes<'a> {
    /// Records passes, and returns the number of runs of each pass.
    pub fn record(
        cmd: &'a mut Commands,
        timestamps: &'a Timestamps,
        repeats: u32,
        record: impl FnOnce(&mut Passes<'_>),
    ) -> Vec<u32> {
        cmd.reset_timestamps(timestamps);
        cmd.timestamp(timestamps, "begin");
        let mut passes = Passes { cmd, timestamps, repeats, counts: Vec::new() };
        record(&mut passes);
        passes.counts
    }

    /// Runs an idempotent pass. The pass's own barriers must order its repetitions.
    pub fn run(&mut self, name: &str, record: impl Fn(&mut Commands)) {
        let repeats = self.repeats;
        self.cmd.label_times(name, repeats, record);
        self.finish(name, repeats);
    }

    /// Runs a pass that cannot be repeated.
    pub fn run_once(&mut self, name: &str, record: impl FnOnce(&mut Commands)) {
        self.cmd.label(name, record);
        self.finish(name, 1);
    }

    fn finish(&mut self, name: &str, count: u32) {
        self.cmd.timestamp(self.timestamps, name);
        self.counts.push(count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_one_name_are_added_and_keep_their_order() {
        let time = |pass: &str, milliseconds| PassTime { pass: pass.to_owned(), milliseconds };
        let mut times = vec![time("geometry", 1.0), time("shade", 2.0)];
        add_times(&mut times, vec![time("shade", 0.5), time("accumulate", 0.25)]);
        assert_eq!(times, [time("geometry", 1.0), time("shade", 2.5), time("accumulate", 0.25)]);
    }
}
