//! Progress bars. Without a terminal, progress is printed as a line every few seconds.

use std::io::Write;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use leadr_maps::shown::shown_line;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// The interval between progress lines without a terminal.
pub const EVERY: Duration = Duration::from_secs(5);

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
        bar.set_style(style(steps));
        bar.set_message(what.to_owned());
        // The tick updates the elapsed time during long steps.
        let teller = repeat(Duration::from_secs(1), {
            let bar = bar.clone();
            move || bar.tick()
        });
        Self { bar, teller }
    }

    /// Creates a bar with this many steps that writes a line with the message `what` to `target` after each interval `every`.
    pub fn in_lines(steps: usize, what: &str, every: Duration, mut target: impl Write + Send + 'static) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::hidden());
        bar.set_message(what.to_owned());
        let shared = bar.clone();
        let teller = repeat(every, move || {
            // A closed stderr is not an error.
            let _ = writeln!(target, "{}", line(&shared));
        });
        Self { bar, teller }
    }

    /// Sets the message beside the bar.
    pub fn message(&self, text: &str) {
        self.bar.set_message(shown_line(text));
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
        self.bar.set_style(style(steps));
        self.bar.set_length(steps as u64);
        self.bar.set_position(0);
        self.bar.reset_elapsed();
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

/// Calls `work` after each interval `every` in another thread. Without a thread there is no progress, which is not an error.
fn repeat(every: Duration, mut work: impl FnMut() + Send + 'static) -> Option<Teller> {
    let (alive, ended) = channel();
    let tell = move || {
        while ended.recv_timeout(every) == Err(RecvTimeoutError::Timeout) {
            work();
        }
    };
    std::thread::Builder::new().spawn(tell).ok().map(|thread| (alive, thread))
}

fn style(steps: usize) -> ProgressStyle {
    let template =
        if steps == 0 { "{elapsed} {wide_msg}" } else { "{bar:32} {percent:>3} % {elapsed} {wide_msg} {eta} left" };
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

fn line(bar: &ProgressBar) -> String {
    let (message, seconds) = (bar.message(), bar.elapsed().as_secs());
    match 100 * bar.position() / bar.length().unwrap_or(0).max(1) {
        0 => format!("leadr: {message} ({seconds} s)"),
        percent => format!("leadr: {message} ({percent} %, {seconds} s)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;
    use std::sync::{Arc, Mutex};
    use std::time::Instant;

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
        log.wait_for("leadr: baking (37 %, 0 s)\n");
        bar.restart(10);
        bar.message("drawing");
        log.wait_for("leadr: drawing (0 s)\n");
        drop(bar);
        let all = log.text();
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(log.text(), all, "nothing is printed afterwards");
    }

    #[test]
    fn short_work_prints_nothing() {
        let log = Log::default();
        drop(Bar::in_lines(8, "baking", EVERY, log.clone()));
        assert_eq!(log.text(), "");
    }
}
