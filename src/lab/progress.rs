//! Progress of long work. The command shows it on a terminal.

/// Receives the progress of long work.
pub trait Progress {
    /// A line for the log.
    fn say(&self, line: &str);

    /// A bar with this many steps, which disappears when it is dropped.
    fn bar(&self, steps: usize) -> Box<dyn Bar>;

    /// A bar for work that reports the share it has done, 0 to 1, with `what` beside it; without `what` there is no bar.
    fn share(&self, what: Option<&str>) -> Box<dyn Fn(f32) + Sync> {
        const STEPS: f32 = 1000.0;
        let Some(what) = what else { return Box::new(|_| ()) };
        let bar = self.bar(STEPS as usize);
        bar.message(what);
        Box::new(move |share| bar.at((share * STEPS) as usize))
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
