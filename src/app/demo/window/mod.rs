//! The window of `leadr demo`, which handles events and draws frames. `keys` maps keys to actions, and [`panel`] has the controls.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalSize, Size};
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{Key, ModifiersState, NamedKey};
use winit::window::{Fullscreen, Window, WindowId};

use super::command_line::Seen;
use choices::{Choices, DisplayMode};
use clock::FrameClock;
pub use display::Display;
use layout::Layout;
use leadr_gpu::Gpu;
use leadr_gpu::shader_watch::{Change, ShaderWatch};
use leadr_maps::save::save_png_srgb8;
use leadr_maps::shown::{shown_line, shown_path};
use leadr_maps::{Rgb8Image, RgbImage};
use leadr_render::scene::FrameState;
use leadr_render::settings::RenderSettings;
use leadr_scenes::config::Picture;
use leadr_scenes::daylight;
use leadr_scenes::light::{EnvironmentChoice, SunDirection};
use leadr_tools::bench::MemorySample;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::extension;
use over::{Difference, false_colors};
use pace::{KeptQuality, Pace};
use painter::{Painter, WindowFrame};
use panel::{Facts, Panel, Request};
use show::{Program, Show};
use surroundings::Surroundings;
use viewer::{Action, Drag, SPLIT_GRIP, Viewer};

pub mod choices;
mod clock;
mod display;
mod keys;
pub mod layout;
mod over;
pub mod pace;
mod painter;
pub mod panel;
mod probes;
pub mod show;
pub mod surroundings;
pub mod viewer;

/// Interval for polling a running comparison of two pictures.
const ASK_INTERVAL: Duration = Duration::from_millis(50);

/// Number of memory samples in a run with a fixed number of frames.
const MEMORY_SAMPLES: u64 = 10;

/// Options of the window. The [`RenderSettings`] set the default size.
#[derive(Clone, Debug)]
pub struct WindowOptions {
    /// First words of the window title.
    pub title: String,
    /// Animation time at the start, seconds.
    pub time: f64,
    /// Picture settings at the start; `None` takes them from the [`RenderSettings`].
    pub picture: Option<Picture>,
    /// Path prefix of screenshots; `-1.png`, `-2.png`, … are appended. Existing files are not overwritten.
    pub screenshots: PathBuf,
    /// Number of frames after which the window closes; `None` leaves it open.
    pub frames: Option<u64>,
    /// Quality that does not change while something moves.
    pub kept: KeptQuality,
    /// Layout at the start. Without a size, the window has the size of the [`RenderSettings`]. By default the panel is shown if there is
    /// room.
    pub layout: Layout,
    /// File to which the layout is written when the window closes.
    pub layout_file: Option<PathBuf>,
    /// Folder of shader sources that are recompiled on a change.
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
    /// Number of frames shown.
    pub frames: u64,
    /// Milliseconds between the starts of consecutive frames of an animation.
    pub milliseconds: Vec<f32>,
    /// Paths of the screenshots.
    pub screenshots: Vec<PathBuf>,
    /// Memory at ten evenly spaced moments, if the window closes after a fixed number of at least ten frames.
    pub memory: Vec<MemorySample>,
}

impl WindowReport {
    /// Returns the median and 95th percentile of the milliseconds between frames; 0 if there are none.
    pub fn frame_times(&self) -> [f32; 2] {
        let mut sorted = self.milliseconds.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        [0.5, 0.95].map(|share| {
            let index = (share * sorted.len() as f64) as usize;
            sorted.get(index).copied().unwrap_or(0.0)
        })
    }
}

