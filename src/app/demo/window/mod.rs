//! The window of `leadr demo`: events in, frames out.
//!
//! | input | does |
//! |---|---|
//! | left drag | turns the camera around its target |
//! | right drag, or shift and left drag | pans |
//! | wheel | moves closer or away |
//! | space | stops time, lets it run |
//! | ←, → | half a second back or forward |
//! | `,`, `.` | one frame back or forward, time stops |
//! | `0` to `9` | technique: see [`Technique::key`] |
//! | `g` | the paper's grid, or the visible-slope rules |
//! | `v` | next shadowing model: masking alone, Smith, correlated |
//! | `[`, `]` | the sun half an hour back or forward |
//! | `t` | the sun stands still, goes round in two minutes, in twenty seconds |
//! | `e` | the next environment: the scene's own, the sky, the studio, pictures dropped on the window |
//! | a `.hdr` or `.exr` dropped on the window | is the environment |
//! | `r` | back to the first view and time |
//! | `s`, F12 | saves a screenshot |
//! | `q`, Esc | quits |

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{Key, ModifiersState, NamedKey};
use winit::window::{Window, WindowId};

use super::orbit::Orbit;
use crate::app::error::AppError;
use crate::app::files::make_folder_of;
use crate::maps::save::save_png;
use crate::maps::tonemap::Tonemap;
use crate::render::frame::Renderer;
use crate::render::scene::FrameState;
use crate::render::settings::{RenderSettings, Technique};
use crate::scenes::daylight;
use crate::scenes::light::EnvironmentChoice;
pub use display::Display;
use pace::{KeptQuality, Pace};
use painter::Painter;
use surroundings::Surroundings;
use viewer::{Action, Drag, Viewer};

mod display;
pub mod pace;
mod painter;
pub mod surroundings;
pub mod viewer;

/// What characters do; those of the techniques are in their table.
const CHARACTERS: [(char, Action); 11] = [
    (',', Action::Frame(-1)),
    ('.', Action::Frame(1)),
    ('[', Action::Sun(-1)),
    (']', Action::Sun(1)),
    ('t', Action::SunPace),
    ('r', Action::Reset),
    ('s', Action::Screenshot),
    ('q', Action::Quit),
    ('g', Action::Rule),
    ('v', Action::Shadowing),
    ('e', Action::Environment),
];

/// How often the title follows the numbers.
const TITLE_INTERVAL: Duration = Duration::from_millis(250);

/// How to open the window. Its size is that of the [`RenderSettings`].
#[derive(Clone, Debug)]
pub struct WindowOptions {
    /// First words of the title.
    pub title: String,
    /// Moment at which the animation starts, seconds.
    pub time: f64,
    /// Factor on the radiance, beside what the scene's sun asks for.
    pub exposure: f32,
    /// Screenshots go to this path, with `-1.png`, `-2.png`, … appended; existing files stay.
    pub screenshots: PathBuf,
    /// Closes after this many frames; `None` leaves that to the user.
    pub frames: Option<u64>,
    /// What of pictures stays while something moves.
    pub kept: KeptQuality,
}

impl Default for WindowOptions {
    fn default() -> Self {
        let (title, screenshots) = ("leadr".to_owned(), PathBuf::from("out/screenshot"));
        Self { title, time: 0.0, exposure: 1.0, screenshots, frames: None, kept: KeptQuality::default() }
    }
}

/// What the window did.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct WindowReport {
    /// Frames shown.
    pub frames: u64,
    /// Milliseconds from the beginning of each frame after which something moved by itself to that of the next.
    pub milliseconds: Vec<f32>,
    /// Screenshots written.
    pub screenshots: Vec<PathBuf>,
}

impl WindowReport {
    /// Median and 95th percentile of the milliseconds between frames; 0 where there are none.
    #[must_use]
    pub fn frame_times(&self) -> [f32; 2] {
        let mut sorted = self.milliseconds.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        [0.5, 0.95].map(|share| {
            let index = (share * sorted.len() as f64) as usize;
            sorted.get(index).copied().unwrap_or(0.0)
        })
    }
}

