//! The connection to the display.

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
            // Operating system errors of winit start with a source location, followed by the message.
            let reason =
                reason.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(&*reason, |r| r.1);
            AppError::Failed(format!(
                "no window can be opened ({}): start this in a desktop session or under xvfb-run, \
                 or use `leadr capture`, which needs no display",
                reason.trim_end_matches('.')
            ))
        };
        // winit panics if keyboard libraries are missing, and on any thread but the main one.
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        let made = std::panic::catch_unwind(EventLoop::new);
        std::panic::set_hook(hook);
        let events = made
            .map_err(|panic| {
                let text = panic.downcast_ref::<String>().map(String::as_str);
                let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("winit panicked");
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unavailable_window_is_one_sentence() {
        // Tests run on other threads than the main thread, so winit panics.
        let message = Display::open().err().expect("no window").to_string();
        assert!(
            message.contains("main thread") && message.contains("leadr capture") && !message.contains('\n'),
            "{message}"
        );
    }
}