/// Shows a scene in a window until the user closes it. The orbit camera replaces the scene's camera and follows its target. A still picture
/// accumulates `settings.samples` samples. `program` opens other scenes. The renderer's device must be opened with
/// [`Display::gpu_options`].
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
            options,
            modifiers: ModifiersState::empty(),
            report: WindowReport::default(),
            lost: None,
        })
    };
    let mut app = App { open: Some(open), session: None, ended: Ok(WindowReport::default()) };
    let ended = display.events.run_app(&mut app).map_err(|e| AppError::Failed(format!("the window failed: {e}")));
    let report = app.ended?;
    ended?;
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
    /// Window size in pixels from the last event. A size query panics if another program has closed the window.
    size: PhysicalSize<u32>,
    /// Whether the system reports the window as fully covered. No frame is drawn while it is.
    occluded: bool,
    /// Whether the window was minimised or had no area at the last attempt to draw. No frame is drawn until an event.
    hidden: bool,
    clock: FrameClock,
    scene: Box<dyn FnMut(f64) -> FrameState>,
    views: Option<[super::orbit::Orbit; 3]>,
    settings: RenderSettings,
    surroundings: Surroundings,
    program: &'p mut dyn Program,
    /// Watches and recompiles changed shaders.
    shaders: Option<ShaderWatch>,
    viewer: Viewer,
    pace: Pace,
    options: WindowOptions,
    /// Exposure factor of the current picture.
    exposure: f32,
    /// Direction of the picture's sun.
    sun: Option<SunDirection>,
    modifiers: ModifiersState,
    report: WindowReport,
    /// The first error of a screenshot.
    lost: Option<AppError>,
}

