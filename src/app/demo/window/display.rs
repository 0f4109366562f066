//! The connection to the display, and panics of the window library.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind, set_hook, take_hook};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use winit::event_loop::EventLoop;

use leadr_gpu::GpuOptions;
use leadr_tools::command::error::AppError;

/// A connection to the display.
pub struct Display {
    pub(super) events: EventLoop<()>,
}

impl Display {
    /// Connects to the display. A process may call this once, on the main thread.
    pub fn open() -> Result<Self, AppError> {
        let no_display = |reason: String| {
            // winit starts operating system errors with a source location, followed by the message.
            let reason =
                reason.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(&*reason, |r| r.1);
            AppError::Failed(format!(
                "no window can be opened ({}): start this in a desktop session or under xvfb-run, \
                 or use `leadr capture`, which needs no display",
                reason.trim_end_matches('.')
            ))
        };
        // winit panics if keyboard libraries are missing, and on any thread but the main one.
        let events = caught(|_| true, EventLoop::new)
            .map_err(|text| {
                // The first sentence is the reason; other sentences are advice for programmers.
                let first = text.split(['.', '\n']).next().unwrap_or_default();
                no_display(format!("{first}; libx11-6, libxcursor1, libxi6 and libxkbcommon-x11-0 are needed on X11"))
            })?
            .map_err(|e| no_display(e.to_string()))?;
        Ok(Self { events })
    }

    /// Returns options for [`Gpu::new`](leadr_gpu::Gpu::new) that select a device which can present on this display.
    pub fn gpu_options(&self, device: Option<String>, validation: bool) -> Result<GpuOptions, AppError> {
        Ok(GpuOptions {
            device,
            validation,
            window_extensions: leadr_gpu::window_extensions(&self.events)?,
            ..GpuOptions::default()
        })
    }
}

/// Crates whose panics are about the display.
const OF_DISPLAY: [&str; 8] = ["winit-", "x11rb", "x11-dl", "xkbcommon", "wayland", "smithay", "calloop", "arboard"];

/// Whether a source file belongs to a library of the display.
pub(super) fn is_of_display(file: &str) -> bool {
    OF_DISPLAY.iter().any(|library| file.contains(library))
}

/// Runs `work` and returns the text of a panic in a source file of this kind, without printing it. Other panics go on.
pub(super) fn caught<T>(
    is_expected: impl Fn(&str) -> bool + Send + Sync + 'static,
    work: impl FnOnce() -> T,
) -> Result<T, String> {
    let (usual, expected) = (Arc::new(take_hook()), Arc::new(AtomicBool::new(false)));
    let (others, found) = (usual.clone(), expected.clone());
    set_hook(Box::new(move |panic| match panic.location() {
        Some(location) if is_expected(location.file()) => found.store(true, Ordering::Relaxed),
        _ => others(panic),
    }));
    let done = catch_unwind(AssertUnwindSafe(work));
    drop(take_hook());
    if let Some(usual) = Arc::into_inner(usual) {
        set_hook(usual);
    }
    done.map_err(|panic| {
        if !expected.load(Ordering::Relaxed) {
            resume_unwind(panic);
        }
        let text = panic.downcast_ref::<String>().map(String::as_str);
        text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("the window library panicked").to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unavailable_window_is_one_sentence() {
        // Tests do not run on the main thread, so winit panics.
        let message = Display::open().err().expect("no window").to_string();
        assert!(
            message.contains("main thread") && message.contains("leadr capture") && !message.contains('\n'),
            "{message}"
        );
    }
}