/// Shows `scene` in a window until the user closes it. The scene gives its state at a time in seconds; the orbit
/// camera, which starts as `camera`, replaces the state's own, but goes where that one's target goes: a scene that
/// follows something is followed. `surroundings` are what it can be shown in; the renderer shows the first. `settings.samples` is what a picture that stands still
/// is refined to. The renderer's device must come from [`Display::gpu_options`].
///
/// # Errors
/// A device that cannot draw on the display, a lost device, memory that is short, a screenshot that cannot be written.
pub fn run(
    display: Display,
    renderer: Renderer,
    scene: impl FnMut(f64) -> FrameState,
    camera: Orbit,
    settings: RenderSettings,
    surroundings: Surroundings,
    options: WindowOptions,
) -> Result<WindowReport, AppError> {
    let viewer = Viewer::new(camera, options.time, settings.shading);
    let pace = Pace::on(renderer.gpu(), options.kept);
    let mut app = App {
        scene,
        settings,
        surroundings,
        viewer,
        pace,
        exposure: options.exposure,
        options,
        renderer: Some(renderer),
        open: None,
        modifiers: ModifiersState::empty(),
        report: WindowReport::default(),
        error: None,
    };
    let ended = display.events.run_app(&mut app).map_err(|e| AppError::Failed(format!("the window failed: {e}")));
    app.error.map_or(Ok(()), Err)?;
    ended?;
    Ok(app.report)
}

struct App<S> {
    scene: S,
    settings: RenderSettings,
    surroundings: Surroundings,
    viewer: Viewer,
    pace: Pace,
    options: WindowOptions,
    /// Of the picture that is shown.
    exposure: f32,
    /// Until the window opens.
    renderer: Option<Renderer>,
    open: Option<Open>,
    modifiers: ModifiersState,
    report: WindowReport,
    error: Option<AppError>,
}

/// The window while it is open.
struct Open {
    // Dropped before the window.
    painter: Painter,
    window: Arc<Window>,
    /// The system says that nothing of it can be seen. No frame is drawn until it says otherwise.
    occluded: bool,
    /// The last attempt to draw met a window that is minimised or has no area. No frame is drawn until an event.
    hidden: bool,
    last_frame: Option<Instant>,
    /// After the last frame something moved by itself, so that the next one followed at once.
    running: bool,
    /// Frames and their time since the title was last set.
    counted: (u32, Instant),
}

