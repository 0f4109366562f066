//! How passes are run: each under its label, with a timestamp after it, once or as often as a measurement asks for.

use std::sync::Arc;
use std::time::Instant;

use leadr_gpu::{Commands, Gpu, Result, Timestamps};

/// Most passes of one submission.
pub const MAX_PASSES: u32 = 31;

/// The time a pass took on the device, summed over the samples of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// Name of the pass.
    pub pass: String,
    /// Milliseconds of running it once.
    pub milliseconds: f64,
}

/// What a frame cost the processor: milliseconds of the clock on the wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CpuTime {
    /// Posing the scene, choosing what is drawn and how finely, and writing buffers.
    pub prepare: f64,
    /// Recording commands.
    pub record: f64,
    /// From the end of the recording until the device is done.
    pub wait: f64,
}

/// What drawing a frame cost. Nothing was read back.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameCost {
    /// Time of each pass on the device, of running it once.
    pub passes: Vec<PassTime>,
    /// Time of the processor, with all repetitions of the passes.
    pub cpu: CpuTime,
    /// Upper bound on the triangles of one sample, all views together.
    pub triangles: u64,
    /// Patches drawn for the camera.
    pub patches: u32,
}

/// Milliseconds since `start`.
pub(super) fn since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1000.0
}

/// Adds the times of further passes to those of passes of the same names.
pub(super) fn add_times(times: &mut Vec<PassTime>, more: Vec<PassTime>) {
    for PassTime { pass, milliseconds } in more {
        match times.iter_mut().find(|time| time.pass == pass) {
            Some(time) => time.milliseconds += milliseconds,
            None => times.push(PassTime { pass, milliseconds }),
        }
    }
}

/// Submits passes and reads how long they took.
#[derive(Clone)]
pub(super) struct PassTimer {
    gpu: Arc<Gpu>,
    timestamps: Timestamps,
    /// How often a pass is recorded that can be repeated.
    repeats: u32,
}

impl PassTimer {
    /// A timer of passes that run once each.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self { gpu: gpu.clone(), timestamps: Timestamps::new(gpu, MAX_PASSES + 1)?, repeats: 1 })
    }

    /// The same timer for passes that are repeated, at least once, so that a fast device's clock can measure them.
    pub fn repeating(&self, repeats: u32) -> Self {
        Self { repeats: repeats.max(1), ..self.clone() }
    }

    /// Submits what `record` runs, waits for it, and returns the time of each pass for running it once. Times of passes of
    /// the same name are added. Adds the processor's time to `cpu`.
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

/// Passes being recorded.
pub(super) struct Passes<'a> {
    cmd: &'a mut Commands,
    timestamps: &'a Timestamps,
    /// How often a pass is recorded that can be repeated.
    repeats: u32,
    /// How often each pass was recorded.
    counts: Vec<u32>,
}

impl<'a> Passes<'a> {
    /// Records passes, and gives how often each was.
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

    /// Runs a pass that leaves the same behind however often it is repeated, and that orders its repetitions by its own
    /// barriers.
    pub fn run(&mut self, name: &str, record: impl Fn(&mut Commands)) {
        let repeats = self.repeats;
        self.cmd.label_times(name, repeats, record);
        self.finish(name, repeats);
    }

    /// Runs a pass that cannot be repeated, such as one that does nothing the second time.
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
