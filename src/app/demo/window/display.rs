//! The connection to the display, or a sentence about why there is none.

use winit::event_loop::EventLoop;

use leadr_gpu::GpuOptions;
use leadr_tools::command::error::AppError;

/// A connection to the display.
pub struct Display {
    pub(super) events: EventLoop<()>,
}

impl Display {
    /// Connects to the display. Only once per process, and on its main thread.
    pub fn open() -> Result<Self, AppError> {
        let no_display = |reason: String| {
            // The reason of an operating system's error follows the place in the source that met it.
            let reason =
                reason.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(&*reason, |r| r.1);
            AppError::Failed(format!(
                "no window can be opened ({}): start this in a desktop session or under xvfb-run, \
                 or use `leadr capture`, which needs no display",
                reason.trim_end_matches('.')
            ))
        };
        // winit panics where libraries for the keyboard are missing, or on another thread.
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        let made = std::panic::catch_unwind(EventLoop::new);
        std::panic::set_hook(hook);
        let events = made
            .map_err(|panic| {
                let text = panic.downcast_ref::<String>().map(String::as_str);
                let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("winit panicked");
                // The first sentence says what; the rest is advice for programmers.
                let first = text.split(['.', '\n']).next().unwrap_or_default();
                no_display(format!("{first}; libx11-6, libxcursor1, libxi6 and libxkbcommon-x11-0 are needed on X11"))
            })?
            .map_err(|e| no_display(e.to_string()))?;
        Ok(Self { events })
    }

    /// How to open a device that can draw on this display, for [`Gpu::new`](leadr_gpu::Gpu::new).
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
    fn a_window_that_cannot_be_is_a_sentence() {
        // Tests do not run on the main thread, which winit answers with a panic.
        let said = Display::open().err().expect("no window").to_string();
        assert!(said.contains("main thread") && said.contains("leadr capture") && !said.contains('\n'), "{said}");
    }
}
