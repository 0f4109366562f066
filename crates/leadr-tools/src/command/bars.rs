//! Bars of long work: drawn on a terminal, and elsewhere told in a line every few seconds, so that nothing is silent for long.

use std::io::Write;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::progress::Bar;

/// How often work is told of where no bar can be drawn.
pub const EVERY: Duration = Duration::from_secs(5);

/// A bar that nobody sees.
pub struct HiddenBar;

impl Bar for HiddenBar {
    fn message(&self, _: &str) {}
    fn step(&self) {}
    fn at(&self, _: usize) {}
    fn aside(&self, work: &mut dyn FnMut()) {
        work();
    }
    fn restart(&self, _: usize) {}
}

/// A bar on a terminal.
pub struct TerminalBar(ProgressBar);

impl TerminalBar {
    /// A bar with this many steps on stderr; if that is none, since nobody knows how many, only the message and the time.
    pub fn new(steps: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::stderr())
            .with_style(Self::style(steps));
        // The seconds go on where the work takes long over a step.
        bar.enable_steady_tick(Duration::from_secs(1));
        Self(bar)
    }

    fn style(steps: usize) -> ProgressStyle {
        let template =
            if steps == 0 { "{elapsed} {wide_msg}" } else { "{bar:32} {percent:>3} % {elapsed} {wide_msg} {eta} left" };
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
    }
}

impl Bar for TerminalBar {
    fn message(&self, text: &str) {
        self.0.set_message(text.to_owned());
    }

    fn step(&self) {
        self.0.inc(1);
    }

    fn at(&self, step: usize) {
        self.0.set_position(step as u64);
    }

    fn aside(&self, work: &mut dyn FnMut()) {
        self.0.suspend(work);
    }

    fn restart(&self, steps: usize) {
        self.0.set_style(Self::style(steps));
        self.0.set_length(steps as u64);
        self.0.set_position(0);
        self.0.reset_elapsed();
    }
}

impl Drop for TerminalBar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// Where the work is.
struct Place {
    message: String,
    done: usize,
    steps: usize,
    begun: Instant,
}

impl Place {
    fn line(&self) -> String {
        let Self { message, done, steps, begun } = self;
        let seconds = begun.elapsed().as_secs();
        match 100 * done / (*steps).max(1) {
            0 => format!("leadr: {message} ({seconds} s)"),
            percent => format!("leadr: {message} ({percent} %, {seconds} s)"),
        }
    }
}

/// A bar that is told in lines.
pub struct LineBar {
    place: Arc<Mutex<Place>>,
    /// Dropped to end the thread that tells.
    alive: Option<Sender<()>>,
    teller: Option<JoinHandle<()>>,
}

impl LineBar {
    /// A bar with this many steps, told to `target` every so often, for the first time after that long.
    pub fn new(steps: usize, every: Duration, mut target: impl Write + Send + 'static) -> Self {
        let begun = Instant::now();
        let place = Arc::new(Mutex::new(Place { message: "working".to_owned(), done: 0, steps, begun }));
        let (alive, ended) = channel();
        let told = place.clone();
        let tell = move || {
            while ended.recv_timeout(every) == Err(RecvTimeoutError::Timeout) {
                let line = told.lock().unwrap_or_else(PoisonError::into_inner).line();
                // A closed stderr is no failure.
                let _ = writeln!(target, "{line}");
            }
        };
        Self { place, alive: Some(alive), teller: Some(std::thread::spawn(tell)) }
    }

    fn change(&self, change: impl FnOnce(&mut Place)) {
        change(&mut self.place.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl Bar for LineBar {
    fn message(&self, text: &str) {
        self.change(|place| text.clone_into(&mut place.message));
    }

    fn step(&self) {
        self.change(|place| place.done += 1);
    }

    fn at(&self, step: usize) {
        self.change(|place| place.done = step);
    }

    fn aside(&self, work: &mut dyn FnMut()) {
        work();
    }

    fn restart(&self, steps: usize) {
        self.change(|place| (place.done, place.steps, place.begun) = (0, steps, Instant::now()));
    }
}

impl Drop for LineBar {
    fn drop(&mut self) {
        drop(self.alive.take());
        if let Some(teller) = self.teller.take() {
            // It cannot panic, and if it did there would be nothing to do.
            let _ = teller.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;

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
    fn long_work_is_told_in_lines_until_it_ends() {
        let log = Log::default();
        let bar = LineBar::new(8, Duration::from_millis(10), log.clone());
        bar.message("baking");
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
        assert_eq!(log.text(), all, "nothing is told afterwards");
    }

    #[test]
    fn short_work_is_not_told() {
        let log = Log::default();
        drop(LineBar::new(8, EVERY, log.clone()));
        assert_eq!(log.text(), "");
    }
}