impl Session<'_> {
    fn draw(&mut self, events: &ActiveEventLoop) -> Result<(), AppError> {
        let PhysicalSize { width, height } = self.size;
        self.hidden = self.occluded || width == 0 || height == 0 || self.window.is_minimized() == Some(true);
        if self.hidden {
            // The next frame waits for an event, and time is paused while the window is hidden.
            self.clock.pause();
            self.pace.interrupt();
            return Ok(());
        }
        let interval = self.clock.begin(Instant::now());
        if let Some(interval) = interval {
            self.viewer.advance(interval.took.as_secs_f64());
        }
        match interval.filter(|interval| interval.followed) {
            Some(interval) => {
                let milliseconds = interval.took.as_secs_f32() * 1000.0;
                self.report.milliseconds.push(milliseconds);
                self.panel.frame_took(milliseconds);
                self.pace.frame(milliseconds);
            }
            None => self.pace.interrupt(),
        }
        let painted = self.lay_out(events)?;
        let sides = self.viewer.choices.sides(&self.settings);
        let changed = self.viewer.take_changed();
        let state = changed.then(|| {
            let mut state = (self.scene)(self.viewer.time);
            self.surroundings.light(&mut state);
            state.camera = self.viewer.camera(&state.camera);
            self.viewer.choices.apply(&mut state);
            daylight::pass(&mut state, self.viewer.sun_hours);
            self.sun = state.sky.as_ref().map(|sky| SunDirection::of(sky.sun_direction));
            self.exposure = self.viewer.choices.picture.exposure.exp2() * state.exposure();
            state
        });
        if changed {
            self.layer_is_still = false;
            self.difference = Difference::default();
            self.panel.lay_over(None);
            (self.panel.ellipses, self.panel.balls) = (None, None);
        }
        let split = self.viewer.choices.compare.map_or(1.0, |compare| compare.split);
        let shown = self.painter.draw(WindowFrame {
            size: [width, height],
            state,
            sides: &sides,
            pace: &self.pace,
            exposure: self.exposure,
            tonemap: self.viewer.choices.picture.tonemap,
            dithered: self.viewer.choices.picture.dither,
            split,
            panel: painted,
        })?;
        self.hidden = !shown;
        if !shown {
            if changed {
                self.viewer.invalidate();
            }
            return Ok(());
        }
        // A layer is read back from every moving picture, and once from the still picture, which has all pixels.
        let still = self.painter.is_complete([width, height], &sides);
        if let Some(layer) =
            self.viewer.choices.display_mode.layer().filter(|_| changed || still && !self.layer_is_still)
        {
            self.layer_is_still = still;
            let read = self.painter.layer(layer)?;
            match self.viewer.choices.display_mode {
                DisplayMode::Ellipses => self.panel.ellipses = Some(read),
                DisplayMode::Probes => self.panel.balls = Some(self.painter.probes(&read)),
                _ => self.panel.lay_over(Some(false_colors(layer, &read))),
            }
            self.window.request_redraw();
        }
        self.compare()?;
        self.clock.running = self.viewer.is_moving();
        self.report.frames += 1;
        let now = Instant::now();
        // The final frame updates the title, because no frame follows it.
        let last = !self.viewer.is_moving() && self.painter.is_complete([width, height], &sides);
        if self.clock.is_due(now) || self.report.frames == 1 || last {
            self.clock.measure(now);
            if last {
                self.painter.finish()?;
            }
            let title = title(&self.options.title, &self.viewer, self.clock.fps, self.painter.times());
            self.window.set_title(&shown_line(&title));
        }
        if let Some(frames) = self.options.frames {
            if frames >= MEMORY_SAMPLES && self.report.frames.is_multiple_of(frames / MEMORY_SAMPLES) {
                self.report.memory.push(MemorySample::after(self.report.frames, self.painter.gpu()));
            }
            if self.report.frames >= frames {
                events.exit();
                return Ok(());
            }
        }
        if self.report.frames == 1 { self.complete() } else { Ok(()) }
    }

    /// Replaces a coarse first scene by the scene at full detail.
    fn complete(&mut self) -> Result<(), AppError> {
        match self.program.complete(self.painter.gpu())? {
            Some(show) => self.show(show),
            None => Ok(()),
        }
    }

    /// Lays out the panel and performs the user's requests.
    fn lay_out(&mut self, events: &ActiveEventLoop) -> Result<panel::paint::Painted, AppError> {
        let environments = self.surroundings.names();
        let (pixels, triangles) = self.painter.drawn();
        let device = self.painter.gpu().device_name().to_owned();
        let facts = Facts {
            scenes: self.program.scenes(),
            scene: self.program.scene(),
            environments: &environments,
            environment: self.surroundings.shown(),
            sun: self.sun.map(|sun| [sun.azimuth, sun.elevation]),
            roughness: self.program.roughness(),
            applied_material: self.program.applied_material(),
            offers: &|choice| self.program.offers(choice),
            device: &device,
            fps: self.clock.fps,
            passes: self.painter.times(),
            samples: self.painter.samples(),
            pixels,
            triangles,
        };
        let (painted, requests) = self.panel.run(&self.window, self.size, &mut self.viewer, &facts);
        for request in requests {
            match request {
                Request::Act(action) => self.act(events, action)?,
                Request::Scene(name) => self.enter(Path::new(&name))?,
                Request::Environment(number) => {
                    let choice = self.surroundings.choice(number);
                    self.surround(choice)?;
                }
                Request::Roughness(alpha) => {
                    let alpha = alpha.map(|alpha| alpha.to_string());
                    self.remake(|program, gpu| program.remake(gpu, "--roughness", alpha))?;
                }
                Request::OwnMaterial => self.remake(|program, gpu| program.apply_material(gpu, None))?,
                Request::View(number) => {
                    if let Some(orbit) = self.views.and_then(|views| views.get(number).copied()) {
                        self.viewer.orbit = orbit;
                        self.viewer.invalidate();
                    }
                }
            }
        }
        let options = &mut self.viewer.choices.picture.options;
        if options.relief_color && !self.program.keeps_relief_color() {
            // The option stays off if the reload fails.
            options.relief_color = false;
            self.remake(|program, gpu| program.remake(gpu, "--relief-color", Some("on".to_owned())))?;
            self.viewer.choices.picture.options.relief_color = self.program.keeps_relief_color();
        }
        Ok(painted)
    }

    /// Shows the difference between the two sides while nothing moves.
    fn compare(&mut self) -> Result<(), AppError> {
        let wanted = self.viewer.choices.compare.is_some_and(|compare| compare.difference);
        if !wanted || self.viewer.is_moving() || self.viewer.choices.display_mode != DisplayMode::Picture {
            return Ok(());
        }
        if let Some(found) = self.difference.found() {
            self.panel.lay_over(Some(found));
            self.window.request_redraw();
        }
        let samples = self.painter.samples();
        if self.difference.needs_samples(samples)
            && let Ok([left, right]) = <[RgbImage; 2]>::try_from(self.painter.pictures()?)
        {
            self.difference.begin(left, right, self.exposure, self.viewer.choices.picture.tonemap, samples);
        }
        Ok(())
    }

    /// Replaces changed shaders if they compile; otherwise the previous shaders stay in use.
    fn reload(&mut self) -> Result<(), AppError> {
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

    fn key(&mut self, events: &ActiveEventLoop, event: &KeyEvent) -> Result<(), AppError> {
        let pressed = event.state == ElementState::Pressed;
        if self.viewer.fly
            && !self.modifiers.control_key()
            && let Some(way) = keys::flies(event.physical_key)
        {
            if !event.repeat {
                let held = self.viewer.held + if pressed { way } else { -way };
                self.viewer.held = held.clamp(Vec3::NEG_ONE, Vec3::ONE);
            }
            // Time before the key press must not move the camera.
            if !self.viewer.is_moving() {
                self.clock.pause();
            }
            return Ok(());
        }
        if !pressed {
            return Ok(());
        }
        let Some(action) = keys::action(&event.logical_key) else { return Ok(()) };
        // Key repeat applies to steps, but not to toggles.
        if event.repeat && !matches!(action, Action::Scrub(_) | Action::Frame(_) | Action::Sun(_)) {
            return Ok(());
        }
        self.act(events, action)
    }

    fn act(&mut self, events: &ActiveEventLoop, action: Action) -> Result<(), AppError> {
        match action {
            Action::Quit => events.exit(),
            Action::Screenshot => {
                // An error such as a full disk must not close the window.
                if let Err(error) = self.screenshot() {
                    self.complain(&error);
                    self.lost.get_or_insert(error);
                }
            }
            Action::Environment => {
                let next = self.surroundings.next();
                return self.surround(next);
            }
            Action::CopyCommand => self.copy_command(),
            Action::Panel => self.panel.open = !self.panel.open,
            Action::Help => self.panel.help = !self.panel.help,
            Action::FullScreen => {
                let whole = self.window.fullscreen().is_none().then_some(Fullscreen::Borderless(None));
                self.window.set_fullscreen(whole);
            }
            _ => self.viewer.act(action),
        }
        self.window.request_redraw();
        Ok(())
    }

    /// Logs and shows an error without closing the window.
    fn complain(&mut self, error: &AppError) {
        tracing::error!("{error}");
        self.panel.warn(error.to_string());
        self.window.request_redraw();
    }

    fn copy_command(&mut self) {
        let PhysicalSize { width, height } = self.size;
        let seen = Seen {
            choices: &self.viewer.choices,
            pose: self.viewer.orbit.pose(),
            time: self.viewer.time,
            size: [width, height],
            sun: self.sun,
        };
        if let Some(command) = self.program.command(&seen) {
            tracing::info!("{command}");
            self.panel.say(format!("copied: {command}"));
            self.panel.copy(command);
        }
    }

    /// Changes the environment. After an error the current environment stays.
    fn surround(&mut self, choice: EnvironmentChoice) -> Result<(), AppError> {
        match self.surroundings.show(self.painter.gpu(), choice) {
            Ok(environment) => {
                self.painter.surround(environment)?;
                self.program.surround(&self.surroundings.names()[self.surroundings.shown()]);
                self.viewer.invalidate();
                self.window.request_redraw();
            }
            Err(error) => self.complain(&error),
        }
        Ok(())
    }

    /// Opens another scene. After an error the current scene stays.
    fn enter(&mut self, name: &Path) -> Result<(), AppError> {
        match self.program.open(self.painter.gpu(), name) {
            Ok(mut show) => {
                let moves = show.moves();
                self.painter.replace(show.renderer)?;
                self.clock.pause();
                (self.scene, self.views, self.surroundings) = (show.scene, show.views, show.surroundings);
                self.viewer.enter(show.orbit, show.sweep, moves);
                self.pace.interrupt();
                self.window.request_redraw();
            }
            Err(error) => self.complain(&error),
        }
        Ok(())
    }

    /// Rebuilds the scene with other surfaces in the same view. After an error the current scene stays.
    fn remake(
        &mut self,
        make: impl FnOnce(&mut dyn Program, &Arc<Gpu>) -> Result<Show, AppError>,
    ) -> Result<(), AppError> {
        match make(&mut *self.program, self.painter.gpu()) {
            Ok(show) => self.show(show),
            Err(error) => {
                self.complain(&error);
                Ok(())
            }
        }
    }

    /// Shows the same scene with other surfaces in the same view.
    fn show(&mut self, show: Show) -> Result<(), AppError> {
        self.painter.replace_keeping_environment(show.renderer)?;
        self.clock.pause();
        self.scene = show.scene;
        self.viewer.invalidate();
        self.pace.interrupt();
        self.window.request_redraw();
        Ok(())
    }

    fn dropped(&mut self, path: PathBuf) -> Result<(), AppError> {
        match extension(&path).as_deref() {
            Some("glb" | "gltf") => self.enter(&path),
            Some("json") => self.remake(|program, gpu| program.apply_material(gpu, Some(&path))),
            _ if path.is_dir() => self.remake(|program, gpu| program.apply_material(gpu, Some(&path))),
            _ => match Surroundings::dropped(path) {
                Ok(choice) => self.surround(choice),
                Err(error) => {
                    self.complain(&error);
                    Ok(())
                }
            },
        }
    }

    fn screenshot(&mut self) -> Result<(), AppError> {
        let pictures: Vec<Rgb8Image> = self
            .painter
            .pictures()?
            .iter()
            .map(|picture| self.viewer.choices.picture.codes(picture.width, &picture.texels, self.exposure))
            .collect();
        let split = self.viewer.choices.compare.map_or(1.0, |compare| compare.split);
        let Some(picture) = side_by_side(pictures, split) else { return Ok(()) };
        let stem = self.options.screenshots.as_os_str();
        let path = |number: u32| {
            let mut name = stem.to_owned();
            name.push(format!("-{number}.png"));
            PathBuf::from(name)
        };
        let path = (1..).map(path).find(|path| !path.exists()).unwrap_or_default();
        save_png_srgb8(&path, &picture)?;
        tracing::info!("saved {}", shown_path(&path));
        self.panel.say(format!("saved {}", shown_path(&path)));
        self.report.screenshots.push(path);
        Ok(())
    }

    fn handle(&mut self, events: &ActiveEventLoop, event: WindowEvent) -> Result<(), AppError> {
        let tab = matches!(&event, WindowEvent::KeyboardInput { event, .. } if event.logical_key == Key::Named(NamedKey::Tab));
        let (consumed, redraw) = if tab { (false, false) } else { self.panel.event(&self.window, &event) };
        if redraw {
            self.window.request_redraw();
        }
        match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => events.exit(),
            WindowEvent::RedrawRequested => return self.draw(events),
            WindowEvent::Occluded(occluded) => {
                self.occluded = occluded;
                self.hidden = occluded;
                self.window.request_redraw();
            }
            WindowEvent::Resized(size) => {
                self.size = size;
                self.hidden = false;
                self.window.request_redraw();
            }
            WindowEvent::Focused(true) => {
                self.hidden = false;
                self.window.request_redraw();
            }
            WindowEvent::Focused(false) => self.viewer.held = Vec3::ZERO,
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } if !consumed => {
                return self.key(events, &event);
            }
            WindowEvent::DroppedFile(path) => return self.dropped(path),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::MouseInput { state, button, .. } => {
                let grip = SPLIT_GRIP * self.window.scale_factor() as f32;
                let width = self.size.width as f32;
                let at_split = self.viewer.pointer.is_some_and(|[x, _]| self.viewer.is_at_split(x, width, grip));
                let drag = match button {
                    MouseButton::Left if at_split => Some(Drag::Split),
                    MouseButton::Left if self.modifiers.shift_key() => Some(Drag::Pan),
                    MouseButton::Left if self.viewer.fly => Some(Drag::Look),
                    MouseButton::Left => Some(Drag::Rotate),
                    MouseButton::Right => Some(Drag::Pan),
                    _ => return Ok(()),
                };
                self.viewer.drag = drag.filter(|_| state == ElementState::Pressed && !consumed);
            }
            WindowEvent::CursorMoved { position, .. } => {
                let size = [self.size.width as f32, self.size.height as f32];
                self.viewer.move_pointer([position.x as f32, position.y as f32], size);
                if std::mem::take(&mut self.viewer.redraw) {
                    self.window.request_redraw();
                }
            }
            WindowEvent::MouseWheel { delta, .. } if !consumed => self.viewer.wheel(match delta {
                MouseScrollDelta::LineDelta(_, lines) => lines,
                MouseScrollDelta::PixelDelta(position) => position.y as f32 / 40.0,
            }),
            _ => return Ok(()),
        }
        Ok(())
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

    /// Requests a frame if the panel or a comparison needs one without an event.
    fn wake(&self) {
        let wakes = self.panel.wakes.is_some_and(|wakes| wakes <= Instant::now());
        if self.difference.is_running() || wakes {
            self.window.request_redraw();
        }
    }

    /// Requests a frame if one is needed, and sets the time of the next wake-up.
    fn wait(&mut self, events: &ActiveEventLoop) -> Result<(), AppError> {
        self.reload()?;
        if self.hidden {
            events.set_control_flow(ControlFlow::Wait);
            return Ok(());
        }
        let PhysicalSize { width, height } = self.size;
        let sides = self.viewer.choices.sides(&self.settings);
        // The loop sleeps when nothing moves and the picture is complete.
        if self.viewer.is_moving() || !self.painter.is_complete([width, height], &sides) {
            self.window.request_redraw();
        }
        let polls = self.difference.is_running() || self.shaders.is_some();
        let poll_at = polls.then(|| Instant::now() + ASK_INTERVAL);
        let wakes = [self.panel.wakes, poll_at].into_iter().flatten().min();
        events.set_control_flow(wakes.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
        Ok(())
    }
}