impl<S: FnMut(f64) -> FrameState> App<S> {
    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), AppError> {
        let Some(renderer) = self.renderer.take() else { return Ok(()) };
        let (width, height) = self.settings.size;
        let attributes = Window::default_attributes()
            .with_title(self.options.title.as_str())
            .with_inner_size(PhysicalSize::new(width, height));
        let window = events
            .create_window(attributes)
            .map_err(|e| AppError::Failed(format!("the window cannot be opened: {e}")))?;
        let window = Arc::new(window);
        let painter = Painter::new(renderer, window.clone(), Tonemap::default())?;
        window.request_redraw();
        let counted = (0, Instant::now());
        self.open =
            Some(Open { painter, window, occluded: false, hidden: false, last_frame: None, running: false, counted });
        Ok(())
    }

    fn draw(&mut self, events: &ActiveEventLoop) -> Result<(), AppError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let PhysicalSize { width, height } = open.window.inner_size();
        open.hidden = open.occluded || width == 0 || height == 0 || open.window.is_minimized() == Some(true);
        if open.hidden {
            // An event that says otherwise asks for a frame. Time stands still while nobody looks.
            open.last_frame = None;
            self.pace.interrupt();
            return Ok(());
        }
        let now = Instant::now();
        if let Some(last) = open.last_frame.replace(now) {
            self.viewer.advance((now - last).as_secs_f64());
            // After a picture that stood still, the time tells when the user did something.
            if open.running {
                let milliseconds = (now - last).as_secs_f32() * 1000.0;
                self.report.milliseconds.push(milliseconds);
                self.pace.frame(milliseconds);
            } else {
                self.pace.interrupt();
            }
        }
        self.settings.shading = self.viewer.shading();
        let changed = self.viewer.take_changed();
        let state = changed.then(|| {
            let mut state = (self.scene)(self.viewer.time);
            self.surroundings.light(&mut state);
            state.camera = self.viewer.camera(&state.camera);
            daylight::pass(&mut state, self.viewer.sun_hours);
            self.exposure = self.options.exposure * state.exposure();
            state
        });
        let shown = open.painter.draw([width, height], state, &self.settings, &self.pace, self.exposure)?;
        open.hidden = !shown;
        if !shown {
            if changed {
                self.viewer.invalidate();
            }
            return Ok(());
        }
        open.running = self.viewer.is_moving();
        self.report.frames += 1;
        open.counted.0 += 1;
        let since = open.counted.1.elapsed();
        // No frame follows that could set the title later.
        let last = !self.viewer.is_moving() && open.painter.is_complete(&self.settings);
        if since >= TITLE_INTERVAL || self.report.frames == 1 || last {
            let fps = f64::from(open.counted.0) / since.as_secs_f64().max(1e-6);
            if last {
                open.painter.finish()?;
            }
            open.window.set_title(&title(&self.options.title, &self.viewer, fps, open.painter.times()));
            open.counted = (0, Instant::now());
        }
        if self.options.frames.is_some_and(|frames| self.report.frames >= frames) {
            events.exit();
        }
        Ok(())
    }

    fn key(&mut self, events: &ActiveEventLoop, event: &KeyEvent) -> Result<(), AppError> {
        if event.state != ElementState::Pressed {
            return Ok(());
        }
        let Some(action) = action(&event.logical_key) else { return Ok(()) };
        // A held key scrubs on, but does not toggle.
        if event.repeat && !matches!(action, Action::Scrub(_) | Action::Frame(_) | Action::Sun(_)) {
            return Ok(());
        }
        match action {
            Action::Quit => events.exit(),
            Action::Screenshot => {
                // A full disk is no reason to close the window.
                if let Err(error) = self.screenshot() {
                    tracing::error!("{error}");
                }
            }
            Action::Environment => {
                let next = self.surroundings.next();
                return self.surround(Ok(next));
            }
            _ => self.viewer.act(action),
        }
        Ok(())
    }

    /// Shows the scene in another environment. One that cannot be read leaves things as they are.
    fn surround(&mut self, choice: Result<EnvironmentChoice, AppError>) -> Result<(), AppError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        match choice.and_then(|choice| self.surroundings.show(open.painter.gpu(), choice)) {
            Ok(environment) => {
                open.painter.surround(environment)?;
                self.viewer.invalidate();
                open.window.request_redraw();
            }
            Err(error) => tracing::error!("{error}"),
        }
        Ok(())
    }

    fn screenshot(&mut self) -> Result<(), AppError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let Some(image) = open.painter.picture()? else { return Ok(()) };
        let stem = self.options.screenshots.as_os_str();
        let path = |number: u32| {
            let mut name = stem.to_owned();
            name.push(format!("-{number}.png"));
            PathBuf::from(name)
        };
        let path = (1..).map(path).find(|path| !path.exists()).unwrap_or_default();
        make_folder_of(&path)?;
        save_png(&path, &image, self.exposure, Tonemap::default())?;
        tracing::info!("saved {}", path.display());
        self.report.screenshots.push(path);
        Ok(())
    }

    fn handle(&mut self, events: &ActiveEventLoop, event: WindowEvent) -> Result<(), AppError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => events.exit(),
            WindowEvent::RedrawRequested => return self.draw(events),
            WindowEvent::Occluded(occluded) => {
                open.occluded = occluded;
                open.hidden = occluded;
                open.window.request_redraw();
            }
            WindowEvent::Resized(_) | WindowEvent::Focused(true) => {
                open.hidden = false;
                open.window.request_redraw();
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => return self.key(events, &event),
            WindowEvent::DroppedFile(path) => return self.surround(Surroundings::dropped(path)),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::MouseInput { state, button, .. } => {
                let drag = match button {
                    MouseButton::Left if self.modifiers.shift_key() => Some(Drag::Pan),
                    MouseButton::Left => Some(Drag::Turn),
                    MouseButton::Right => Some(Drag::Pan),
                    _ => return Ok(()),
                };
                self.viewer.drag(drag.filter(|_| state == ElementState::Pressed));
            }
            WindowEvent::CursorMoved { position, .. } => {
                let height = open.window.inner_size().height;
                self.viewer.pointer([position.x as f32, position.y as f32], height as f32);
            }
            WindowEvent::MouseWheel { delta, .. } => self.viewer.wheel(match delta {
                MouseScrollDelta::LineDelta(_, lines) => lines,
                MouseScrollDelta::PixelDelta(position) => position.y as f32 / 40.0,
            }),
            _ => return Ok(()),
        }
        Ok(())
    }

    fn end_on_error(&mut self, events: &ActiveEventLoop, result: Result<(), AppError>) {
        if let Err(error) = result {
            self.error.get_or_insert(error);
            events.exit();
        }
    }
}

