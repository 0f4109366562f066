//! Interleaved measurement. Every round draws one frame of each row, and ratios are taken within rounds. A temporary
//! slowdown of the machine then affects all rows equally.

use super::forward::FORWARD;
use super::stats::{Ratio, paired_ratio};
use crate::error::LabError;
use leadr_render::frame::{CpuTime, PassTime};

/// The measurements of one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// The time of each pass on the device.
    pub passes: Vec<PassTime>,
    /// The CPU time of a frame without repeated passes, for rows that measure whole frames.
    pub cpu: Option<CpuTime>,
    /// The upper bound on the number of triangles in the frame, including shadow maps.
    pub triangles: u64,
    /// The number of patches drawn for the camera.
    pub patches: u32,
}

/// The target length of a timed region in milliseconds. GPU clocks may tick only once per microsecond.
const MEASURABLE: f64 = 0.5;
const MAX_REPEATS: u32 = 256;
/// A row skips some rounds if a frame takes longer than this time in milliseconds.
const PATIENCE: f64 = 1000.0;
const FEWEST: usize = 5;

/// The per-pixel passes, which filter the maps and shade.
pub const PIXELS: &str = "filter+shade";
/// The per-pixel passes and the geometry pass.
pub const WITH_GEOMETRY: &str = "geometry+filter+shade";
/// All passes of a frame.
pub const TOTAL: &str = "total";
/// The components of the CPU time of a frame: posing and tessellating the scene, recording commands, and waiting for the
/// device.
pub const CPU: [&str; 3] = ["cpu prepare", "cpu record", "cpu wait"];
/// The wall-clock time of a frame, which is the sum of [`CPU`].
pub const FRAME: &str = "frame";

/// The times of one row.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// The number of repetitions of each pass in its timed region.
    pub repeats: u32,
    /// The measurements of each round, or `None` if the row skipped the round.
    pub rounds: Vec<Option<Frame>>,
}

impl Frame {
    /// Returns the milliseconds of a pass or a sum of passes. See [`Series::of`].
    fn of(&self, pass: &str) -> Option<f64> {
        if let Some(CpuTime { prepare, record, wait }) = self.cpu {
            let parts = [prepare, record, wait];
            if let Some(part) = CPU.iter().position(|name| *name == pass) {
                return Some(parts[part]);
            }
            if pass == FRAME {
                return Some(parts.iter().sum());
            }
        }
        let names: Vec<&str> = pass.split('+').collect();
        // One pass may do the work of several passes, such as "filter and shade".
        let counts = |t: &&PassTime| {
            let of_several = || t.pass.split(" and ").all(|part| names.contains(&part));
            pass == TOTAL || names.contains(&t.pass.as_str()) || of_several()
        };
        let counted: Vec<f64> = self.passes.iter().filter(counts).map(|t| t.milliseconds).collect();
        (!counted.is_empty()).then(|| counted.iter().sum())
    }
}

impl Series {
    /// Returns the names of the passes in order of execution, then [`PIXELS`] and [`TOTAL`]. For whole frames, [`CPU`] and
    /// [`FRAME`] follow.
    pub fn passes(&self) -> Vec<&str> {
        let Some(first) = self.rounds.iter().flatten().next() else { return Vec::new() };
        // [`PIXELS`] has the time of this pass, and is also the name in rows with separate passes.
        let names = first.passes.iter().map(|time| time.pass.as_str());
        let mut passes: Vec<&str> = names.filter(|pass| *pass != "filter and shade").collect();
        passes.extend([PIXELS, TOTAL]);
        if first.cpu.is_some() {
            passes.extend(CPU);
            passes.push(FRAME);
        }
        passes
    }

    /// Returns the milliseconds of `pass` in each round. `pass` is a single pass, several passes joined by `+`, [`PIXELS`],
    /// [`TOTAL`], one of [`CPU`], or [`FRAME`].
    pub fn of(&self, pass: &str) -> Vec<Option<f64>> {
        self.rounds.iter().map(|frame| frame.as_ref().and_then(|frame| frame.of(pass))).collect()
    }

