//! Goals, which are bounds on ratios of measured times.

use serde::Serialize;

use super::rounds::Series;
use super::stats::Ratio;

/// A bound on a ratio of times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// The ratio is at most this value.
    AtMost(f64),
    /// The ratio is at least this value.
    AtLeast(f64),
}

impl Bound {
    /// Whether a ratio satisfies the bound, which includes its limit.
    pub fn holds(self, ratio: f64) -> bool {
        match self {
            Self::AtMost(most) => ratio <= most,
            Self::AtLeast(least) => ratio >= least,
        }
    }
}

/// A reference to one time of one row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeRef {
    /// The name of the table.
    pub table: &'static str,
    /// The name of the row in the table.
    pub row: &'static str,
    /// The name of the pass or of a sum of passes.
    pub pass: &'static str,
    /// The factor that multiplies the time.
    pub times: u32,
}

/// A bound on the ratio of two times.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// The name of the goal.
    pub name: &'static str,
    /// The dividend of the ratio.
    pub of: TimeRef,
    /// The divisor of the ratio.
    pub to: TimeRef,
    /// The bound on the ratio.
    pub bound: Bound,
}

/// The verdict on a goal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The name of the goal.
    pub goal: &'static str,
    /// The bound of the goal.
    pub bound: Bound,
    /// The median of the ratios within rounds.
    pub median: f64,
    /// The lower quartile of the ratios within rounds.
    pub low: f64,
    /// The upper quartile of the ratios within rounds.
    pub high: f64,
    /// The ratio of the times of the fastest frames.
    pub fastest: f64,
    /// Whether the median satisfies the bound.
    pub met: bool,
    /// Whether both quartiles give the same verdict. If not, more frames or a quieter machine may change the verdict.
    pub clear: bool,
}

impl Goal {
    /// Judges the goal, or returns `None` if a row was not measured. `find` returns the times of a row by table and name.
    pub fn judge<'a>(&self, find: impl Fn(&str, &str) -> Option<&'a Series>) -> Option<Verdict> {
        let of = find(self.of.table, self.of.row)?;
        let to = find(self.to.table, self.to.row)?;
        let Ratio { median, low, high, fastest, .. } = of.ratio(self.of.pass, to, self.to.pass)?;
        let scale = f64::from(self.of.times) / f64::from(self.to.times);
        let [median, low, high, fastest] = [median, low, high, fastest].map(|ratio| ratio * scale);
        let holds = |ratio| self.bound.holds(ratio);
        let (met, clear) = (holds(median), holds(low) == holds(high));
        Some(Verdict { goal: self.name, bound: self.bound, median, low, high, fastest, met, clear })
    }
}

#[cfg(test)]
mod tests {
    use super::super::rounds::{Frame, PIXELS, TOTAL};
    use super::*;
    use leadr_render::frame::PassTime;

    fn series(times: &[f64]) -> Series {
        let round = |ms: &f64| {
            let passes = vec![PassTime { pass: "shade".to_owned(), milliseconds: *ms }];
            Some(Frame { passes, ..Default::default() })
        };
        Series { repeats: 1, rounds: times.iter().map(round).collect() }
    }

    fn time_ref(row: &'static str, times: u32) -> TimeRef {
        TimeRef { table: "t", row, pass: TOTAL, times }
    }

    fn judge(bound: Bound, a: &[f64], b: &[f64]) -> Option<Verdict> {
        let (a, b) = (series(a), series(b));
        let goal = Goal { name: "a against b", of: time_ref("a", 1), to: time_ref("b", 1), bound };
        goal.judge(|_, row| match row {
            "a" => Some(&a),
            "b" => Some(&b),
            _ => None,
        })
    }

    #[test]
    fn goals_are_met_and_missed() {
        let met = judge(Bound::AtMost(2.0), &[4.0, 4.0, 4.0], &[2.0, 2.0, 2.0]).unwrap();
        assert!(met.met && met.clear && met.median == 2.0, "a bound belongs to what it allows: {met:?}");
        let missed = judge(Bound::AtMost(1.99), &[4.0, 4.0, 4.0], &[2.0, 2.0, 2.0]).unwrap();
        assert!(!missed.met && missed.clear);
        assert!(judge(Bound::AtLeast(2.0), &[4.0], &[2.0]).unwrap().met);
        assert!(!judge(Bound::AtLeast(2.1), &[4.0], &[2.0]).unwrap().met);
    }

    #[test]
    fn verdicts_within_noise_are_marked() {
        let verdict = judge(Bound::AtMost(1.0), &[0.9, 0.99, 1.1], &[1.0, 1.0, 1.0]).unwrap();
        assert!(verdict.met && !verdict.clear, "{verdict:?}");
    }

    #[test]
    fn empty_measurement_gives_no_verdict() {
        assert_eq!(judge(Bound::AtMost(1.0), &[], &[1.0]), None);
        let alone = series(&[1.0]);
        let goal = Goal { name: "", of: time_ref("a", 1), to: time_ref("b", 1), bound: Bound::AtMost(1.0) };
        assert_eq!(goal.judge(|_, row| (row == "a").then_some(&alone)), None);
        let passless = Goal {
            of: TimeRef { pass: PIXELS, ..time_ref("a", 1) },
            to: TimeRef { pass: "geometry", ..time_ref("a", 1) },
            ..goal
        };
        assert_eq!(passless.judge(|_, _| Some(&alone)), None);
    }

    #[test]
    fn times_can_count_more_than_once() {
        let row = series(&[3.0]);
        let goal = Goal { name: "", of: time_ref("a", 64), to: time_ref("a", 1), bound: Bound::AtLeast(64.0) };
        let verdict = goal.judge(|_, _| Some(&row)).unwrap();
        assert!(verdict.met && verdict.median == 64.0);
    }
}
