//! The time between the frames of a window. It jumps where a machine sleeps, a program is stopped or nobody looks.

use std::time::{Duration, Instant};

/// What takes longer is no frame, but a pause.
const LONGEST_FRAME: Duration = Duration::from_secs(60);
/// How often frames a second are worked out.
const INTERVAL: Duration = Duration::from_millis(250);

/// Measures frames and counts them.
#[derive(Debug)]
pub struct FrameClock {
    /// When the last frame began, unless time has stood still since.
    last: Option<Instant>,
    /// The last frame showed something that moves by itself, so the next one follows at once.
    pub running: bool,
    /// Frames that followed at once since [`measure`](Self::measure), and their time.
    counted: (u32, Duration),
    measured: Instant,
    /// Frames a second; `None` before there were any that followed at once.
    pub fps: Option<f64>,
}

/// What lies between the beginnings of two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Its time.
    pub took: Duration,
    /// Whether the second followed at once. Otherwise the time tells when the user did something.
    pub followed: bool,
}

impl FrameClock {
    /// A clock before its first frame.
    pub fn new(now: Instant) -> Self {
        Self { last: None, running: false, counted: (0, Duration::ZERO), measured: now, fps: None }
    }

    /// A frame begins. `None` if it is the first, or the first after a pause.
    pub fn begin(&mut self, now: Instant) -> Option<Interval> {
        let took = now.saturating_duration_since(self.last.replace(now)?);
        if took > LONGEST_FRAME {
            return None;
        }
        if self.running {
            self.counted.0 += 1;
            self.counted.1 += took;
        }
        Some(Interval { took, followed: self.running })
    }

    /// Time stands still until the next frame.
    pub fn pause(&mut self) {
        self.last = None;
    }

    /// Whether frames a second should be worked out again.
    pub fn is_due(&self, now: Instant) -> bool {
        now.checked_duration_since(self.measured).is_none_or(|since| since >= INTERVAL)
    }

    /// Works out frames a second, of those that followed at once since the last time, if there were any.
    pub fn measure(&mut self, now: Instant) {
        let (frames, time) = std::mem::take(&mut self.counted);
        if frames > 0 && !time.is_zero() {
            self.fps = Some(f64::from(frames) / time.as_secs_f64());
        }
        self.measured = now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Duration = Duration::from_millis(20);
    const HOURS: Duration = Duration::from_secs(5 * 3600);

    /// Ten frames that follow at once, from `now` on; returns the end.
    fn run(clock: &mut FrameClock, mut now: Instant) -> Instant {
        for _ in 0..10 {
            clock.begin(now);
            clock.running = true;
            now += FRAME;
        }
        now
    }

    #[test]
    fn frames_a_second_are_those_that_follow_at_once() {
        let mut now = Instant::now() + HOURS;
        let mut clock = FrameClock::new(now);
        assert_eq!((clock.begin(now), clock.fps), (None, None));
        clock.running = false;
        // The user did something 3 s later.
        now += Duration::from_secs(3);
        assert_eq!(clock.begin(now), Some(Interval { took: Duration::from_secs(3), followed: false }));
        clock.running = true;
        assert!(clock.is_due(now));
        clock.measure(now);
        assert!(clock.fps.is_none() && !clock.is_due(now));
        now = run(&mut clock, now);
        clock.measure(now);
        assert!((clock.fps.unwrap() - 50.0).abs() < 6.0, "{clock:?}");
    }

    #[test]
    fn a_clock_that_jumps_changes_no_rate_and_gives_no_long_step() {
        let start = Instant::now() + HOURS;
        let mut clock = FrameClock::new(start);
        let mut now = run(&mut clock, start);
        clock.measure(now);
        let fps = clock.fps.unwrap();
        // Hours later, as after a machine's sleep.
        now += HOURS;
        assert_eq!(clock.begin(now), None);
        assert!(clock.is_due(now));
        now = run(&mut clock, now);
        clock.measure(now);
        assert!((clock.fps.unwrap() / fps - 1.0).abs() < 0.15, "{clock:?}");
        // Hours back.
        now -= HOURS;
        assert_eq!(clock.begin(now), Some(Interval { took: Duration::ZERO, followed: true }));
        assert!(clock.is_due(now));
        clock.measure(now);
        now = run(&mut clock, now);
        clock.measure(now);
        assert!((clock.fps.unwrap() / fps - 1.0).abs() < 0.15, "{clock:?}");
        // Nobody looked for a second.
        clock.pause();
        assert_eq!(clock.begin(now + Duration::from_secs(1)), None);
    }
}