impl<'p, F: FnOnce(&ActiveEventLoop) -> Result<Session<'p>, AppError>> App<'p, F> {
    /// Runs `work` on an open window, and closes the window if `work` fails.
    fn with(&mut self, events: &ActiveEventLoop, work: impl FnOnce(&mut Session<'p>) -> Result<(), AppError>) {
        if let Some(Err(error)) = self.session.as_mut().map(work) {
            self.end(events, error);
        }
    }

    /// Closes the window with the first error.
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
            // The window stayed open after a failed screenshot, but scripts that wait for the file need the exit code.
            self.ended = session.lost.take().map_or(Ok(session.report), Err);
        }
    }
}

/// Combines the left side of the first picture with the right side of the second, if there is one.
fn side_by_side(pictures: Vec<Rgb8Image>, split: f32) -> Option<Rgb8Image> {
    let mut pictures = pictures.into_iter();
    let (mut left, right) = (pictures.next()?, pictures.next());
    if let Some(right) = right.filter(|right| (right.width, right.height) == (left.width, left.height)) {
        let width = left.width as usize;
        for (index, texel) in left.texels.iter_mut().enumerate() {
            if (index % width) as f32 + 0.5 >= split * width as f32 {
                *texel = right.texels[index];
            }
        }
    }
    Some(left)
}

