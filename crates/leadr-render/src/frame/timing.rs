//! Runs passes, with a label and a timestamp for each. For measurements, each pass can run several times.

use std::sync::Arc;
use std::time::Instant;

use leadr_gpu::{Commands, Gpu, Result, Timestamps};

/// The maximum number of passes in one submission.
pub const MAX_PASSES: u32 = 31;

/// The device time of a pass, summed over the samples of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// The name of the pass.
    pub pass: String,
    /// The time per run in milliseconds.
    pub milliseconds: f64,
}

/// The cost of a frame on the CPU, in milliseconds of wall-clock time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CpuTime {
    /// The time for posing the scene, selecting patches and tessellation, and writing buffers.
    pub prepare: f64,
    /// The time for recording commands.
    pub record: f64,
    /// The time from the end of recording until the device has finished.
    pub wait: f64,
}

/// The cost of drawing a frame without reading it back.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameCost {
    /// The device time of each pass, per run.
    pub passes: Vec<PassTime>,
    /// The CPU time, which includes all repetitions of the passes.
    pub cpu: CpuTime,
    /// An upper bound on the triangles of one sample, over all views.
    pub triangles: u64,
    /// The number of patches drawn for the camera.
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
    repeats: u32,
}

impl PassTimer {
    /// Creates a timer that runs each pass once.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self { gpu: gpu.clone(), timestamps: Timestamps::new(gpu, MAX_PASSES + 1)?, repeats: 1 })
    }

    /// Returns the same timer, but with `repeats` runs of each pass (at least one), so that the device's clock can measure short
    /// passes.
    pub fn repeating(&self, repeats: u32) -> Self {
        Self { repeats: repeats.max(1), ..self.clone() }
    }

    /// Submits the passes of `record`, waits for them, and returns the device time per run of each pass. The times of passes with
    /// the same name are added. The CPU time is added to `cpu`.
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

pub(super) struct Passes<'a> {
    cmd: &'a mut Commands,
    timestamps: &'a Timestamps,
    repeats: u32,
    /// The number of times that each pass was recorded.
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

    /// Runs a pass that gives the same result if it is repeated. The pass's own barriers must order its repetitions.
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
