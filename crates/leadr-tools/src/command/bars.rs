//! Progress bars. Without a terminal, progress is printed as lines at growing intervals.

use std::fmt;
use std::io::Write;
use std::iter::{repeat, successors};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use leadr_maps::shown::shown_line;

use console::{Term, measure_text_width};
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// The time before the first progress line without a terminal. The intervals after it double.
pub const EVERY: Duration = Duration::from_secs(5);

/// The longest interval between progress lines.
const MOST: Duration = Duration::from_secs(320);

/// The thread that prints progress, and a sender that stops the thread when dropped.
type Teller = (Sender<()>, JoinHandle<()>);

/// A progress bar, which disappears when it is dropped.
pub struct Bar {
    bar: ProgressBar,
    teller: Option<Teller>,
}

impl Bar {
    /// Creates a bar that prints nothing.
    pub fn hidden() -> Self {
        Self { bar: ProgressBar::hidden(), teller: None }
    }

    /// Creates a bar with this many steps on stderr. With 0 steps (unknown), it shows only the message `what` and the time.
    pub fn on_terminal(steps: usize, what: &str) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::stderr());
        // The tick updates the elapsed time during long steps.
        let teller = tell(repeat(Duration::from_secs(1)), {
            let bar = bar.clone();
            move || bar.tick()
        });
        let bar = Self { bar, teller };
        bar.message(what);
        bar
    }

    /// Creates a bar with this many steps that writes a line with the message `what` to `target` after the interval `every`,
    /// and further lines at intervals that double.
    pub fn in_lines(steps: usize, what: &str, every: Duration, mut target: impl Write + Send + 'static) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::hidden());
        bar.set_message(what.to_owned());
        let shared = bar.clone();
        let teller = tell(doubling(every), move || {
            // A closed stderr is not an error.
            let _ = writeln!(target, "{}", line(&shared));
        });
        Self { bar, teller }
    }

    /// Sets the message beside the bar.
    pub fn message(&self, text: &str) {
        let text = shown_line(text);
        self.bar.set_style(style(self.bar.length().unwrap_or(0), Term::stderr().size().1, &text));
        self.bar.set_message(text);
    }

    /// Advances by one step.
    pub fn step(&self) {
        self.bar.inc(1);
    }

    /// Sets the number of finished steps.
    pub fn at(&self, step: usize) {
        self.bar.set_position(step as u64);
    }

    /// Hides the bar while `work` prints to the same terminal.
    pub fn suspended<T>(&self, work: impl FnOnce() -> T) -> T {
        self.bar.suspend(work)
    }

    /// Restarts the bar with this many steps.
    pub fn restart(&self, steps: usize) {
        self.bar.set_length(steps as u64);
        self.bar.set_position(0);
        self.bar.reset_elapsed();
        self.bar.reset_eta();
        self.message(&self.bar.message());
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some((alive, teller)) = self.teller.take() {
            drop(alive);
            // The thread does not panic, and a panic could not be handled here anyway.
            let _ = teller.join();
        }
        self.bar.finish_and_clear();
    }
}

/// Calls `work` after each interval in another thread. Without a thread there is no progress, which is not an error.
fn tell(
    mut intervals: impl Iterator<Item = Duration> + Send + 'static,
    mut work: impl FnMut() + Send + 'static,
) -> Option<Teller> {
    let (alive, ended) = channel();
    let tell = move || {
        while intervals.next().is_some_and(|time| ended.recv_timeout(time) == Err(RecvTimeoutError::Timeout)) {
            work();
        }
    };
    std::thread::Builder::new().spawn(tell).ok().map(|thread| (alive, thread))
}

/// Returns intervals that double up to [`MOST`].
fn doubling(first: Duration) -> impl Iterator<Item = Duration> {
    successors(Some(first), |time| Some((*time * 2).min(MOST)))
}

/// Columns of percentage, elapsed time and time left, with their spaces.
const NUMBERS: usize = 26;

/// Returns the length of the bar on a terminal of this many columns, 0 or 4 to 32. The bar becomes shorter, and is then left out,
/// before the text `message` is cut off.
fn gauge(columns: u16, message: &str) -> usize {
    let free = usize::from(columns).saturating_sub(NUMBERS + measure_text_width(message));
    if free < 4 { 0 } else { free.min(32) }
}

