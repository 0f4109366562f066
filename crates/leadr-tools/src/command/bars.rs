//! Bars of long work: drawn on a terminal, and elsewhere told in a line every few seconds, so that nothing is silent for long.

use std::io::Write;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// How often work is told of where no bar can be drawn.
pub const EVERY: Duration = Duration::from_secs(5);

/// A progress bar, which disappears when it is dropped.
pub struct Bar {
    bar: ProgressBar,
    /// Of a bar that is told in lines: the sender, dropped to end the thread that tells, and that thread.
    teller: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Bar {
    /// A bar that nobody sees.
    pub fn hidden() -> Self {
        Self { bar: ProgressBar::hidden(), teller: None }
    }

    /// A bar with this many steps on stderr; if that is none, since nobody knows how many, only the message and the time.
    pub fn on_terminal(steps: usize) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::stderr());
        bar.set_style(style(steps));
        // The seconds go on where the work takes long over a step.
        bar.enable_steady_tick(Duration::from_secs(1));
        Self { bar, teller: None }
    }

    /// A bar with this many steps, told to `target` every so often, for the first time after that long.
    pub fn in_lines(steps: usize, every: Duration, mut target: impl Write + Send + 'static) -> Self {
        let bar = ProgressBar::with_draw_target(Some(steps as u64), ProgressDrawTarget::hidden());
        bar.set_message("working");
        let (alive, ended) = channel();
        let told = bar.clone();
        let tell = move || {
            while ended.recv_timeout(every) == Err(RecvTimeoutError::Timeout) {
                // A closed stderr is no failure.
                let _ = writeln!(target, "{}", line(&told));
            }
        };
        Self { bar, teller: Some((alive, std::thread::spawn(tell))) }
    }

    /// What is said beside it.
    pub fn message(&self, text: &str) {
        self.bar.set_message(text.to_owned());
    }

    /// One more step is done.
    pub fn step(&self) {
        self.bar.inc(1);
    }

    /// This many steps are done.
    pub fn at(&self, step: usize) {
        self.bar.set_position(step as u64);
    }

    /// Does `work`, which prints on the same terminal, while the bar is out of its way.
    pub fn aside<T>(&self, work: impl FnOnce() -> T) -> T {
        self.bar.suspend(work)
    }

    /// Starts again with this many steps.
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
            // It cannot panic, and if it did there would be nothing to do.
            let _ = teller.join();
        }
        self.bar.finish_and_clear();
    }
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
    fn long_work_is_told_in_lines_until_it_ends() {
        let log = Log::default();
        let bar = Bar::in_lines(8, Duration::from_millis(10), log.clone());
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
        drop(Bar::in_lines(8, EVERY, log.clone()));
        assert_eq!(log.text(), "");
    }
}
