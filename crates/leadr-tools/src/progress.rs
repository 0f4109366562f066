//! Progress of long work. The command shows it.

use std::time::Instant;

use leadr_scenes::set::SetUp;

/// Steps of a bar that shows a share.
const SHARES: usize = 1000;

fn shares(share: f32) -> usize {
    (share * SHARES as f32) as usize
}

/// Receives the progress of long work.
pub trait Progress {
    /// A line for the log.
    fn say(&self, line: &str);

    /// A bar with this many steps (0: nobody knows how many), which disappears when it is dropped. Where it cannot be drawn it is told in
    /// lines.
    fn bar(&self, steps: usize) -> Box<dyn Bar>;

    /// A bar for work that reports the share it has done, 0 to 1, with `what` beside it; without `what` there is no bar.
    fn share(&self, what: Option<&str>) -> Box<dyn Fn(f32) + Sync> {
        let Some(what) = what else { return Box::new(|_| ()) };
        let bar = self.bar(SHARES);
        bar.message(what);
        Box::new(move |share| bar.at(shares(share)))
    }

    /// A bar for setting up a scene.
    fn set_up(&self) -> Box<dyn Fn(SetUp) + Sync> {
        let bar = self.bar(SHARES);
        let begun = Instant::now();
        Box::new(move |step| match step {
            SetUp::Begins(what) => {
                tracing::debug!("{what}, {:.3} s after the start", begun.elapsed().as_secs_f64());
                bar.restart(SHARES);
                bar.message(what);
            }
            SetUp::Share(share) => bar.at(shares(share)),
        })
    }
}

/// A progress bar.
pub trait Bar: Send + Sync {
    /// What is said beside it.
    fn message(&self, text: &str);

    /// One more step is done.
    fn step(&self);

    /// This many steps are done.
    fn at(&self, step: usize);

    /// Does `work`, which prints on the same terminal, while the bar is out of its way.
    fn aside(&self, work: &mut dyn FnMut());

    /// Starts again with this many steps.
    fn restart(&self, steps: usize);
}