fn style(steps: u64, columns: u16, message: &str) -> ProgressStyle {
    let template = match (steps, gauge(columns, message)) {
        (0, _) => "{elapsed} {wide_msg}".to_owned(),
        (_, 0) => "{percent:>3} % {elapsed} {wide_msg}{left}".to_owned(),
        (_, length) => format!("{{bar:{length}}} {{percent:>3}} % {{elapsed}} {{wide_msg}}{{left}}"),
    };
    let key = |state: &ProgressState, to: &mut dyn fmt::Write| {
        if let Some(time) = left(state.elapsed(), state.pos(), state.len()) {
            let _ = write!(to, " {:#} left", HumanDuration(time));
        }
    };
    ProgressStyle::with_template(&template)
        .map_or_else(|_| ProgressStyle::default_bar(), |style| style.with_key("left", key))
}

/// Returns an estimate of the time left, if a step is done and a second is left: as long per step as until now. The estimate of indicatif
/// follows the last steps, and grows beyond all bounds during a long one.
fn left(elapsed: Duration, position: u64, length: Option<u64>) -> Option<Duration> {
    let open = length?.checked_sub(position)?;
    let left = Duration::try_from_secs_f64(elapsed.as_secs_f64() * open as f64 / position as f64).ok()?;
    (left.as_secs() > 0).then_some(left)
}

fn line(bar: &ProgressBar) -> String {
    let (message, seconds) = (bar.message(), bar.elapsed().as_secs());
    let left = left(bar.elapsed(), bar.position(), bar.length());
    let left = left.map(|time| format!(", {} s left", time.as_secs())).unwrap_or_default();
    match 100 * bar.position() / bar.length().unwrap_or(0).max(1) {
        0 => format!("leadr: {message} ({seconds} s{left})"),
        percent => format!("leadr: {message} ({percent} %, {seconds} s{left})"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;
    use std::sync::{Arc, Mutex};
    use std::time::Instant;

    #[test]
    fn the_time_left_is_proportional_to_the_open_steps() {
        let seconds = Duration::from_secs;
        assert_eq!(left(seconds(75), 33, Some(100)), Some(Duration::from_secs_f64(75.0 * 67.0 / 33.0)));
        assert_eq!(left(seconds(75), 0, Some(100)), None, "nothing is known before the first step");
        assert_eq!(left(seconds(75), 100, Some(100)), None);
        assert_eq!(left(seconds(1), 60, Some(100)), None, "less than a second");
        assert_eq!(left(seconds(75), 120, Some(100)), None);
        assert_eq!(left(seconds(75), 3, None), None);
    }

    #[derive(Clone, Default)]
    struct Log(Arc<Mutex<Vec<u8>>>);

    impl Write for Log {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Log {
        fn text(&self) -> String {
            String::from_utf8(self.0.lock().unwrap().clone()).unwrap()
        }

        fn wait_for(&self, text: &str) {
            let start = Instant::now();
            while !self.text().contains(text) {
                assert!(start.elapsed().as_secs() < 60, "no \"{text}\" in {}", self.text());
                std::thread::sleep(Duration::from_millis(5));
            }
        }
    }

    #[test]
    fn long_work_prints_progress_lines() {
        let log = Log::default();
        let bar = Bar::in_lines(8, "baking", Duration::from_millis(10), log.clone());
        log.wait_for("leadr: baking (0 s)\n");
        bar.at(2);
        bar.step();
        log.wait_for("leadr: baking (37 %, 0 s");
        bar.restart(10);
        bar.message("drawing");
        log.wait_for("leadr: drawing (0 s)\n");
        drop(bar);
        let all = log.text();
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(log.text(), all, "nothing is printed afterwards");
    }

    #[test]
    fn lines_become_rarer_and_have_the_time_left() {
        let seconds: Vec<u64> = doubling(EVERY).take(9).map(|time| time.as_secs()).collect();
        assert_eq!(seconds, [5, 10, 20, 40, 80, 160, 320, 320, 320]);
        let log = Log::default();
        let bar = Bar::in_lines(1000, "baking", Duration::from_millis(10), log.clone());
        let start = Instant::now();
        while !log.text().contains(" s left)") {
            assert!(start.elapsed().as_secs() < 60, "{}", log.text());
            std::thread::sleep(Duration::from_millis(100));
            bar.step();
        }
        assert!(log.text().starts_with("leadr: baking (0 s)\n"), "unknown at the start: {}", log.text());
    }

    #[test]
    fn the_bar_shrinks_before_the_text() {
        let text = "rendering frame 1 of 24: tty.webp";
        assert_eq!([120, 80, 72, 62, 40].map(|columns| gauge(columns, text)), [32, 21, 13, 0, 0]);
    }

    #[test]
    fn short_work_prints_nothing() {
        let log = Log::default();
        drop(Bar::in_lines(8, "baking", EVERY, log.clone()));
        assert_eq!(log.text(), "");
    }
}
