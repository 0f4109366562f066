//! What the user of the window has chosen: the view, the time, the technique. Independent of window and device.

use crate::app::demo::orbit::Orbit;
use crate::render::camera::Camera;
use crate::render::settings::{Probes, Quadrature, Shading, ShadingOptions, Technique};

/// Longest step of the animation, seconds: on a slow device it slows down instead of jumping.
const LONGEST_STEP: f64 = 0.1;
/// What the arrow keys move the time by, seconds.
const SCRUB: f64 = 0.5;
/// What `,` and `.` move the time by, seconds.
const FRAME: f64 = 1.0 / 30.0;

/// What `[` and `]` move the sun by, hours.
const SUN_STEP: f64 = 0.5;
/// Paces of the sun, hours per second, in the order in which a key chooses them.
const SUN_PACES: [f64; 3] = [0.0, 24.0 / 120.0, 24.0 / 20.0];

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Stops time or lets it run.
    Pause,
    /// Moves the time back or forward by half a second.
    Scrub(i8),
    /// Stops the time and moves it back or forward by a thirtieth of a second.
    Frame(i8),
    /// Moves the sun back or forward by half an hour.
    Sun(i8),
    /// The next of the sun's paces, in addition to the scene's own.
    SunPace,
    /// Back to the first view, time and sun; time runs.
    Reset,
    /// Another technique.
    Technique(Technique),
    /// The paper's grid instead of the visible-slope rules, or the other way round.
    Rule,
    /// The next shadowing model.
    Shadowing,
    /// The next environment.
    Environment,
    /// Save a screenshot.
    Screenshot,
    /// Quit.
    Quit,
}

/// What dragging does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drag {
    /// Turns the camera around its target.
    Turn,
    /// Moves camera and target sideways.
    Pan,
}

/// The state that keys and the mouse change.
#[derive(Clone, Debug)]
pub struct Viewer {
    /// The camera.
    pub orbit: Orbit,
    /// Moment of the animation, seconds, never negative.
    pub time: f64,
    /// Whether time stands still.
    pub paused: bool,
    /// Hours by which the sun has been moved.
    pub sun_hours: f64,
    sun_pace: usize,
    technique: Technique,
    options: ShadingOptions,
    other_rule: Quadrature,
    start: (Orbit, f64),
    drag: Option<Drag>,
    pointer: Option<[f32; 2]>,
    changed: bool,
}

impl Viewer {
    /// A viewer at the beginning; time runs.
    #[must_use]
    pub fn new(orbit: Orbit, time: f64, shading: Shading) -> Self {
        let (start, drag, pointer) = ((orbit, time), None, None);
        let options = shading.options();
        let other_rule = match options.quadrature {
            Quadrature::Grid(_) => Quadrature::VisibleSlopes(Probes::Sixteen),
            Quadrature::VisibleSlopes(_) => Quadrature::Grid(5),
        };
        Self {
            orbit,
            time,
            paused: false,
            sun_hours: 0.0,
            sun_pace: 0,
            technique: shading.technique(),
            options,
            other_rule,
            start,
            drag,
            pointer,
            changed: true,
        }
    }

    /// How surfaces are shaded. Options that this technique lacks are kept for the next one that has them.
    #[must_use]
    pub fn shading(&self) -> Shading {
        self.technique.with(self.options)
    }

    /// Advances the scene by `seconds`, unless time stands still; the sun moves at its own pace.
    pub fn advance(&mut self, seconds: f64) {
        if !self.paused {
            self.time += seconds.clamp(0.0, LONGEST_STEP);
            self.changed = true;
        }
        if self.sun_pace > 0 {
            self.sun_hours += SUN_PACES[self.sun_pace] * seconds.clamp(0.0, LONGEST_STEP);
            self.changed = true;
        }
    }

