//! Measures the time between the frames of a window. The measured time jumps when the machine sleeps, the process stops, or the window is
//! hidden.

use std::time::{Duration, Instant};

/// The longest interval between frames. Longer intervals are pauses.
const LONGEST_FRAME: Duration = Duration::from_secs(60);
/// The interval between updates of the frame rate.
const INTERVAL: Duration = Duration::from_millis(250);

/// Measures frames and counts them.
#[derive(Debug)]
pub struct FrameClock {
    /// The start time of the previous frame; `None` after a pause.
    last: Option<Instant>,
    /// Whether the previous frame showed an animation, so that the next frame follows immediately.
    pub running: bool,
    /// The number and the total time of the consecutive frames since [`measure`](Self::measure).
    counted: (u32, Duration),
    measured: Instant,
    /// The number of frames per second; `None` until consecutive frames were measured.
    pub fps: Option<f64>,
}

/// The interval between the starts of two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The length of the interval.
    pub took: Duration,
    /// Whether the second frame followed immediately, without waiting for an event.
    pub followed: bool,
}

impl FrameClock {
    /// Creates a clock before its first frame.
    pub fn new(now: Instant) -> Self {
        Self { last: None, running: false, counted: (0, Duration::ZERO), measured: now, fps: None }
    }

    /// Starts a frame. Returns `None` for the first frame, and for the first frame after a pause.
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

    /// Pauses until the next frame.
    pub fn pause(&mut self) {
        self.last = None;
    }

    /// Whether the frame rate should be updated.
    pub fn is_due(&self, now: Instant) -> bool {
        now.checked_duration_since(self.measured).is_none_or(|since| since >= INTERVAL)
    }

    /// Updates the frame rate from the consecutive frames since the last update, if there were any.
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

    /// Runs ten consecutive frames from `now`, and returns their end time.
    fn run(clock: &mut FrameClock, mut now: Instant) -> Instant {
        for _ in 0..10 {
            clock.begin(now);
            clock.running = true;
            now += FRAME;
        }
        now
    }

    #[test]
    fn frame_rate_counts_consecutive_frames() {
        let mut now = Instant::now() + HOURS;
        let mut clock = FrameClock::new(now);
        assert_eq!((clock.begin(now), clock.fps), (None, None));
        clock.running = false;
        // The next event arrives after 3 s.
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
    fn clock_jumps_do_not_change_rates_or_steps() {
        let start = Instant::now() + HOURS;
        let mut clock = FrameClock::new(start);
        let mut now = run(&mut clock, start);
        clock.measure(now);
        let fps = clock.fps.unwrap();
        // The clock jumps by hours, as if the machine had slept.
        now += HOURS;
        assert_eq!(clock.begin(now), None);
        assert!(clock.is_due(now));
        now = run(&mut clock, now);
        clock.measure(now);
        assert!((clock.fps.unwrap() / fps - 1.0).abs() < 0.15, "{clock:?}");
        // The clock jumps back.
        now -= HOURS;
        assert_eq!(clock.begin(now), Some(Interval { took: Duration::ZERO, followed: true }));
        assert!(clock.is_due(now));
        clock.measure(now);
        now = run(&mut clock, now);
        clock.measure(now);
        assert!((clock.fps.unwrap() / fps - 1.0).abs() < 0.15, "{clock:?}");
        // The window was hidden for a second.
        clock.pause();
        assert_eq!(clock.begin(now + Duration::from_secs(1)), None);
    }
}
