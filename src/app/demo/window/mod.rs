//! The window of `leadr demo`, which handles events and draws frames. The module `keys` maps keys to actions, and [`panel`] has the
//! controls.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalSize, Size};
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::ModifiersState;
use winit::window::{Window, WindowId};

use super::command_line::Seen;
use choices::Choices;
use clock::FrameClock;
pub use display::Display;
use display::{caught, is_of_display};
use frame::NewKinds;
use layout::Layout;
use leadr_gpu::shader_watch::{Change, ShaderWatch};
use leadr_maps::shown::shown_line;
use leadr_render::scene::FrameState;
use leadr_render::settings::RenderSettings;
use leadr_scenes::config::Picture;
use leadr_scenes::light::SunDirection;
use leadr_tools::bench::MemorySample;
use leadr_tools::command::error::AppError;
use loading::Loading;
use over::Difference;
use pace::{KeptQuality, Pace};
use painter::Painter;
use panel::Panel;
use show::{Animations, Program, Show};
use surroundings::Surroundings;
use viewer::Viewer;

pub mod choices;
mod clock;
mod display;
mod events;
mod frame;
pub mod keys;
pub mod layout;
pub mod loading;
mod over;
pub mod pace;
mod painter;
pub mod panel;
mod probes;
mod screenshot;
pub mod show;
pub mod surroundings;
pub mod viewer;

/// The interval at which a running comparison of two pictures is polled.
const ASK_INTERVAL: Duration = Duration::from_millis(50);

/// The number of memory samples in a run with a fixed number of frames.
const MEMORY_SAMPLES: u64 = 10;

/// The options of the window. The [`RenderSettings`] set the default size.
#[derive(Clone, Debug)]
pub struct WindowOptions {
    /// The first words of the window title.
    pub title: String,
    /// The animation time at the start, in seconds.
    pub time: f64,
    /// The picture settings at the start; `None` takes them from the [`RenderSettings`].
    pub picture: Option<Picture>,
    /// The prefix of the paths of screenshots. A number and `.png` follow, as in `-1.png` and `-2.png`. Existing files are not overwritten.
    pub screenshots: PathBuf,
    /// The number of frames after which the window closes; `None` leaves it open.
    pub frames: Option<u64>,
    /// The quality settings that do not change while something moves.
    pub kept: KeptQuality,
    /// The layout at the start. Without a size, the window has the size of the [`RenderSettings`]. By default, the panel is shown if there
    /// is room.
    pub layout: Layout,
    /// The file to which the layout is written when the window closes.
    pub layout_file: Option<PathBuf>,
    /// The folder of shader sources. Changed sources are recompiled.
    pub hot_reload: Option<PathBuf>,
}

impl Default for WindowOptions {
    fn default() -> Self {
        let (title, screenshots) = ("leadr".to_owned(), PathBuf::from("out/screenshot"));
        Self {
            title,
            time: 0.0,
            picture: None,
            screenshots,
            frames: None,
            kept: KeptQuality::default(),
            layout: Layout::default(),
            layout_file: None,
            hot_reload: None,
        }
    }
}

/// The result of a window session.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct WindowReport {
    /// The number of frames shown.
    pub frames: u64,
    /// The times in milliseconds between the starts of consecutive frames of an animation.
    pub milliseconds: Vec<f32>,
    /// The paths of the screenshots.
    pub screenshots: Vec<PathBuf>,
    /// The memory at ten evenly spaced moments. The memory is sampled if the window closes after a fixed number of frames, which must be at
    /// least ten.
    pub memory: Vec<MemorySample>,
}

impl WindowReport {
    /// Returns the median and the 95th percentile of the milliseconds between frames, or 0 if there are none.
    pub fn frame_times(&self) -> [f32; 2] {
        let mut sorted = self.milliseconds.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        [0.5, 0.95].map(|share| {
            let index = (share * sorted.len() as f64) as usize;
            sorted.get(index).copied().unwrap_or(0.0)
        })
    }
}