    /// Does what a key asks for; [`Action::Environment`], [`Action::Screenshot`] and [`Action::Quit`] are left
    /// to the window.
    pub fn act(&mut self, action: Action) {
        match action {
            Action::Pause => self.paused = !self.paused,
            Action::Scrub(steps) => self.time = (self.time + SCRUB * f64::from(steps)).max(0.0),
            Action::Frame(steps) => {
                self.paused = true;
                self.time = (self.time + FRAME * f64::from(steps)).max(0.0);
            }
            Action::Sun(steps) => self.sun_hours += SUN_STEP * f64::from(steps),
            Action::SunPace => self.sun_pace = (self.sun_pace + 1) % SUN_PACES.len(),
            Action::Reset => {
                (self.orbit, self.time) = self.start;
                (self.sun_hours, self.sun_pace) = (0.0, 0);
                self.paused = false;
            }
            Action::Technique(technique) => self.technique = technique,
            Action::Rule => std::mem::swap(&mut self.options.quadrature, &mut self.other_rule),
            Action::Shadowing => self.options.shadowing = self.options.shadowing.next(),
            Action::Environment | Action::Screenshot | Action::Quit => return,
        }
        self.changed = true;
    }

    /// The user's camera in a scene whose own camera is `own`: it follows what `own` follows, moved by as much as the target of
    /// `own` has moved since the beginning.
    #[must_use]
    pub fn camera(&self, own: &Camera) -> Camera {
        let gone = own.target - self.start.0.target();
        let camera = self.orbit.pose().camera();
        Camera { position: camera.position + gone, target: camera.target + gone, ..camera }
    }

    /// Begins or ends dragging.
    pub fn drag(&mut self, drag: Option<Drag>) {
        self.drag = drag;
    }

    /// The pointer is at these pixels, x right and y down, in a window `height` pixels high.
    pub fn pointer(&mut self, to: [f32; 2], height: f32) {
        if let (Some(from), Some(drag)) = (self.pointer, self.drag) {
            let (right, down) = (to[0] - from[0], to[1] - from[1]);
            match drag {
                Drag::Turn => self.orbit.turn(right, down),
                Drag::Pan => self.orbit.pan(right, down, height),
            }
            self.changed = true;
        }
        self.pointer = Some(to);
    }

    /// Zooms by notches of the wheel, up is closer.
    pub fn wheel(&mut self, notches: f32) {
        self.orbit.zoom(notches.clamp(-50.0, 50.0));
        self.changed = true;
    }

    /// Marks the picture as changed.
    pub fn invalidate(&mut self) {
        self.changed = true;
    }