    /// Returns the triangles and patches of the last frame, or `None` unless the row measures whole frames.
    pub fn counts(&self) -> Option<(u64, u32)> {
        let last = self.rounds.iter().flatten().next_back()?;
        last.cpu.map(|_| (last.triangles, last.patches))
    }

    /// Counts the rounds in which the row was measured.
    pub fn measurements(&self) -> usize {
        self.rounds.iter().flatten().count()
    }

    /// Returns the milliseconds of a pass in all rounds that measured the pass.
    pub fn times(&self, pass: &str) -> Vec<f64> {
        self.of(pass).into_iter().flatten().collect()
    }

    /// Returns the ratio of this row's time to the time of the row `to`.
    pub fn ratio(&self, pass: &str, to: &Self, to_pass: &str) -> Option<Ratio> {
        paired_ratio(&self.of(pass), &to.of(to_pass))
    }
}

/// Measures `rounds` rounds of `rows` rows. `draw(row, round, repeats)` draws a frame with repeated passes, and returns the times of one
/// repetition. A warm-up draws two frames per row: the first compiles pipelines, and the second estimates the time of a frame. Rounds
/// alternate between forward and backward order, so a steady drift favours no row. `tick` reports progress.
///
/// # Errors
/// Returns the error of the first failed frame.
pub fn measure(
    draw: &mut dyn FnMut(usize, usize, u32) -> Result<Frame, LabError>,
    rows: usize,
    rounds: usize,
    tick: &mut dyn FnMut(Tick),
) -> Result<Vec<Series>, LabError> {
    let mut warm = Vec::with_capacity(rows);
    for row in 0..rows {
        draw(row, 0, 1)?;
        let times = draw(row, 0, 1)?.passes;
        let total: f64 = times.iter().map(|t| t.milliseconds).sum();
        warm.push((total, repeats(&times)));
        tick(Tick::Warm(row));
    }
    // Repeated passes use warm caches, so rows are comparable only with equal repetitions.
    let most = warm.iter().map(|w| w.1).max().unwrap_or(1);
    let mut series = Vec::with_capacity(rows);
    let mut turns = Vec::with_capacity(rows);
    for &(total, own) in &warm {
        let repeats = most.min((PATIENCE / total.max(1e-6)) as u32).max(own);
        turns.push(turns_of(total * f64::from(repeats), rounds));
        series.push(Series { repeats, rounds: vec![None; rounds] });
    }
    tick(Tick::Begin(turns.iter().sum()));
    for round in 0..rounds {
        for index in 0..rows {
            let row = if round % 2 == 0 { index } else { rows - 1 - index };
            if takes_part(round, turns[row], rounds) {
                let frame = draw(row, round, series[row].repeats)?;
                series[row].rounds[round] = Some(frame);
                tick(Tick::Frame(row));
            }
        }
    }
    Ok(series)
}

/// The progress of [`measure`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tick {
    /// The row with this index has finished its warm-up.
    Warm(usize),
    /// The warm-up is finished, and this many frames will be measured.
    Begin(usize),
    /// A frame of the row with this index was measured.
    Frame(usize),
}

/// Returns a number of repetitions that makes the per-pixel passes long enough to measure.
fn repeats(times: &[PassTime]) -> u32 {
    // The sea has its own filter and shade passes, and may be the only surface.
    let all = |pass: &str| times.iter().filter(|t| t.pass.ends_with(pass)).map(|t| t.milliseconds).reduce(|a, b| a + b);
    let shortest = PIXELS.split('+').chain([FORWARD]).filter_map(all).fold(f64::INFINITY, f64::min);
    if shortest.is_finite() {
        (MEASURABLE / shortest.max(1e-4)).ceil().clamp(1.0, f64::from(MAX_REPEATS)) as u32
    } else {
        1
    }
}