/// Formats the window title: technique, time, frames per second, milliseconds per pass.
fn title(name: &str, viewer: &Viewer, fps: Option<f64>, times: &[(String, f64)]) -> String {
    let paused = if viewer.paused { " (paused)" } else { "" };
    let mut title = format!("{name} · {} · {:.2} s{paused}", viewer.choices.picture.shading(), viewer.time);
    if let Some(fps) = fps {
        title.push_str(&format!(" · {fps:.1} fps"));
    }
    for (pass, milliseconds) in times.iter().filter(|(_, milliseconds)| *milliseconds >= 0.05) {
        title.push_str(&format!(" · {pass} {milliseconds:.1} ms"));
    }
    title
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::demo::orbit::Orbit;
    use leadr_render::settings::Technique;

    #[test]
    fn title_shows_technique_time_and_passes() {
        let pose = leadr_scenes::view::CameraPose {
            position: [1.0; 3],
            target: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            fov_degrees: 40.0,
        };
        let choices = Choices::new(Picture::of(&RenderSettings::default()));
        let mut viewer = Viewer::new(Orbit::new(&pose), 1.5, choices, None);
        viewer.act(Action::Pause);
        viewer.act(Action::Technique(Technique::Lean));
        let times = [("geometry".to_owned(), 3.12), ("sky".to_owned(), 0.001)];
        let text = title("Sphere", &viewer, Some(29.97), &times);
        assert_eq!(text, "Sphere · lean · 1.50 s (paused) · 30.0 fps · geometry 3.1 ms");
        assert_eq!(title("Sphere", &viewer, None, &[]), "Sphere · lean · 1.50 s (paused)");
    }

    #[test]
    fn a_screenshot_shows_both_sides() {
        let picture = |code: u8| Rgb8Image { width: 4, height: 1, texels: vec![[code; 3]; 4] };
        let codes = |pictures, split| side_by_side(pictures, split).map(|p| p.texels.iter().map(|t| t[0]).collect());
        assert_eq!(codes(vec![picture(1), picture(2)], 0.25), Some(vec![1, 2, 2, 2]));
        assert_eq!(codes(vec![picture(1)], 0.25), Some(vec![1; 4]));
        assert_eq!(codes(Vec::new(), 0.5), None);
    }
}