impl<S: FnMut(f64) -> FrameState> ApplicationHandler for App<S> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        events.set_control_flow(ControlFlow::Wait);
        let result = self.open(events);
        self.end_on_error(events, result);
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _window: WindowId, event: WindowEvent) {
        let result = self.handle(events, event);
        self.end_on_error(events, result);
    }

    fn exiting(&mut self, _events: &ActiveEventLoop) {
        // The window and its surface go before the connection to the display.
        self.open = None;
    }

    fn about_to_wait(&mut self, _events: &ActiveEventLoop) {
        // Sleeps when nothing moves and all samples are there, or nothing can be seen.
        if let Some(open) = &self.open
            && !open.hidden
            && (self.viewer.is_moving() || !open.painter.is_complete(&self.settings))
        {
            open.window.request_redraw();
        }
    }
}

fn action(key: &Key) -> Option<Action> {
    Some(match key {
        Key::Named(NamedKey::Space) => Action::Pause,
        Key::Named(NamedKey::ArrowLeft) => Action::Scrub(-1),
        Key::Named(NamedKey::ArrowRight) => Action::Scrub(1),
        Key::Named(NamedKey::F12) => Action::Screenshot,
        Key::Named(NamedKey::Escape) => Action::Quit,
        Key::Character(text) => {
            let mut characters = text.chars().flat_map(char::to_lowercase);
            let (key, None) = (characters.next()?, characters.next()) else { return None };
            let technique = || Technique::ALL.into_iter().find(|t| t.key() == key).map(Action::Technique);
            return CHARACTERS
                .iter()
                .find(|(character, _)| *character == key)
                .map(|(_, does)| *does)
                .or_else(technique);
        }
        _ => return None,
    })
}

/// Technique, time, frames per second, milliseconds per pass.
fn title(name: &str, viewer: &Viewer, fps: f64, times: &[(String, f64)]) -> String {
    let paused = if viewer.paused { " (paused)" } else { "" };
    let mut title = format!("{name} · {} · {:.2} s{paused} · {fps:.1} fps", viewer.shading(), viewer.time);
    for (pass, milliseconds) in times.iter().filter(|(_, milliseconds)| *milliseconds >= 0.05) {
        title.push_str(&format!(" · {pass} {milliseconds:.1} ms"));
    }
    title
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::settings::Shading;

    fn typed(text: &str) -> Option<Action> {
        action(&Key::Character(text.into()))
    }

    #[test]
    fn every_technique_has_a_key_of_its_own() {
        for technique in Technique::ALL {
            assert_eq!(typed(&technique.key().to_string()), Some(Action::Technique(technique)));
            assert!(CHARACTERS.iter().all(|(character, _)| *character != technique.key()), "{technique:?}");
        }
        assert_eq!((typed("10"), typed("")), (None, None));
        assert_eq!(typed("Q"), Some(Action::Quit));
    }

    #[test]
    fn the_title_tells_technique_time_and_passes() {
        let pose = crate::scenes::view::CameraPose {
            position: [1.0; 3],
            target: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            fov_degrees: 40.0,
        };
        let mut viewer = Viewer::new(Orbit::new(&pose), 1.5, Shading::default());
        viewer.act(Action::Pause);
        viewer.act(typed("4").expect("a key"));
        let times = [("geometry".to_owned(), 3.12), ("sky".to_owned(), 0.001)];
        let said = title("Sphere", &viewer, 29.97, &times);
        assert_eq!(said, "Sphere · lean · 1.50 s (paused) · 30.0 fps · geometry 3.1 ms");
        assert_eq!(typed("x"), None);
    }
}
