//! Draws a frame of the window, and performs the requests of the panel.

use std::path::Path;
use std::time::{Duration, Instant};

use winit::dpi::PhysicalSize;
use winit::event_loop::ActiveEventLoop;

use super::choices::DisplayMode;
use super::loading::{Change, file_name};
use super::over::{Difference, false_colors};
use super::painter::WindowFrame;
use super::panel::paint::Painted;
use super::panel::{Facts, Request};
use super::show::SceneChange;
use super::{MEMORY_SAMPLES, Session, title};
use leadr_maps::RgbImage;
use leadr_maps::shown::shown_line;
use leadr_render::frame::Layer;
use leadr_render::settings::{RenderSettings, Shading};
use leadr_scenes::daylight;
use leadr_scenes::light::SunDirection;
use leadr_tools::bench::MemorySample;
use leadr_tools::command::error::AppError;

/// Time above which a user needs a message about the work.
const NOTICED: Duration = Duration::from_millis(200);

/// The contents of a picture that need their own pipelines.
type Kind = (Shading, Option<Layer>);

/// Announces pictures of a new kind, because the window stands still while their pipelines are made. Two frames show the old picture with a
/// message before the first new picture.
#[derive(Default)]
pub struct NewKinds {
    known: Vec<Kind>,
    /// The settings of the last picture.
    before: Vec<RenderSettings>,
    /// Number of frames since the announcement.
    announced: u32,
    message: Option<String>,
    /// Drawing time of the last new kind.
    took: Option<Duration>,
}

impl NewKinds {
    fn new_kind(&self, sides: &[RenderSettings], layer: Option<Layer>) -> Option<Kind> {
        sides.iter().map(|side| (side.shading, layer)).find(|kind| !self.known.contains(kind))
    }

    /// Returns the settings of the old picture if this frame still shows the old picture.
    fn announce(&mut self, sides: &[RenderSettings], layer: Option<Layer>) -> Option<Vec<RenderSettings>> {
        let (shading, _) = self.new_kind(sides, layer)?;
        if self.before.is_empty() || self.announced == 2 || self.took.is_some_and(|took| took < NOTICED) {
            return None;
        }
        self.announced += 1;
        self.message = Some(format!("preparing {} ...", layer.map_or(shading.technique().name(), Layer::name)));
        Some(self.before.clone())
    }

    /// Records a picture and its drawing time. Returns whether an announcement ends.
    fn drawn(&mut self, sides: &[RenderSettings], layer: Option<Layer>, took: Duration) -> bool {
        while let Some(kind) = self.new_kind(sides, layer) {
            self.known.push(kind);
            self.took = Some(took);
        }
        self.before = sides.to_vec();
        self.announced = 0;
        self.message.take().is_some()
    }

    /// Forgets the pictures of a replaced renderer.
    pub fn forget(&mut self) {
        self.known.clear();
        self.before.clear();
    }
}