    /// Whether something has changed since the last call.
    pub fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    /// Whether something has changed, or time runs.
    #[must_use]
    pub fn is_moving(&self) -> bool {
        self.changed || !self.paused || self.sun_pace > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reflectance::masking::shadowing::Shadowing;
    use crate::scenes::view::CameraPose;

    fn viewer() -> Viewer {
        let pose =
            CameraPose { position: [6.0, -8.0, 5.0], target: [0.0, 0.0, 2.0], up: [0.0, 0.0, 1.0], fov_degrees: 40.0 };
        Viewer::new(Orbit::new(&pose), 1.0, Shading::default())
    }

    #[test]
    fn time_runs_unless_it_is_paused_and_never_jumps() {
        let mut viewer = viewer();
        viewer.advance(0.05);
        assert!((viewer.time - 1.05).abs() < 1e-9);
        viewer.advance(60.0);
        assert!((viewer.time - 1.15).abs() < 1e-9);
        viewer.act(Action::Pause);
        assert!(viewer.take_changed());
        viewer.advance(0.05);
        assert!((viewer.time - 1.15).abs() < 1e-9 && !viewer.take_changed() && !viewer.is_moving());
        viewer.act(Action::Frame(1));
        assert!((viewer.time - 1.15 - FRAME).abs() < 1e-9 && viewer.paused && viewer.is_moving());
        for _ in 0..9 {
            viewer.act(Action::Scrub(-1));
        }
        assert_eq!(viewer.time, 0.0);
    }

    #[test]
    fn the_sun_moves_while_the_scene_stands() {
        let mut viewer = viewer();
        viewer.act(Action::Pause);
        viewer.take_changed();
        viewer.advance(0.1);
        assert!(viewer.sun_hours == 0.0 && !viewer.is_moving());
        viewer.act(Action::Sun(-1));
        assert!(viewer.sun_hours == -0.5 && viewer.take_changed());
        viewer.act(Action::SunPace);
        viewer.act(Action::SunPace);
        viewer.advance(0.05);
        assert!((viewer.sun_hours + 0.5 - 0.06).abs() < 1e-9 && viewer.time == 1.0 && viewer.is_moving());
        viewer.act(Action::SunPace);
        viewer.act(Action::Reset);
        assert_eq!(viewer.sun_hours, 0.0);
    }

    #[test]
    fn the_shading_switches_and_comes_back() {
        let mut viewer = viewer();
        let start = viewer.shading();
        viewer.act(Action::Rule);
        assert_ne!(viewer.shading(), start);
        viewer.act(Action::Rule);
        let seen: Vec<Shadowing> = (0..3)
            .map(|_| {
                viewer.act(Action::Shadowing);
                viewer.shading().options().shadowing
            })
            .collect();
        assert!(Shadowing::MAIN.iter().all(|v| seen.contains(v)) && viewer.shading() == start);
    }

    #[test]
    fn options_outlast_a_technique_without_them() {
        let mut viewer = viewer();
        viewer.act(Action::Rule);
        let start = viewer.shading();
        viewer.act(Action::Technique(Technique::Lean));
        assert_eq!(viewer.shading(), Technique::Lean.into());
        viewer.act(Action::Technique(Technique::Leadr));
        assert_eq!(viewer.shading(), start);
    }

    #[test]
    fn dragging_turns_pans_and_stops() {
        let mut viewer = viewer();
        viewer.take_changed();
        let start = viewer.orbit;
        viewer.pointer([10.0, 10.0], 100.0);
        assert!(viewer.orbit == start && !viewer.take_changed());
        viewer.drag(Some(Drag::Turn));
        viewer.pointer([30.0, 15.0], 100.0);
        assert!(viewer.orbit != start && viewer.take_changed());
        assert_eq!(viewer.orbit.pose().target, start.pose().target);
        viewer.drag(Some(Drag::Pan));
        viewer.pointer([40.0, 15.0], 100.0);
        assert_ne!(viewer.orbit.pose().target, start.pose().target);
        viewer.drag(None);
        let panned = viewer.orbit;
        viewer.pointer([90.0, 90.0], 100.0);
        assert_eq!(viewer.orbit, panned);
        viewer.act(Action::Reset);
        assert_eq!((viewer.orbit, viewer.time), (start, 1.0));
    }

    #[test]
    fn the_camera_goes_along_with_what_the_scene_follows() {
        let mut viewer = viewer();
        let start = viewer.orbit.pose().camera();
        let gone = glam::Vec3::new(7.0, 1.0, 0.0);
        let own = Camera { position: start.position + gone, target: start.target + gone, ..start };
        let camera = viewer.camera(&own);
        assert!(camera.position.distance(own.position) < 1e-4 && camera.target == own.target);
        // A turn keeps the distance to what is followed, a pan its offset.
        viewer.orbit.turn(100.0, 0.0);
        let turned = viewer.camera(&own);
        assert!(turned.target == own.target && turned.position.distance(own.position) > 1.0);
        viewer.orbit.pan(50.0, 0.0, 100.0);
        let aside = viewer.camera(&own).target - own.target;
        assert!(aside.distance(viewer.orbit.target() - start.target) < 1e-4 && aside.length() > 0.1);
    }

    #[test]
    fn the_wheel_never_reaches_the_target() {
        let mut viewer = viewer();
        for _ in 0..1000 {
            viewer.wheel(f32::MAX);
        }
        let pose = viewer.orbit.pose();
        let distance = glam::Vec3::from_array(pose.position).distance(glam::Vec3::from_array(pose.target));
        assert!((0.1..1.0).contains(&distance), "{distance}");
    }
}