/// Shows a scene in a window until the user closes it. The orbit camera replaces the scene's camera, and follows the target of the scene's
/// camera. A still picture accumulates `settings.samples` samples. `program` opens other scenes. The device of the renderer must be opened
/// with [`Display::gpu_options`].
pub fn run(
    display: Display,
    mut show: Show,
    settings: RenderSettings,
    program: &mut dyn Program,
    options: WindowOptions,
) -> Result<WindowReport, AppError> {
    let choices = Choices::new(options.picture.unwrap_or_else(|| Picture::of(&settings)));
    let mut viewer = Viewer::new(show.orbit, options.time, choices, show.sweep);
    viewer.scene_moves = show.moves();
    let pace = Pace::on(show.renderer.gpu(), options.kept);
    let shader_names = || show.renderer.gpu().shader_names();
    let shaders = options.hot_reload.as_deref().map(|root| ShaderWatch::new(root, shader_names())).transpose()?;
    let open = |events: &ActiveEventLoop| -> Result<Session<'_>, AppError> {
        let size: Size = match options.layout.size {
            Some([width, height]) => LogicalSize::new(width, height).into(),
            None => PhysicalSize::new(settings.size.0, settings.size.1).into(),
        };
        let attributes = Window::default_attributes().with_title(shown_line(&options.title)).with_inner_size(size);
        let window =
            events.create_window(attributes).map_err(|e| AppError::Failed(format!("cannot open the window: {e}")))?;
        let window = Arc::new(window);
        window.request_redraw();
        Ok(Session {
            painter: Painter::new(show.renderer, window.clone())?,
            panel: Panel::new(&window, &options.layout),
            difference: Difference::default(),
            layer_is_still: false,
            size: window.inner_size(),
            window,
            occluded: false,
            hidden: false,
            clock: FrameClock::new(Instant::now()),
            scene: show.scene,
            views: show.views,
            settings,
            surroundings: show.surroundings,
            program,
            shaders,
            viewer,
            pace,
            exposure: 1.0,
            sun: None,
            has_own_sun: false,
            options,
            modifiers: ModifiersState::empty(),
            report: WindowReport::default(),
            lost: None,
            kinds: NewKinds::default(),
            screenshot_in: None,
            animations: show.animations,
            loading: Loading::default(),
        })
    };
    let mut app = App { open: Some(open), session: None, ended: Ok(WindowReport::default()) };
    // winit panics if the connection to the display is lost.
    let ended = caught(is_of_display, || display.events.run_app(&mut app));
    if ended.is_err()
        && let Some(mut session) = app.session.take()
    {
        // The thread that loads a scene may be writing files. All else refers to the lost display.
        drop(std::mem::take(&mut session.loading));
        std::mem::forget(session);
    }
    let report = app.ended?;
    let lost = |_| AppError::Failed("the connection to the display was lost: start the program again".to_owned());
    ended.map_err(lost)?.map_err(|e| AppError::Failed(format!("the window failed: {e}")))?;
    Ok(report)
}

/// A window before it opens, while it is open, or after it has closed.
struct App<'p, F> {
    open: Option<F>,
    session: Option<Session<'p>>,
    ended: Result<WindowReport, AppError>,
}

/// The state of an open window.
struct Session<'p> {
    // The painter must be dropped before the window.
    painter: Painter,
    panel: Panel,
    difference: Difference,
    /// Whether the displayed layer was read from a still picture.
    layer_is_still: bool,
    window: Arc<Window>,
    /// The window size in pixels from the last event. Querying the size panics if another program has closed the window.
    size: PhysicalSize<u32>,
    /// Whether the system reports the window as fully covered. While it is covered, no frame is drawn.
    occluded: bool,
    /// Whether the window was minimised or had no area at the last attempt to draw. No frame is drawn until the next event.
    hidden: bool,
    clock: FrameClock,
    scene: Box<dyn FnMut(f64) -> FrameState>,
    views: Option<[super::orbit::Orbit; 3]>,
    settings: RenderSettings,
    surroundings: Surroundings,
    program: &'p mut dyn Program,
    /// Watches the shader sources, and recompiles changed shaders.
    shaders: Option<ShaderWatch>,
    viewer: Viewer,
    pace: Pace,
    options: WindowOptions,
    /// The exposure factor of the current picture.
    exposure: f32,
    /// The direction of the sun in the picture.
    sun: Option<SunDirection>,
    /// Whether the sun is that of a model.
    has_own_sun: bool,
    modifiers: ModifiersState,
    report: WindowReport,
    /// The first error that a screenshot caused.
    lost: Option<AppError>,
    kinds: NewKinds,
    /// Number of frames until a screenshot, which a message announces.
    screenshot_in: Option<u32>,
    animations: Animations,
    // Dropped last: the window closes before the running work ends.
    loading: Loading,
}