/// Returns the number of rounds in which a row with this frame time is drawn, of `rounds` in total.
fn turns_of(milliseconds: f64, rounds: usize) -> usize {
    let turns = (rounds as f64 * PATIENCE / milliseconds.max(PATIENCE)).round() as usize;
    turns.clamp(FEWEST.min(rounds), rounds)
}

/// Whether a row takes part in this round. The row takes part in `turns` evenly spaced rounds, including the first.
fn takes_part(round: usize, turns: usize, rounds: usize) -> bool {
    round == 0 || round * turns / rounds != (round - 1) * turns / rounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::stats::median;

    /// A machine whose speed drifts, and its rows of known cost. The first frame of a row compiles its pipelines.
    struct Machine {
        costs: Vec<f64>,
        load: fn(usize) -> f64,
        calls: Vec<(usize, usize, u32)>,
    }

    impl Machine {
        fn frame(&mut self, row: usize, round: usize, repeats: u32) -> Result<Frame, LabError> {
            let compiling = if self.calls.iter().any(|c| c.0 == row) { 0.0 } else { 500.0 };
            let cost = self.costs[row] * (self.load)(self.calls.len()) + compiling;
            self.calls.push((row, round, repeats));
            let pass = |pass: &str, milliseconds| PassTime { pass: pass.to_owned(), milliseconds };
            let passes = vec![pass("geometry", 1.0), pass("filter", cost * 0.25), pass("shade", cost * 0.75)];
            Ok(Frame { passes, ..Default::default() })
        }
    }

    fn run(costs: &[f64], rounds: usize, load: fn(usize) -> f64) -> (Machine, Vec<Series>) {
        let mut machine = Machine { costs: costs.to_vec(), load, calls: Vec::new() };
        let mut draw = |row, round, repeats| machine.frame(row, round, repeats);
        let series = measure(&mut draw, costs.len(), rounds, &mut |_| ()).unwrap();
        (machine, series)
    }

    #[test]
    fn warm_up_then_forwards_and_backwards() {
        let (machine, series) = run(&[10.0, 20.0, 30.0], 2, |_| 1.0);
        let rows: Vec<usize> = machine.calls.iter().map(|c| c.0).collect();
        assert_eq!(rows, [0, 0, 1, 1, 2, 2, 0, 1, 2, 2, 1, 0]);
        assert_eq!(series[1].passes(), ["geometry", "filter", "shade", PIXELS, TOTAL]);
        assert_eq!(series[1].of(PIXELS), [Some(20.0); 2], "nothing compiles in a measured frame");
        assert_eq!(series[1].of(TOTAL), [Some(21.0); 2]);
        assert_eq!(series[1].of("filter"), [Some(5.0); 2]);
        assert_eq!(series[1].of("shadow"), [None; 2]);
        assert_eq!(series[1].times("filter"), [5.0; 2]);
    }

    #[test]
    fn combined_pass_counts_for_its_parts() {
        let time = |pass: &str, milliseconds| PassTime { pass: pass.to_owned(), milliseconds };
        let passes = vec![time("geometry", 1.0), time("filter and shade", 2.0), time("sea filter and shade", 4.0)];
        let frame = Frame { passes, ..Default::default() };
        assert_eq!(frame.of("filter and shade"), Some(2.0));
        assert_eq!(frame.of(PIXELS), Some(2.0));
        assert_eq!(frame.of(WITH_GEOMETRY), Some(3.0));
        assert_eq!(frame.of("filter"), None, "it is a part of the pass");
        assert_eq!(frame.of(TOTAL), Some(7.0));
        let series = Series { repeats: 1, rounds: vec![Some(frame)] };
        assert_eq!(series.passes(), ["geometry", "sea filter and shade", PIXELS, TOTAL], "one name per time");
    }

    #[test]
    fn the_processors_time_is_no_part_of_the_devices() {
        let cpu = Some(CpuTime { prepare: 1.0, record: 2.0, wait: 8.0 });
        let passes = vec![PassTime { pass: "shade".to_owned(), milliseconds: 7.0 }];
        let frame = Frame { passes, cpu, triangles: 12, patches: 3 };
        let series = Series { repeats: 1, rounds: vec![Some(frame.clone()), None] };
        assert_eq!(series.passes()[1..], [PIXELS, TOTAL, CPU[0], CPU[1], CPU[2], FRAME]);
        assert_eq!(
            (series.of(TOTAL)[0], series.of(CPU[1])[0], series.of(FRAME)[0]),
            (Some(7.0), Some(2.0), Some(11.0))
        );
        assert_eq!(series.counts(), Some((12, 3)));
        let pixels = Series { repeats: 1, rounds: vec![Some(Frame { cpu: None, ..frame })] };
        assert_eq!((pixels.passes().len(), pixels.of(FRAME)[0], pixels.counts()), (3, None, None));
    }

    #[test]
    fn drift_leaves_the_ratio_alone() {
        // The machine becomes ten times slower. Medians of the rows are then meaningless, but the ratio is right.
        let (_, series) = run(&[10.0, 15.0], 40, |call| 1.0 + call as f64 / 9.0);
        let ratio = series[1].ratio(PIXELS, &series[0], PIXELS).unwrap();
        assert!((ratio.median - 1.5).abs() < 0.02, "{ratio:?}");
        assert!(ratio.low < 1.5 && ratio.high > 1.5, "rounds alternate, so the drift falls on both sides: {ratio:?}");
        // Measuring one row after the other gives a wrong ratio.
        let mut calls = 0;
        let mut one_after_the_other = |cost: f64| {
            let times: Vec<f64> = (0..40)
                .map(|_| {
                    calls += 1;
                    cost * (1.0 + f64::from(calls) / 9.0)
                })
                .collect();
            median(&times)
        };
        let (first, second) = (one_after_the_other(10.0), one_after_the_other(15.0));
        assert!(second / first > 2.0, "{}", second / first);
    }

    #[test]
    fn slow_rows_skip_rounds_evenly() {
        let (machine, series) = run(&[10.0, 4000.0, 90_000.0], 24, |_| 1.0);
        let counts: Vec<usize> = series.iter().map(Series::measurements).collect();
        assert_eq!(counts, [24, 6, FEWEST]);
        let rounds: Vec<usize> = machine.calls[6..].iter().filter(|c| c.0 == 1).map(|c| c.1).collect();
        assert_eq!(rounds, [0, 4, 8, 12, 16, 20]);
        assert_eq!(series[1].ratio(PIXELS, &series[0], PIXELS).unwrap().pairs, 6);
        let (_, few) = run(&[90_000.0], 2, |_| 1.0);
        assert_eq!(few[0].measurements(), 2);
    }

    #[test]
    fn fast_rows_are_repeated_and_others_with_them() {
        // The filter pass takes a quarter of 0.04 ms.
        let (machine, series) = run(&[0.04, 4.0], 1, |_| 1.0);
        assert_eq!(series.iter().map(|s| s.repeats).collect::<Vec<_>>(), [50; 2]);
        assert_eq!(machine.calls[4..], [(0, 0, 50), (1, 0, 50)]);
        let (_, series) = run(&[1e-9, 400.0, 2000.0], 1, |_| 1.0);
        assert_eq!(
            series.iter().map(|s| s.repeats).collect::<Vec<_>>(),
            [MAX_REPEATS, 2, 1],
            "no longer than a frame may take"
        );
        let repeated = [PassTime { pass: "shadow".to_owned(), milliseconds: 1e-3 }];
        assert_eq!(repeats(&repeated), 1, "there are no pixels to repeat");
    }
}