impl Session<'_> {
    pub(super) fn draw(&mut self, events: &ActiveEventLoop) -> Result<(), AppError> {
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
        let saving = self.screenshot_in.map(|_| "saving a screenshot ...".to_owned());
        self.panel.working = self.kinds.message.clone().or(saving).or(self.loading.message());
        let painted = self.lay_out(events)?;
        self.viewer.cover(self.panel.covers(width));
        let wanted = self.viewer.choices.sides(&self.settings);
        let layer = self.viewer.choices.display_mode.layer();
        let old = self.kinds.announce(&wanted, layer);
        let (is_old, sides) = (old.is_some(), old.unwrap_or(wanted));
        let changed = self.viewer.take_changed();
        let state = changed.then(|| {
            let mut state = (self.scene)(self.viewer.time);
            self.surroundings.light(&mut state);
            state.camera = self.viewer.camera(&state.camera, width as f32);
            self.viewer.choices.apply(&mut state);
            daylight::pass(&mut state, self.viewer.sun_hours);
            self.has_own_sun = state.sky.is_some() && state.sun.is_some();
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
        let began = Instant::now();
        let shown = self.painter.draw(WindowFrame {
            size: [width, height],
            state,
            sides: &sides,
            pace: &self.pace,
            exposure: self.exposure,
            tonemap: self.viewer.choices.picture.tonemap,
            dithered: self.viewer.choices.picture.dither,
            split: self.viewer.split_at(width as f32).map_or(1.0, |pixels| pixels / width as f32),
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
        if let Some(layer) = layer.filter(|_| !is_old && (changed || still && !self.layer_is_still)) {
            self.layer_is_still = still;
            let read = self.painter.layer(layer)?;
            match self.viewer.choices.display_mode {
                DisplayMode::Ellipses => self.panel.ellipses = Some(read),
                DisplayMode::Probes => self.panel.balls = Some(self.painter.probes(&read)),
                _ => self.panel.lay_over(Some(false_colors(layer, &read))),
            }
            self.window.request_redraw();
        }
        if is_old {
            self.viewer.invalidate();
        } else if self.kinds.drawn(&sides, layer, began.elapsed()) {
            self.window.request_redraw();
        }
        self.compare()?;
        self.count_frame(&sides)?;
        if self.report.frames == 1 {
            self.loading.request(Change::Scene(SceneChange::Complete));
        }
        self.save_screenshot();
        if self.options.frames.is_some_and(|frames| self.report.frames >= frames) {
            events.exit();
        }
        Ok(())
    }

    /// Counts a frame, and updates the title and the report.
    fn count_frame(&mut self, sides: &[RenderSettings]) -> Result<(), AppError> {
        self.clock.running = self.viewer.is_moving();
        self.report.frames += 1;
        let now = Instant::now();
        // The final frame updates the title, because no frame follows it.
        let PhysicalSize { width, height } = self.size;
        let last = !self.viewer.is_moving() && self.painter.is_complete([width, height], sides);
        if self.clock.is_due(now) || self.report.frames == 1 || last {
            self.clock.measure(now);
            if last {
                self.painter.finish()?;
            }
            let scene = file_name(Path::new(self.program.scene()));
            let name = if scene.is_empty() { &self.options.title } else { &scene };
            self.window.set_title(&shown_line(&title(name, &self.viewer, self.clock.fps)));
        }
        if let Some(frames) = self.options.frames
            && frames >= MEMORY_SAMPLES
            && self.report.frames.is_multiple_of(frames / MEMORY_SAMPLES)
        {
            self.report.memory.push(MemorySample::after(self.report.frames, self.painter.gpu()));
        }
        Ok(())
    }

    /// Lays out the panel and performs the user's requests.
    fn lay_out(&mut self, events: &ActiveEventLoop) -> Result<Painted, AppError> {
        let environments = self.surroundings.names();
        let (pixels, triangles) = self.painter.drawn();
        let device = self.painter.gpu().device_name().to_owned();
        let facts = Facts {
            scenes: self.program.scenes(),
            scene: self.program.scene(),
            animations: &self.animations.names,
            animation: self.animations.current,
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
                Request::Act(action) => self.act(events, action),
                Request::Open(path) => self.open(path),
                Request::Animation(name) => self.change(SceneChange::Flag("animation", Some(name))),
                Request::Environment(number) => {
                    self.loading.request(Change::Environment(self.surroundings.choice(number)));
                }
                Request::Roughness(alpha) => {
                    self.change(SceneChange::Flag("roughness", alpha.map(|alpha| alpha.to_string())));
                }
                Request::OwnMaterial => self.change(SceneChange::Material(None)),
                Request::View(number) => {
                    if let Some(orbit) = self.views.and_then(|views| views.get(number).copied()) {
                        self.viewer.orbit = orbit;
                        self.viewer.invalidate();
                    }
                }
            }
        }
        let options = &mut self.viewer.choices.picture.options;
        if let Some(shown) = self.program.relief_color()
            && options.relief_color != shown
        {
            // The option changes when its maps are loaded.
            let wanted = if options.relief_color { "on" } else { "off" };
            options.relief_color = shown;
            self.change(SceneChange::Flag("relief-color", Some(wanted.to_owned())));
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_render::settings::Technique;

    #[test]
    fn slow_new_pictures_are_announced() {
        let side = |technique: Technique| RenderSettings { shading: technique.into(), ..Default::default() };
        let (leadr, lean) = ([side(Technique::Leadr)], [side(Technique::Lean)]);
        let mut kinds = NewKinds::default();
        assert_eq!(kinds.announce(&leadr, None), None, "no old picture");
        assert!(!kinds.drawn(&leadr, None, NOTICED));
        for _ in 0..2 {
            assert_eq!(kinds.announce(&lean, None), Some(leadr.to_vec()));
            assert!(kinds.message.as_ref().is_some_and(|message| message.contains("lean")));
        }
        assert_eq!(kinds.announce(&lean, None), None);
        assert!(kinds.drawn(&lean, None, NOTICED / 2) && kinds.message.is_none());
        // Known pictures and those of a fast device need no message.
        assert_eq!(kinds.announce(&leadr, None), None);
        assert_eq!(kinds.announce(&lean, Some(Layer::Depth)), None);
    }
}