impl Session<'_> {
    /// Replaces changed shaders if they compile; otherwise the previous shaders stay in use.
    fn reload(&mut self) -> Result<(), AppError> {
        // The loading thread makes pipelines of the old shaders.
        if self.loading.is_busy() {
            return Ok(());
        }
        let Some(change) = self.shaders.as_ref().and_then(ShaderWatch::change) else { return Ok(()) };
        self.painter.finish()?;
        let fault = match change {
            Change::Failed(message) => Some(message),
            Change::Compiled(shaders) => {
                let names = shaders.names().collect::<Vec<_>>().join(", ");
                match self.painter.gpu().take_shaders(shaders) {
                    Ok(pipelines) => {
                        self.panel.say(format!("{pipelines} pipeline(s) rebuilt from {names}"));
                        None
                    }
                    Err(error) => Some(error.to_string()),
                }
            }
        };
        if let Some(fault) = &fault {
            tracing::error!("{fault}");
        }
        self.panel.shader_fault = fault;
        self.viewer.invalidate();
        self.window.request_redraw();
        Ok(())
    }

    /// Logs and shows an error without closing the window.
    fn complain(&mut self, error: &AppError) {
        tracing::error!("{error}");
        self.panel.say(error.to_string());
        self.window.request_redraw();
    }

    fn copy_command(&mut self) {
        let PhysicalSize { width, height } = self.size;
        let seen = Seen {
            choices: &self.viewer.choices,
            pose: self.viewer.orbit.pose(),
            time: self.viewer.time,
            size: [width, height],
            // The command draws the sun of a model by itself.
            sun: self.sun.filter(|_| !self.has_own_sun),
        };
        if let Some(command) = self.program.command(&seen) {
            tracing::info!("{command}");
            self.panel.say(format!("Copied the command that draws this picture:\n{command}"));
            self.panel.copy(command);
        }
    }

    /// Stores the window layout if it has changed. Errors are only logged.
    fn keep_layout(&mut self) {
        let Some(file) = &self.options.layout_file else { return };
        let before = &self.options.layout;
        let points: LogicalSize<u32> = self.size.to_logical(self.panel.scale());
        let whole = self.window.fullscreen().is_some();
        let size = if whole { before.size } else { Some([points.width, points.height]) };
        let layout = Layout { size, ..self.panel.layout() };
        if layout != *before
            && let Err(error) = layout.write(file)
        {
            tracing::warn!("{error}");
        }
    }
}

impl<'p, F: FnOnce(&ActiveEventLoop) -> Result<Session<'p>, AppError>> App<'p, F> {
    /// Runs `work` on an open window. If `work` fails, the window is closed.
    fn with(&mut self, events: &ActiveEventLoop, work: impl FnOnce(&mut Session<'p>) -> Result<(), AppError>) {
        if let Some(Err(error)) = self.session.as_mut().map(work) {
            self.end(events, error);
        }
    }

    /// Closes the window. The session ends with its first error.
    fn end(&mut self, events: &ActiveEventLoop, error: AppError) {
        if self.ended.is_ok() {
            self.ended = Err(error);
        }
        events.exit();
    }
}

impl<'p, F: FnOnce(&ActiveEventLoop) -> Result<Session<'p>, AppError>> ApplicationHandler for App<'p, F> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        events.set_control_flow(ControlFlow::Wait);
        match self.open.take().map(|open| open(events)) {
            Some(Ok(session)) => self.session = Some(session),
            Some(Err(error)) => self.end(events, error),
            None => {}
        }
    }

    fn new_events(&mut self, _events: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(session)) = (cause, &self.session) {
            session.wake();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _window: WindowId, event: WindowEvent) {
        self.with(events, |session| session.handle(events, event));
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        self.with(events, |session| session.wait(events));
    }

    fn exiting(&mut self, _events: &ActiveEventLoop) {
        // The window and its surface must be dropped before the display connection.
        let Some(mut session) = self.session.take() else { return };
        session.keep_layout();
        if self.ended.is_ok() {
            // The window remained open after a failed screenshot. Scripts that wait for the file need the exit code.
            self.ended = session.lost.take().map_or(Ok(session.report), Err);
        }
    }
}

/// Formats the window title: scene or file, technique, and frames per second.
fn title(name: &str, viewer: &Viewer, fps: Option<f64>) -> String {
    let fps = fps.map(|fps| format!(" · {fps:.1} fps")).unwrap_or_default();
    let paused = if viewer.paused { " (paused)" } else { "" };
    format!("{name} · {}{fps}{paused}", viewer.choices.picture.technique.name())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::demo::orbit::Orbit;
    use crate::app::demo::window::viewer::Action;
    use leadr_render::settings::Technique;

    #[test]
    fn title_shows_scene_technique_and_frame_rate() {
        let pose = leadr_scenes::view::CameraPose {
            position: [1.0; 3],
            target: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            fov_degrees: 40.0,
        };
        let choices = Choices::new(Picture::of(&RenderSettings::default()));
        let mut viewer = Viewer::new(Orbit::new(&pose), 1.5, choices, None);
        viewer.act(Action::Technique(Technique::Lean));
        assert_eq!(title("snail.glb", &viewer, Some(29.97)), "snail.glb · lean · 30.0 fps");
        viewer.act(Action::Pause);
        assert_eq!(title("sphere", &viewer, None), "sphere · lean (paused)");
    }
}
